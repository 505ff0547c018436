"""What the straight rays through the pixels of one eye must show, from the description alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .pinhole import Pinhole, pixel_centres
from .raycast import Hits, cast
from .triangles import LAMP, Triangles

#: Surfaces that follow each other within this distance along the axis may be recorded as one [m]: rays leave a surface
#: by some micrometres (docs/format.md, "Rays do not slip").
CLOSE = 2e-5


@dataclass(frozen=True, eq=False)
class Truth:
    """Surfaces along the rays of one eye, H x W pixels; hits at lamps and behind them are left out."""

    camera: Pinhole
    hits: Hits
    place: np.ndarray  #: (k,) int, number of each hit on its ray, from 0
    count: np.ndarray  #: (H, W) int, surfaces along each ray
    first: np.ndarray  #: (H, W) int, hit of the first surface; -1 for none
    background: np.ndarray  #: (H, W) int, hit of the first opaque surface; -1 for none
    doubtful: np.ndarray  #: (H, W) bool, an edge passes too near to say what the ray meets
    crowded: np.ndarray  #: (H, W) bool, two surfaces are too close to each other to count on both

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        width, height = self.camera.size
        return height, width

    def of_hits(self, which: np.ndarray, values: np.ndarray, nothing: float) -> np.ndarray:
        """Return values of the hits of a map such as `first`; `nothing` where there is none."""
        found = np.full((*which.shape, *values.shape[1:]), nothing, values.dtype)
        found[which >= 0] = values[which[which >= 0]]
        return found


def truth_of(triangles: Triangles, camera: Pinhole) -> Truth:
    """Return what the rays through all pixel centres of an eye meet."""
    width, height = camera.size
    hits = without_lamps(triangles, cast(triangles, camera, pixel_centres(camera)))
    rays = width * height
    count = np.bincount(hits.ray, minlength=rays)
    start = np.cumsum(count) - count
    place = np.arange(len(hits.ray)) - start[hits.ray]
    first = np.where(count > 0, start, -1)
    opaque = np.flatnonzero(triangles.opaque[hits.triangle])
    background = np.full(rays, -1)
    background[hits.ray[opaque[::-1]]] = opaque[::-1]  # the nearest is written last
    close = np.zeros(rays, bool)
    near = np.flatnonzero((np.diff(hits.ray) == 0) & (np.diff(hits.Z) < CLOSE))
    close[hits.ray[near]] = True
    shape = (height, width)
    maps = (array.reshape(shape) for array in (count, first, background, hits.doubtful, close))
    return Truth(camera, hits, place, *maps)


def silhouettes(truth: Truth, triangles: Triangles, ids: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays cross each object, and where they do so up to the first opaque surface, (n, H, W) bool each."""
    hits = truth.hits
    last = truth.background.ravel()[hits.ray]
    reached = (last < 0) | (np.arange(len(hits.ray)) <= last)
    crossed_of, reached_of = (np.zeros((len(ids), truth.count.size), bool) for _ in range(2))
    for row, number in enumerate(ids):
        own = triangles.id[hits.triangle] == number
        crossed_of[row, hits.ray[own]] = True
        reached_of[row, hits.ray[own & reached]] = True
    return crossed_of.reshape(-1, *truth.shape), reached_of.reshape(-1, *truth.shape)


def facing_normals(truth: Truth, triangles: Triangles) -> np.ndarray:
    """Return the interpolated shading normals of all hits in the camera's frame, towards the camera, (k, 3)."""
    hits = truth.hits
    mixed = np.einsum("ki,kij->kj", hits.weights, triangles.normals[hits.triangle]) @ truth.camera.axes.T
    mixed /= np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-12)
    return mixed * -np.sign(np.einsum("kj,kj->k", mixed, _directions(truth)))[:, None]


def enters(truth: Truth, triangles: Triangles) -> np.ndarray:
    """Return whether each hit goes against its triangle's own direction, (k,) bool."""
    corners = triangles.corners[truth.hits.triangle]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ truth.camera.axes.T
    return np.einsum("kj,kj->k", flat, _directions(truth)) < 0.0


def points_of(truth: Truth) -> np.ndarray:
    """Return the points of all hits in the camera's frame, (k, 3) [m]."""
    return _directions(truth) * truth.hits.Z[:, None]


def _directions(truth: Truth) -> np.ndarray:
    v, u = np.divmod(truth.hits.ray, truth.camera.size[0])
    pixels = np.stack([u, v], axis=1)
    return np.concatenate([(pixels - truth.camera.centre) / truth.camera.focal, np.ones((len(pixels), 1))], axis=1)


def without_lamps(triangles: Triangles, hits: Hits) -> Hits:
    """Return the hits in front of the first lamp of each ray: lamps are part of the surroundings, and end a ray."""
    lamps = np.flatnonzero(triangles.kind[hits.triangle] == LAMP)
    if not len(lamps):
        return hits
    end = np.full(hits.count, len(hits.ray))
    end[hits.ray[lamps[::-1]]] = lamps[::-1]
    kept = np.arange(len(hits.ray)) < end[hits.ray]
    columns = (column[kept] for column in (hits.ray, hits.Z, hits.triangle, hits.weights, hits.slack))
    return Hits(*columns, doubtful=hits.doubtful, count=hits.count)
