"""What a network is made of."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model, Ordered
from .layers import Norm
from .resnet import Depth

_Count = Annotated[int, Field(ge=1, le=64)]
_Metres = Annotated[float, Field(gt=0.0, le=1000.0)]


class NetworkSettings(Model):
    """A network; all but `variant` belongs to the corrected one."""

    variant: Literal["corrected", "reference"] = Field(
        default="corrected", description="What the paper describes, or what was released with its faults"
    )
    depth_range: Annotated[tuple[_Metres, _Metres], Ordered] | None = Field(
        default=None, description="Depth of the first and the last plane [m]; by default the range of the training data"
    )
    planes: int = Field(default=32, ge=2, le=512, description="Planes of the sweep, 2 to 512")
    spacing: Literal["linear", "inverse"] = Field(
        default="linear", description="Equal steps of depth, or of its inverse, which are equal steps in the picture"
    )
    matching: Literal["concat", "group"] = Field(
        default="concat", description="Features of two views side by side, or correlated in groups of channels"
    )
    groups: int = Field(default=8, ge=1, le=64, description="Groups of the correlation; divides feature_channels")
    fusion: Literal["mean", "visibility"] = Field(
        default="mean", description="Mean over the views that see a point, or weighted by how sure each match is"
    )
    readout: Literal["soft", "windowed"] = Field(
        default="soft",
        description="Expectation over all planes, or round the likeliest one, trained with cross-entropy over planes",
    )
    window: int = Field(
        default=2, ge=1, le=16, description="Planes to each side of the likeliest, with windowed readout"
    )
    feature_channels: int = Field(default=32, ge=4, le=256, description="Channels of the matched features")
    feature_width: int = Field(default=32, ge=4, le=256, description="Channels of the first matching layers")
    feature_blocks: tuple[_Count, _Count, _Count, _Count] = Field(
        default=(3, 6, 3, 3), description="Residual blocks of the matching layers; PSMNet has 16 in the second"
    )
    volume_channels: int = Field(default=32, ge=2, le=256, description="Channels of the volume that is regularised")
    context: Depth = Field(default="resnet50", description="Network of the reference picture")
    context_width: int = Field(default=64, ge=4, le=256, description="Its first channels; 64 is torchvision's")
    decoder_width: int = Field(default=64, ge=4, le=256, description="Channels of its decoder at a quarter of the size")
    backbone_width: int = Field(default=64, ge=4, le=256, description="First channels of the ResNet-18 of the backbone")
    pyramid_channels: int = Field(default=64, ge=4, le=256, description="Channels of the feature pyramid")
    head_channels: int = Field(default=32, ge=4, le=256, description="Channels of the heads")
    recompute: Literal["nothing", "early", "features"] = Field(
        default="early",
        description="What is computed again for the backward pass, for less memory and more time: nothing, the first "
        "layers of the matching features, all of their layers",
    )
    norm: Norm = Field(default="batch", description="Normalisation of all but residual networks and heads")
    head_norm: Norm = Field(default="group", description="Normalisation of the heads; the paper's is by group")
