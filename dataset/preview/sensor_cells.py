"""What depth and polarisation cameras report, as pictures of a contact sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.images import depth_colours, difference_colours, polarisation_colours, reason_colours
from ...procedural.surroundings.colour import luminance
from ...render.frame import Geometry

#: Difference of depths at the ends of its colours [m]: what a depth camera sees through glass is some 50 mm behind it.
_DIFFERENCE = 0.05
#: Number of `sensor_valid.png` that means a depth (docs/format.md).
_MEASURED = 1
#: A colour, red, green, blue.
_Colour = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class SensorPreview:
    """What a depth camera reports of a view."""

    depth: np.ndarray  #: (H, W) float32 [m]; NaN for none
    reason: np.ndarray  #: (H, W) uint16, why each pixel has a depth or none
    reasons: tuple[str, ...]  #: names of these numbers
    infrared: np.ndarray | None = None  #: (h, w) uint16, the left infrared picture, where it was written


@dataclass(frozen=True, eq=False)
class Cell:
    """A picture of a sheet, and what is written on it."""

    title: str  #: of its column
    picture: np.ndarray  #: (H, W, 3) uint8
    tag: str = ""
    smooth: bool = False  #: whether it is a photograph, and no label
    legend: tuple[tuple[str, _Colour], ...] = ()


def sensor_cells(geometry: Geometry, sensor: SensorPreview) -> list[Cell]:
    """Return reported depth in the colours of the true one, how much farther it is, why there is none, infrared."""
    _, limits = depth_colours(geometry.Z, geometry.id)
    reported = np.where(np.isfinite(sensor.depth), sensor.depth, np.inf)
    colours, _ = depth_colours(reported, geometry.id, limits)
    difference = difference_colours(sensor.depth - geometry.Z, _DIFFERENCE)
    ends = f"-{1e3 * _DIFFERENCE:g} mm to {1e3 * _DIFFERENCE:g} mm"
    cells = [
        Cell("sensor depth", colours),
        Cell("sensor depth - Z", difference, ends),
        Cell("why there is none", reason_colours(sensor.reason), legend=_legend(sensor)),
    ]
    return cells if sensor.infrared is None else [*cells, Cell("infrared, left", _grey(sensor.infrared), smooth=True)]


def stokes_cells(stokes: np.ndarray) -> list[Cell]:
    """Return the degree of linear polarisation in grey, and the angle as a hue that is as bright as that."""
    degree, angle = polarisation_colours(luminance(stokes)[..., None])
    return [Cell("DoLP", degree), Cell("AoLP, as bright as DoLP", angle)]


def _legend(sensor: SensorPreview) -> tuple[tuple[str, _Colour], ...]:
    """Return the reasons that a view has, the most frequent one first."""
    numbers, counts = np.unique(sensor.reason, return_counts=True)
    shown = [int(number) for _, number in sorted(zip(-counts, numbers, strict=True)) if number != _MEASURED]
    names = [(sensor.reasons[one] if one < len(sensor.reasons) else str(one)).replace("_", " ") for one in shown]
    colours = reason_colours(np.array(shown, np.int64)).tolist()
    return tuple((name, (r, g, b)) for name, (r, g, b) in zip(names, colours, strict=True))


def _grey(numbers: np.ndarray) -> np.ndarray:
    """Return an infrared picture; one of more than 8 bits up to its brightest pixel."""
    white = max(255, int(numbers.max(initial=0)))
    return np.repeat(np.rint(numbers * (255.0 / white)).astype(np.uint8)[..., None], 3, axis=-1)
