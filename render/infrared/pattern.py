"""The projector's pattern: dots at blue-noise distances, and their map in the plane at distance 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from scipy.spatial import cKDTree

from ...core.assets import checked_path
from ...core.randomness import stream
from ...procedural.description.depth_camera import PatternProjector
from ...procedural.sensors.pattern_picture import pattern_picture

#: Smallest distance of two dots over the side of a square that holds one [1]. Points thrown at random so far apart fill
#: the plane up to 0.84 of that (maximal Poisson-disc samplings have a density of 0.70 / distance^2, Gamito and Maddock
#: 2009), so all dots are found soon.
_SPACING = 0.7
#: Points thrown for each dot at a time [1].
_THROWN = 6
#: Pixels of the map across the full width at half height of a dot [px]: bilinear interpolation is within 3 % of a
#: Gaussian then.
_ACROSS = 3.0
#: Full width at half height of a Gaussian over its standard deviation.
_FULL_WIDTH = 2.0 * np.sqrt(2.0 * np.log(2.0))
#: Half width of the square that a dot fills, in its standard deviations [1]: 0.03 % of its power lies outside.
_REACH = 3.5


@dataclass(frozen=True, eq=False)
class PatternMap:
    """Radiant power by tangents of the direction, x / z and y / z in the projector's frame."""

    density: np.ndarray  #: (rows, columns) float32 [W per unit of the plane at distance 1]
    step: float  #: width of a pixel [1]
    corner: tuple[float, float]  #: tangents of the corner of the first pixel


def pattern_map(projector: PatternProjector, seed: int, name: str) -> PatternMap:
    """Return the pattern of one unit of a device.

    Parameters
    ----------
    projector : PatternProjector
        The projector.
    seed : int
        Seed of the data set: all its scenes are measured by the same unit.
    name : str
        Name of the device.
    """
    return _pattern_map(projector.model_dump_json(), seed, name)


@lru_cache(maxsize=4)
def _pattern_map(described: str, seed: int, name: str) -> PatternMap:
    projector = PatternProjector.model_validate_json(described)
    if projector.picture is not None:
        return _shown(pattern_picture(checked_path(projector.picture)), projector)
    rng = stream(seed, 0, f"sensors/{name}/pattern")
    half = np.tan(0.5 * np.array(projector.field))
    dots = blue_noise(projector.dots, half, rng)
    angle = rng.uniform(-projector.turn, projector.turn)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return _drawn(dots @ turn.T, projector)


def _shown(levels: np.ndarray, projector: PatternProjector) -> PatternMap:
    """Return the map of a picture that fills the projector's field, with square pixels as wide as the picture's."""
    across, down = (2.0 * float(np.tan(0.5 * angle)) for angle in projector.field)
    columns = levels.shape[1]
    step = across / columns
    rows = max(2, round(down / step))
    density = cv2.resize(levels, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float64)
    density *= projector.power / (density.sum() * step**2)
    return PatternMap(density.astype(np.float32), step, (-0.5 * across, -0.5 * rows * step))


def blue_noise(count: int, half: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return points in a rectangle about 0, none close to another: dart throwing (Cook 1986).

    Parameters
    ----------
    count : int
        Number of points.
    half : (2,) float
        Half the rectangle's sides.
    rng : numpy.random.Generator
        Random numbers.
    """
    distance = _SPACING * np.sqrt(4.0 * half[0] * half[1] / count)
    points = np.zeros((0, 2))
    while len(points) < count:
        thrown = np.concatenate([points, rng.uniform(-half, half, (_THROWN * count, 2))])
        pairs = cKDTree(thrown).query_pairs(distance, output_type="ndarray")
        first, second = np.sort(pairs, axis=1).T
        order = np.argsort(second, kind="stable")
        near = np.split(first[order], np.cumsum(np.bincount(second, minlength=len(thrown)))[:-1])
        kept = np.zeros(len(thrown), bool)
        for index, before in enumerate(near):
            kept[index] = not kept[before].any()
        points = thrown[kept]
    return points[:count]


def _drawn(dots: np.ndarray, projector: PatternProjector) -> PatternMap:
    """Return the map of dots: Gaussians of the same power."""
    step = projector.dot / _ACROSS
    sigma = _ACROSS / _FULL_WIDTH
    reach = int(np.ceil(_REACH * sigma))
    low = dots.min(axis=0) - (reach + 1) * step
    size = np.ceil((dots.max(axis=0) + (reach + 1) * step - low) / step).astype(int)
    place = (dots - low) / step - 0.5  # in pixels, whose centres are at whole numbers
    middle = np.rint(place).astype(int)
    offsets = np.arange(-reach, reach + 1)
    across, down = (np.exp(-0.5 * ((offsets + (middle - place)[:, axis, None]) / sigma) ** 2) for axis in (0, 1))
    patch = down[:, :, None] * across[:, None, :]
    patch *= (projector.power / len(dots) / step**2) / patch.sum(axis=(1, 2), keepdims=True)
    density = np.zeros((size[1], size[0]))
    rows, columns = middle[:, 1, None] + offsets, middle[:, 0, None] + offsets
    np.add.at(density, (rows[:, :, None], columns[:, None, :]), patch)
    return PatternMap(density.astype(np.float32), float(step), (float(low[0]), float(low[1])))
