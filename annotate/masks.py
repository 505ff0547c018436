"""Masks, and how much of each object a camera sees."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from pycocotools import mask as coco

from ..render.frame import Geometry

#: Fractions are multiples of 2^-40, so their sum is exactly 1 in any order of adding, and one that is 0 is exactly 0.
_FRACTION_STEPS = 1 << 40


@dataclass(frozen=True)
class PixelCounts:
    """How the pixels of an object's silhouette in the frame divide."""

    visible: int  #: the object is the first surface
    seen_through: int  #: only transparent surfaces are before it
    occluded: int  #: an opaque surface is before it

    @property
    def silhouette(self) -> int:
        """All pixels whose straight ray meets the object."""
        return self.visible + self.seen_through + self.occluded


def instance_mask(geometry: Geometry, object_id: int) -> np.ndarray:
    """Return the pixels where an object is the first surface, (H, W) bool."""
    return geometry.id == object_id


def encode_mask(mask: np.ndarray) -> str:
    """Return the ``counts`` of COCO's compressed run-length encoding of a mask, (H, W) bool, as ASCII."""
    return coco.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode("ascii")


def decode_mask(counts: str, size: tuple[int, int]) -> np.ndarray:
    """Return the mask, (H, W) bool, of COCO's compressed ``counts``; ``size`` is (height, width)."""
    return coco.decode({"size": list(size), "counts": counts.encode("ascii")}).astype(bool)


def pixel_counts(geometry: Geometry, index: int, object_id: int) -> PixelCounts:
    """Count what is seen of the object ``scene.objects[index]``.

    The three classes divide the silhouette, so each is counted on its own mask and none from the others.
    """
    crossed, reached = geometry.crossed[index], geometry.reached[index]
    visible = instance_mask(geometry, object_id)
    return PixelCounts(
        visible=int(visible.sum()),
        seen_through=int((reached & ~visible).sum()),
        occluded=int((crossed & ~reached).sum()),
    )


def fractions(counts: PixelCounts) -> tuple[float, float, float] | None:
    """Return the visible, seen-through and occluded shares of a silhouette; None where it is empty.

    They sum to exactly 1.
    """
    whole = counts.silhouette
    if not whole:
        return None
    visible, seen_through = (
        round(Fraction(n * _FRACTION_STEPS, whole)) / _FRACTION_STEPS for n in (counts.visible, counts.seen_through)
    )
    return visible, seen_through, 1.0 - visible - seen_through
