"""Settings of a network: depth planes, matching, fusion, channels, normalisation."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ...core.model import Model, Ordered
from .baselines.settings import DenseFusionSettings, KeyPoseSettings, SimNetSettings

NetworkName = Literal["mvtrans", "simnet", "keypose", "densefusion"]
Variant = Literal["corrected", "reference"]
Norm = Literal["batch", "group"]
Depth = Literal["resnet18", "resnet50"]
#: Height and width of images are multiples of this [px]: the coarsest features are at 1/32 of the image size.
SIZE_MULTIPLE = 32
_Count = Annotated[int, Field(ge=1, le=64)]
_Metres = Annotated[float, Field(gt=0.0, le=1000.0)]


class NetworkSettings(Model):
    """Settings of a network: its name and variant, those of MVTrans, and those of each of the others.

    The reference variant of MVTrans uses `variant` alone.
    """

    name: NetworkName = Field(
        default="mvtrans",
        description="mvtrans; simnet and keypose, which take stereo pairs; densefusion, which takes depth and masks",
    )
    variant: Variant = Field(
        default="corrected", description="corrected: as its paper describes it, mended; reference: as it was released"
    )
    depth_range: Annotated[tuple[_Metres, _Metres], Ordered] | None = Field(
        default=None, description="Depth of the first and the last plane [m]; by default the range of the training data"
    )
    planes: int = Field(default=32, ge=2, le=512, description="Number of depth planes of the plane sweep")
    spacing: Literal["linear", "inverse"] = Field(
        default="linear", description="Planes at equal steps of depth (linear) or of 1 / depth, disparity (inverse)"
    )
    matching: Literal["concat", "group"] = Field(
        default="concat", description="Cost volume from concatenated features, or from group-wise correlation"
    )
    groups: int = Field(default=8, ge=1, le=64, description="Groups of the correlation; divides feature_channels")
    fusion: Literal["mean", "visibility"] = Field(
        default="mean", description="Mean over the views that see a point, or weighted by how sharp each match is"
    )
    readout: Literal["soft", "windowed"] = Field(
        default="soft",
        description="Coarse depth: expectation over all planes (soft argmin), or over those around the most probable "
        "one, trained with cross-entropy over planes (windowed)",
    )
    window: int = Field(
        default=2, ge=1, le=16, description="Planes to each side of the most probable one, for the windowed readout"
    )
    feature_channels: int = Field(default=32, ge=4, le=256, description="Channels of the matching features")
    feature_width: int = Field(default=32, ge=4, le=256, description="Channels of the first matching layers")
    feature_blocks: tuple[_Count, _Count, _Count, _Count] = Field(
        default=(3, 6, 3, 3), description="Residual blocks of the matching layers; PSMNet has 16 in the second"
    )
    volume_channels: int = Field(default=32, ge=2, le=256, description="Channels of the cost volume")
    context: Depth | Literal["efficientnet-lite0"] = Field(
        default="resnet50",
        description="Context network, which sees the reference image; efficientnet-lite0 begins with weights for "
        "ImageNet (needs the extra `encoder`)",
    )
    context_width: int = Field(
        default=64, ge=4, le=256, description="First channels of a ResNet there; 64 in torchvision"
    )
    decoder_width: int = Field(
        default=64, ge=4, le=256, description="Channels of the context decoder at 1/4 of the image size"
    )
    backbone_width: int = Field(default=64, ge=4, le=256, description="First channels of the ResNet-18 of the backbone")
    pyramid_channels: int = Field(default=64, ge=4, le=256, description="Channels of the feature pyramid")
    head_channels: int = Field(default=32, ge=4, le=256, description="Channels of the heads")
    box_depth: Literal["absolute", "coarse"] = Field(
        default="coarse",
        description="Depth of box centres: a map of its own, as in the paper (absolute), or one that is added to the "
        "coarse depth (coarse)",
    )
    heads_see_context: bool = Field(
        default=False,
        description="Whether the maps of the context decoder enter the backbone of all heads beside matching features "
        "and coarse depth, or the cost volume alone, as in the paper",
    )
    objects_at: Literal["full", "half"] = Field(
        default="full",
        description="Size of the pictures in which objects are found: full, that of matching; or half of it, where "
        "matching needs finer pictures than recognition",
    )
    refinement: Literal["none", "half", "semi_global"] = Field(
        default="none",
        description="half: the full-size depth is corrected at 1/2 of the image size, by a choice among planes around "
        "it, depths at which the pictures are most alike, and the plane of the table; semi_global: also depths of "
        "semi-global matching whose costs grow with the distance from the depth found so far",
    )
    recompute: Literal["nothing", "early", "features"] = Field(
        default="early",
        description="Gradient checkpointing, less memory for more time: of nothing, of the first matching layers, of "
        "all matching layers",
    )
    norm: Norm = Field(default="batch", description="Normalisation of all layers but ResNets and heads")
    head_norm: Norm = Field(default="group", description="Normalisation of the heads; group in the paper")
    simnet: SimNetSettings = SimNetSettings()
    keypose: KeyPoseSettings = KeyPoseSettings()
    densefusion: DenseFusionSettings = DenseFusionSettings()

    @model_validator(mode="before")
    @classmethod
    def _of_name(cls, data: Any) -> Any:
        """Take a name for the settings with that name, as in a file with ``network: simnet``."""
        return {"name": data} if isinstance(data, str) else data
