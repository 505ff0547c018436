"""Settings of the networks that MVTrans is compared with; what is empty follows from the training data."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ....core.model import Model
from ....core.user_text import UserPath

_Side = Annotated[int, Field(ge=16, le=2048)]
#: An order of keypoints, such as 1-0-2.
_Order = Annotated[str, Field(pattern=r"^\d+(-\d+)*$")]


class SimNetSettings(Model):
    """Settings of SimNet."""

    bins: int | None = Field(
        default=None,
        ge=2,
        le=512,
        description="Disparities of the matching at 1/4 of the image size, from 0 in steps of 4 px; by default as many "
        "as the nearest object of the training data needs (focal length x baseline / depth / 4, and one more); the "
        "released network has 22",
    )


class KeyPoseSettings(Model):
    """Settings of KeyPose."""

    head: Literal["regression", "integral"] = Field(
        default="regression", description="Keypoints as means of maps over all pixels, or as expectations of heatmaps"
    )
    points: Literal["axis", "stored"] = Field(
        default="axis",
        description="Keypoints: top and bottom of the object on its z axis (of a ball its centre twice), or those of "
        "objects.json in their order",
    )
    count: int | None = Field(
        default=None, ge=1, le=64, description="Number of keypoints; by default that of the training data's objects"
    )
    crop: tuple[_Side, _Side] = Field(
        default=(120, 180), description="Height and width of the window around an object [px]"
    )
    dither: float = Field(
        default=20.0 / 180.0, ge=0.0, le=0.5, description="Greatest shift of a window in training [window widths]"
    )
    filters: int = Field(default=48, ge=2, le=512, description="Channels of the convolutions")
    orderings: tuple[_Order, ...] = Field(
        default=(),
        description="Orders of the stored keypoints that look the same, such as 1-0-2; the least loss of them counts",
    )
    mirror_order: _Order | None = Field(
        default=None,
        description="Order of the stored keypoints in the mirror image, such as 1-0-2; by default the same",
    )
    flip: float = Field(
        default=0.0, ge=0.0, le=1.0, description="Probability of the mirrored pair, in which the eyes change places"
    )
    augment: Literal["native", "common"] = Field(
        default="native", description="KeyPose's own augmentation of windows, or that of `augment` for all networks"
    )


class DenseFusionSettings(Model):
    """Settings of DenseFusion."""

    depth: Literal["raw", "true", "completed"] = Field(
        default="raw",
        description="Depth that it is given: raw, of the data set's depth camera or else of semi-global "
        "matching of the eyes; true, of the labels; completed, predicted by the network of `completion`",
    )
    completion: UserPath | None = Field(
        default=None, description="Checkpoint of a network whose depth is the completed one"
    )
    points: int = Field(default=500, ge=8, le=10_000, description="Pixels of an object that are used")
    model_points: int = Field(default=500, ge=8, le=2000, description="Points of its surface that the loss compares")
    crop: int = Field(
        default=80, ge=40, le=680, multiple_of=8, description="Side that the window around a mask is resized to [px]"
    )
    categories: tuple[str, ...] = Field(
        default=(), description="Categories with an output of their own; by default those of the training data"
    )
    confidence: float = Field(
        default=0.015, gt=0.0, le=1.0, description="Weight of the logarithm of the confidence in the loss [m]"
    )
    refine_after: float = Field(
        default=0.6, ge=0.0, le=1.0, description="Fraction of the steps after which only the refiner is trained"
    )
    refinements: int = Field(default=2, ge=0, le=16, description="Passes of the refiner")
    shift: float = Field(
        default=0.03, ge=0.0, le=0.5, description="Greatest shift of points and target in training [m]"
    )
