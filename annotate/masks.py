"""Masks of objects, and the visible, seen-through and occluded pixels of each."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from pycocotools import mask as coco
from pydantic import Field

from ..core.model import Model
from ..render.frame import Geometry

#: Fractions are multiples of 2^-40, so their sum is exactly 1 in any order of adding, and one that is 0 is exactly 0.
_FRACTION_STEPS = 1 << 40


class Pixels(Model):
    """Pixels of an object's silhouette in the frame, by what covers them."""

    silhouette: int = Field(ge=0, description="The straight ray meets the object")
    visible: int = Field(ge=0, description="The object is the first surface")
    seen_through: int = Field(ge=0, description="Only transparent surfaces are in front of it")
    occluded: int = Field(ge=0, description="An opaque surface is in front of it")


class Fractions(Model):
    """Fractions of the silhouette in the frame; they sum to exactly 1."""

    visible: float = Field(ge=0.0, le=1.0)
    seen_through: float = Field(ge=0.0, le=1.0)
    occluded: float = Field(ge=0.0, le=1.0)


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


def count_pixels(geometry: Geometry, index: int, object_id: int) -> Pixels:
    """Count the pixels of the object ``scene.objects[index]``.

    The three classes partition the silhouette. Each is counted on its own mask.
    """
    crossed, reached = geometry.crossed[index], geometry.reached[index]
    visible = instance_mask(geometry, object_id)
    classes = (visible, reached & ~visible, crossed & ~reached)
    counts = [int(pixels.sum()) for pixels in classes]
    return Pixels(silhouette=sum(counts), visible=counts[0], seen_through=counts[1], occluded=counts[2])


def fractions(pixels: Pixels) -> Fractions | None:
    """Return the fractions of a silhouette; None where it is empty. They sum to exactly 1."""
    if not pixels.silhouette:
        return None
    visible, seen_through = (
        round(Fraction(count * _FRACTION_STEPS, pixels.silhouette)) / _FRACTION_STEPS
        for count in (pixels.visible, pixels.seen_through)
    )
    return Fractions(visible=visible, seen_through=seen_through, occluded=1.0 - visible - seen_through)
