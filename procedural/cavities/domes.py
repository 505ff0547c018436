"""Surfaces of liquids in round cavities: a curve about an axis that ends in a given ring of points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Dome:
    """A surface of revolution about a vertical axis.

    Parameters
    ----------
    centre : (2,) float64
        Where the axis is [m].
    points, normals : (k, 2) float64
        Its curve from the axis outwards, rows (r, z) [m], and unit normals (n_r, n_z) into the air.
    """

    centre: np.ndarray
    points: np.ndarray
    normals: np.ndarray


def domed(
    vertices: np.ndarray, normals: np.ndarray, ring: np.ndarray, dome: Dome
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices and normals with those of a dome over a ring, and the dome's faces.

    Where the ring is no perfect circle, each radius of the dome is stretched to the ring's.

    Parameters
    ----------
    vertices, normals : (n, 3) float32
        Positions [m] and normals; those of the ring are set to the dome's.
    ring : (k,) int
        Counter-clockwise from above, each ray from the axis meeting it once.
    dome : Dome
        Its curve ends at the ring's height.

    Returns
    -------
    (m, 3) float32, (m, 3) float32, (f, 3) int64
        With further vertices after the given ones.
    """
    away = vertices[ring, :2].astype(np.float64) - dome.centre
    outwards = away / np.hypot(*away.T)[:, None]
    rows = slice(-2, 0, -1)  # inwards, between the ring and the axis
    scale, heights, slopes = dome.points[rows, 0] / dome.points[-1, 0], dome.points[rows, 1], dome.normals[rows]
    count, between = len(ring), len(heights)
    places = np.empty((between, count, 3))
    places[..., :2] = dome.centre + scale[:, None, None] * away
    places[..., 2] = heights[:, None]
    facing = np.concatenate([slopes[:, None, :1] * outwards, np.tile(slopes[:, None, 1:], (1, count, 1))], axis=2)
    normals = normals.copy()
    normals[ring] = np.concatenate([dome.normals[-1, 0] * outwards, np.full((count, 1), dome.normals[-1, 1])], axis=1)
    first = len(vertices)
    apex = np.array([[*dome.centre, dome.points[0, 1]]])
    vertices = np.concatenate([vertices, places.reshape(-1, 3), apex]).astype(vertices.dtype)
    normals = np.concatenate([normals, facing.reshape(-1, 3), [[0.0, 0.0, 1.0]]]).astype(normals.dtype)
    rings = np.concatenate([ring[None], first + np.arange(between * count).reshape(between, count)])
    return vertices, normals, _faces(rings, len(vertices) - 1)


def _faces(rings: np.ndarray, apex: int) -> np.ndarray:
    """Return the faces between rings (k, n), the first outside, all counter-clockwise, and around the apex."""
    after = np.roll(rings, -1, axis=1)
    outer, outer_next, inner, inner_next = rings[:-1], after[:-1], rings[1:], after[1:]
    strips = [np.stack([outer, outer_next, inner], 2), np.stack([outer_next, inner_next, inner], 2)]
    cap = np.stack([rings[-1], after[-1], np.full(rings.shape[1], apex)], 1)
    return np.concatenate([*(strip.reshape(-1, 3) for strip in strips), cap])
