"""Occlusion order: which object is in front of which in a view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from ..core.model import Model
from ..render.frame import Geometry


class Occlusion(Model):
    """One object is the first surface where the straight ray crosses another one behind it."""

    front: int = Field(description="Id of the object in front")
    behind: int = Field(description="Id of the object behind it")
    pixels: int = Field(ge=1, description="Number of pixels where that is so")


def occlusion_order(geometry: Geometry, ids: Sequence[int]) -> tuple[Occlusion, ...]:
    """Return the pairs of objects of which one is in front of the other.

    A pixel counts for (a, b) where a is the first surface, and b's silhouette has the pixel. Two objects can be in
    front of each other, in different pixels: a spoon in a glass is.

    Parameters
    ----------
    geometry : Geometry
        What the straight rays of one camera meet.
    ids : sequence of int
        Ids of the objects, in the order of the silhouettes.

    Returns
    -------
    tuple of Occlusion
        By ascending ids of the object in front, then of the one behind.
    """
    most = max(ids, default=0) + 1
    counts = [np.bincount(geometry.id[silhouette], minlength=most) for silhouette in geometry.crossed]
    return tuple(
        Occlusion(front=front, behind=behind, pixels=int(count[front]))
        for front in sorted(ids)
        for behind, count in sorted(zip(ids, counts, strict=True), key=lambda pair: pair[0])
        if behind != front and count[front]
    )
