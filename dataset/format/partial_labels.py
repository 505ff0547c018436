"""``labels.json`` of a converted view: what another project's data set states; null is what it does not."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from ...annotate.boxes import Box
from ...annotate.symmetries import Symmetry
from ...core.model import Matrix4, Model, Vector3
from .conversion import PoseSource
from .objects_file import ContinuousSymmetry

PARTIAL_LABELS_SCHEMA = "glassware/partial-labels/1"


class PartialKeypoint(Model):
    """A keypoint of an object, in the order of its data set."""

    pixel: tuple[float, float] = Field(description="Image coordinates (u, v) [px]")
    Z: float = Field(description="Planar depth [m]")
    visible: bool = Field(description="As the data set states it")


class PartialObject(Model):
    """An object in one view."""

    id: int = Field(ge=2, description="As in instances.png")
    name: str
    category: str
    transparent: bool | None = Field(description="null: not stated")
    camera_T_object: Matrix4 | None = Field(
        description="With a `size` the origin is the centre of its box; else the model's own"
    )
    pose_from: PoseSource | None = Field(
        description="stated; keypoints: aligned with the object's model; box: from the corners of a stated box"
    )
    size: Vector3 | None = Field(description="Sides of its box [m]")
    box2d: Box | None = Field(description="Around its visible pixels [px], as in a rendered view's `modal`")
    pixels: int | None = Field(description="Number of its pixels in instances.png; null without that file")
    keypoints: tuple[PartialKeypoint, ...] | None
    symmetries_continuous: tuple[ContinuousSymmetry, ...] | None = Field(description="As in objects.json")
    symmetries_discrete: tuple[Matrix4, ...] | None = Field(description="As in objects.json")


class PartialLabels(Model):
    """What is known of a converted view."""

    schema_version: Literal["glassware/partial-labels/1"] = PARTIAL_LABELS_SCHEMA
    source: str = Field(description="Name of the view in the data set that it comes from")
    objects: tuple[PartialObject, ...] | None = Field(description="By ascending id; null: objects are not labelled")


def symmetry_axes(symmetry: Symmetry | None) -> tuple[ContinuousSymmetry, ...] | None:
    """Return the axes of revolution as they are stored: z, and x as well of a ball; None where it is unknown."""
    if symmetry is None:
        return None
    axes = ((0.0, 0.0, 1.0),) * symmetry.turns + ((1.0, 0.0, 0.0),) * symmetry.ball
    return tuple(ContinuousSymmetry(axis=axis, offset=(0.0, 0.0, 0.0)) for axis in axes)


def stored_symmetry(record: PartialObject) -> Symmetry | None:
    """Return the symmetry of an object's record; None where it is not stated."""
    if record.symmetries_continuous is None:
        return None
    motions = [np.eye(4), *(np.asarray(motion) for motion in record.symmetries_discrete or ())]
    count = len(record.symmetries_continuous)
    return Symmetry(turns=count > 0, ball=count > 1, motions=np.stack(motions))
