"""All surfaces along straight rays from a camera, by the projection of every triangle, in float64 NumPy.

A ray d from the camera's centre meets the triangle a, b, c (camera frame) where the three volumes d . (b x c),
d . (c x a) and d . (a x b) have one sign; its depth is then a . (b x c) / (their sum) for d with z = 1. That needs no
clipping: triangles may reach behind the camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .pinhole import Pinhole, rays_of, seen_from
from .triangles import Triangles

#: A ray that passes an edge within this distance may or may not meet the triangle [px]: the renderer's positions are
#: float32, some 1e-7 m at 1 m, and its rays leave each surface 1 um aside, which a lens of 2000 px shows at 0.5 m as
#: 4e-3 px.
EDGE = 4e-3
#: Pairs of a triangle and a ray that are tested at once: a bound on memory, about 100 bytes each.
_PAIRS = 2_000_000


@dataclass(frozen=True, eq=False)
class Hits:
    """k surfaces along n rays, ray by ray and from the camera on."""

    ray: np.ndarray  #: (k,) int, number of the ray
    Z: np.ndarray  #: (k,) float64, planar depth [m]
    triangle: np.ndarray  #: (k,) int
    weights: np.ndarray  #: (k, 3) float64, barycentric coordinates of the point
    slack: np.ndarray  #: (k,) float64, how far Z may be off for `EDGE` pixels of another direction [m]
    doubtful: np.ndarray  #: (n,) bool, the ray passes within `EDGE` of an edge of the outline of a surface
    count: int  #: n


def cast(triangles: Triangles, camera: Pinhole, pixels: np.ndarray) -> Hits:
    """Return what the straight rays through image coordinates meet.

    Parameters
    ----------
    triangles : Triangles
        The scene.
    camera : Pinhole
        The camera.
    pixels : (n, 2) float
        Image coordinates [px], in any order.
    """
    # Rays in order of their row, then of their column: those in a box of pixels are runs in each row.
    cells = np.asarray(np.floor(pixels + 0.5), np.int64)
    low, high = np.min(cells, axis=0), np.max(cells, axis=0)
    span = int(high[0] - low[0]) + 1
    keys = (cells[:, 1] - low[1]) * span + cells[:, 0] - low[0]
    order = np.argsort(keys, kind="stable")
    keys, rays = keys[order], rays_of(camera, pixels[order])
    local = seen_from(camera, triangles.corners)
    grid = _Grid(keys, low, high)
    parts, doubtful = [], np.zeros(len(pixels), bool)
    for tri, ray in _candidates(local, camera, grid):
        hit, Z, weights, slack, near = _tested(local, tri, rays[ray], camera)
        doubtful[order[ray[near]]] = True
        parts.append((order[ray[hit]], Z, tri[hit], weights, slack))
    empty = (np.zeros(0, int), np.zeros(0), np.zeros(0, int), np.zeros((0, 3)), np.zeros(0))
    columns = [np.concatenate(column) for column in zip(empty, *parts, strict=True)]
    sort = np.lexsort((columns[1], columns[0]))
    return Hits(*(column[sort] for column in columns), doubtful=doubtful, count=len(pixels))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Rays by the pixels that they pass."""

    keys: np.ndarray  #: (n,) int, ascending: place of each ray's pixel in the box of all, row by row
    low: np.ndarray  #: (2,) int, first column and row
    high: np.ndarray  #: (2,) int, last column and row


def _candidates(local: np.ndarray, camera: Pinhole, grid: _Grid) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield triangles and rays (in the order of the keys) whose boxes of pixels meet, a bounded number at a time."""
    keys, low, high = grid.keys, grid.low, grid.high
    span = int(high[0] - low[0]) + 1
    front = local[..., 2] > 1e-6
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = camera.focal * local[..., :2] / local[..., 2:] + camera.centre
    whole = np.all(front, axis=1)[:, None]
    near = np.where(whole, pixels.min(axis=1) - EDGE, low)
    far = np.where(whole, pixels.max(axis=1) + EDGE, high)
    left: np.ndarray = np.clip(np.floor(near + 0.5), low, high + 1).astype(np.int64) - low
    right: np.ndarray = np.clip(np.floor(far + 0.5), low - 1, high).astype(np.int64) - low
    kept = np.flatnonzero(np.all(left <= right, axis=1) & front.any(axis=1))
    rows = (right - left)[kept, 1] + 1
    tri = np.repeat(kept, rows)
    row = np.arange(len(tri)) - np.repeat(np.cumsum(rows) - rows, rows) + left[tri, 1]
    start = np.searchsorted(keys, row * span + left[tri, 0], "left")
    counts = np.searchsorted(keys, row * span + right[tri, 0], "right") - start
    tri, start, counts = tri[counts > 0], start[counts > 0], counts[counts > 0]
    ends = np.cumsum(counts)
    first = 0
    while first < len(tri):
        base = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, base + _PAIRS, "right")))
        some = counts[first:last]
        within = np.arange(int(some.sum())) - np.repeat(np.cumsum(some) - some, some)
        yield np.repeat(tri[first:last], some), np.repeat(start[first:last], some) + within
        first = last


def _tested(local: np.ndarray, tri: np.ndarray, rays: np.ndarray, camera: Pinhole) -> tuple[np.ndarray, ...]:
    """Test pairs of triangles, in ascending order, and rays.

    Returns
    -------
    hit : (h,) int
        The pairs that meet.
    Z, weights, slack : (h,), (h, 3), (h,) float
        Their depth, barycentric coordinates, and how far the depth may be off.
    near : (e,) int
        The pairs of which an edge is near.
    """
    # Of the triangles once: most belong to many pairs.
    first = np.concatenate([[True], tri[1:] != tri[:-1]]) if len(tri) else np.zeros(0, bool)
    own = np.cumsum(first) - 1
    a, b, c = np.moveaxis(local[tri[first]], 1, 0)
    sides = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    volume = np.einsum("kj,kj->k", a, sides[:, 0])[own]
    # How fast each volume changes with the pixel: its distance to zero in pixels.
    slope = np.hypot(sides[..., 0] / camera.focal[0], sides[..., 1] / camera.focal[1])
    turn = np.hypot(sides[..., 0].sum(axis=1) / camera.focal[0], sides[..., 1].sum(axis=1) / camera.focal[1])
    volumes = np.einsum("kij,kj->ki", sides[own], rays)
    total = volumes.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = volumes * np.sign(total)[:, None] / slope[own]
    lowest = np.where(np.isfinite(away), away, -np.inf).min(axis=1)
    front = (total != 0.0) & (volume * total > 0.0)  # of Z = volume / total
    hit = np.flatnonzero(front & (lowest >= 0.0))
    Z, total = volume[hit] / total[hit], total[hit]
    slack = np.abs(Z) * np.minimum(EDGE * turn[own[hit]] / np.abs(total), 1.0)
    return hit, Z, volumes[hit] / total[:, None], slack, np.flatnonzero(front & (np.abs(lowest) <= EDGE))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return cross products of rows; NumPy's own takes three times as long."""
    (x, y, z), (u, v, w) = a.T, b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
