"""What ``dataset.json`` says of a data set that `glassware convert` made of another project's files."""

from __future__ import annotations

from typing import Literal, get_args

from pydantic import Field

from ...core.model import Model

#: What a view can have. A data set has a kind where at least one of its views has it.
LabelKind = Literal[
    "stereo",
    "intrinsics",
    "camera-poses",
    "depth",
    "sensor-depth",
    "normals",
    "instances",
    "classes",
    "objects",
    "poses",
    "sizes",
    "keypoints",
    "symmetries",
]
LABEL_KINDS: tuple[LabelKind, ...] = get_args(LabelKind)
#: Where a pose comes from: the data set states it, its keypoints were aligned with the object's model, or it follows
#: from the corners of a stated box.
PoseSource = Literal["stated", "keypoints", "box"]


class Conversion(Model):
    """Of what a data set was made, and what its views have."""

    layout: str = Field(description="Layout of the files that were read, such as keypose")
    title: str = Field(description="Name of the data set as its authors write it")
    folder: str = Field(description="Name of the folder that was read, without the path to it")
    licence: str = Field(description="Licence that its authors state; unknown where they state none")
    has: dict[LabelKind, int] = Field(description="Number of views that have each kind of label")
    views: int = Field(ge=0, description="Number of views that were written")
    left_out: int = Field(ge=0, description="Number of views that were not; `findings` names them")
    classes: tuple[str, ...] = Field(default=(), description="Names of the values of classes.png")
    notes: tuple[str, ...] = Field(default=(), description="What readers of its labels should know")
