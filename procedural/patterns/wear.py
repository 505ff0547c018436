"""Traces of use on any pattern: scratches, dust, smears, and edges that are rubbed pale."""

from __future__ import annotations

import cv2
import numpy as np

from .grid import Grid, Layers, step

#: Scratches of a worn surface [1/m^2], their length [m] and width [m]; they are drawn at most a texel wide, and
#: paler the wider the texel is.
SCRATCHES, SCRATCH_LENGTH, SCRATCH_WIDTH = 600.0, (0.006, 0.09), 0.00035
#: Depth of a scratch [m]: what a finger nail feels is 10 um and more.
SCRATCH_DEPTH = 1.2e-5
#: Reflectance of household dust, linear (grey-brown lint), and most of it on a worn surface [1].
DUST, MOST_DUST = np.array((0.36, 0.34, 0.31), np.float32), 0.12
#: Most of the relative change of roughness by smears [1].
SMEAR = 0.2
#: Steps of a scratch's arc, and fractional bits of its points [1].
_STEPS, _BITS = 9, 4


def worn(grid: Grid, layers: Layers, scratchable: bool = True) -> Layers:
    """Return layers with traces of use by the grid's wear; none at 0."""
    if grid.wear <= 0.0:
        return layers
    wear = np.float32(grid.wear)
    smear = np.clip(grid.noise((0.09, 0.04), 3), -1.0, 2.0)
    dust = wear * MOST_DUST * (0.4 * step(-0.5, 2.0, grid.noise(0.06, 3)) + 0.6 * step(2.0, 3.0, grid.noise(0.0012)))
    colour = layers.colour + dust[..., None] * (DUST - layers.colour)
    roughness = layers.roughness * (1.0 + SMEAR * wear * smear) + 2.0 * dust
    height = layers.height
    if scratchable:
        marks = scratches(grid, SCRATCHES * grid.wear * grid.width * grid.height)
        colour = colour * (1.0 - 0.10 * marks)[..., None] + (0.05 * marks)[..., None]
        roughness, height = roughness * (1.0 + 0.5 * marks), height - np.float32(SCRATCH_DEPTH) * marks
    return Layers(colour.astype(np.float32), roughness.astype(np.float32), height.astype(np.float32), layers.coverage)


def scratches(grid: Grid, mean_count: float) -> np.ndarray:
    """Return thin arcs at random places, (h, w) float32 in [0, 1]; how many follows a Poisson distribution."""
    rng, marks = grid.rng, np.zeros(grid.shape, np.uint8)
    texel = np.array(grid.texel)
    for _ in range(rng.poisson(mean_count)):
        length = np.exp(rng.uniform(*np.log(SCRATCH_LENGTH)))
        angle, bend = rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, 0.4)
        along = angle + bend * np.linspace(-0.5, 0.5, _STEPS)
        steps = np.stack([np.cos(along), np.sin(along)], 1) * length / _STEPS
        points = rng.uniform(size=2) * (grid.width, grid.height) + np.cumsum(steps, axis=0)
        fixed = np.round(points / texel * (1 << _BITS)).astype(np.int32)
        cv2.polylines(marks, [fixed[:, None]], False, int(rng.integers(60, 256)), 1, cv2.LINE_AA, _BITS)
    return marks.astype(np.float32) * np.float32(min(1.0, SCRATCH_WIDTH / min(grid.texel)) / 255.0)


def rubbed(grid: Grid, colour: np.ndarray, distance: np.ndarray, under: np.ndarray, width: float) -> np.ndarray:
    """Return a print with edges rubbed down to the paper, by the distance of each texel from an edge [m].

    Parameters
    ----------
    grid : Grid
        The texels, and their wear.
    colour : (h, w, 3) float32
        The print.
    distance : (h, w) float
        Distance from the nearest edge or fold [m].
    under : (3,) float
        Reflectance of what is under the print.
    width : float
        Width of the rubbed strip at full wear [m].
    """
    reach = np.float32(max(1e-6, width * grid.wear)) * (0.5 + 0.5 * np.clip(1.0 + 0.7 * grid.noise(0.006, 3), 0.0, 2.5))
    amount = 0.85 * np.clip(1.5 - distance / reach, 0.0, 1.0) * (1.0 if grid.wear > 0 else 0.0)
    return colour + amount[..., None].astype(np.float32) * (np.asarray(under, np.float32) - colour)
