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
    counts: bytes = coco.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"]  # pyright: ignore[reportAssignmentType]
    return counts.decode("ascii")


def decode_mask(counts: str, size: tuple[int, int]) -> np.ndarray:
    """Return the mask of COCO's compressed ``counts``.

    Our own reader, because pycocotools writes outside its memory where the runs of a damaged file are too long.

    Parameters
    ----------
    counts : str
        Lengths of runs of 0 and 1 in turn, first 0, down the columns. From the third on, each is stored as its
        difference from the one two before. A number is written in groups of 5 bits, lowest first, in two's complement;
        bit 5 says that another group follows, and 48 is added to make a printable character.
    size : (int, int)
        Height and width [px].

    Returns
    -------
    (H, W) bool

    Raises
    ------
    ValueError
        Where the text is not such an encoding of a mask of this size.
    """
    runs: list[int] = []
    for number in _numbers(counts):
        runs.append(number + runs[-2] if len(runs) > 2 else number)
    height, width = size
    if min(size) < 1 or any(run < 0 for run in runs) or sum(runs) != height * width:
        raise ValueError(f"mask: expected runs over {height} x {width} px, got {sum(runs)} px")
    values = np.arange(len(runs)) % 2 == 1
    return np.ascontiguousarray(np.repeat(values, runs).reshape(width, height).T)


def _numbers(counts: str) -> list[int]:
    numbers, value, shift = [], 0, 0
    for group in (ord(character) - 48 for character in counts):
        # 64 bits hold every run of any picture.
        if not 0 <= group < 64 or shift > 60:
            raise ValueError(f"mask: expected COCO's compressed counts, got {counts[:40]!r}")
        value |= (group & 31) << shift
        shift += 5
        if not group & 32:
            numbers.append(value - (1 << shift) if group & 16 else value)
            value, shift = 0, 0
    if shift:
        raise ValueError(f"mask: expected COCO's compressed counts, got a text cut short: {counts[-40:]!r}")
    return numbers


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
