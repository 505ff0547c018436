"""The space in a cavity of any shape, as bodies in it find it: its floor, and how far points are from the solid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from ...core.mesh import Mesh
from .interior import interior_of
from .sections import Wall, least_radii
from .wall import OUTSIDE_POINTS, point_triangle, spread

#: Nearest points of the surface whose triangles are looked at [1], for points that are nearer than this [m]: of others,
#: the distance of the nearest point is less than 0.1 mm larger than that of the surface, whose points are 1 mm apart.
_NEAREST, _NEAR = 8, 4e-3
#: Distances that differ by less belong to triangles that share an edge or a corner [m].
_SAME = 1e-9
#: Spaces that are remembered [1]: scenes have up to 24 vessels.
_REMEMBERED = 32


@dataclass(frozen=True, eq=False)
class Space:
    """The largest cavity of a solid.

    Parameters
    ----------
    wall : Wall
        The wall around it.
    axis : (2,) float64
        Where its vertical axis is: the mean of the middles of its sections [m].
    floor, brim : float
        Heights of its lowest point, and at which liquid would flow out [m].
    radii : (n,) float64
        How near the wall comes to the axis at the wall's heights [m].
    bottoms : (x, y) float64
        Heights of its bottom along vertical lines [m]; inf where it has none.
    origin, pitch : (2,) float64, float
        Place of the first line, and the distance of lines [m].
    corners : (m, 3, 3) float64
        Triangles of the solid [m].
    near : cKDTree
        Points spread over them.
    face : (k,) int
        The triangle of each point.
    """

    wall: Wall
    axis: np.ndarray
    floor: float
    brim: float
    radii: np.ndarray
    bottoms: np.ndarray
    origin: np.ndarray
    pitch: float
    corners: np.ndarray
    near: cKDTree
    face: np.ndarray

    def bottom_at(self, places: np.ndarray) -> np.ndarray:
        """Return the height of the bottom at places (k, 2), interpolated between lines [m]; inf beside the cavity."""
        grid = (places - self.origin) / self.pitch
        low = np.clip(np.floor(grid).astype(int), 0, np.array(self.bottoms.shape) - 2)
        (i, j), (x, y) = low.T, np.clip(grid - low, 0.0, 1.0).T
        a, b, c, d = (self.bottoms[i + di, j + dj] for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
        known = np.isfinite(a) & np.isfinite(b) & np.isfinite(c) & np.isfinite(d)
        known &= ((grid >= 0.0) & (grid <= np.array(self.bottoms.shape) - 1.0)).all(1)
        with np.errstate(invalid="ignore"):
            height = (1.0 - y) * ((1.0 - x) * a + x * b) + y * ((1.0 - x) * c + x * d)
        return np.where(known, height, np.inf)

    def clearance(self, points: np.ndarray, within: float = np.inf) -> np.ndarray:
        """Return the distance of points (k, 3) from the solid [m], negative in it, or inf where it is over `within`.

        A bound of a few millimetres saves nearly all of the time.

        A point is in the solid where it is behind the triangle that is nearest to it; of triangles that share the
        nearest edge or corner, the one whose plane is farthest off decides (Baerentzen and Aanaes 2005, "Signed
        distance computation using the angle weighted pseudonormal", show why any other may be wrong).
        """
        found, index = self.near.query(points, distance_upper_bound=max(within, _NEAR))
        known = np.isfinite(found)
        places, index = points[known], index[known]
        behind = np.einsum("ij,ij->i", places - self.near.data[index], self._normals(index)) < 0.0
        found[known] = np.where(behind, -found[known], found[known])
        close = np.abs(found) < _NEAR
        if close.any():
            found[close] = self._exact(points[close])
        return found

    def _exact(self, points: np.ndarray) -> np.ndarray:
        _, index = self.near.query(points, k=_NEAREST)
        distance, offset = np.empty(index.shape), np.empty(index.shape)
        for k in range(_NEAREST):
            triangles = self.corners[self.face[index[:, k]]]
            distance[:, k] = point_triangle(points, triangles)
            offset[:, k] = np.einsum("ij,ij->i", points - triangles[:, 0], self._normals(index[:, k]))
        least = distance.min(1)
        offset = np.where(distance <= least[:, None] + _SAME, offset, 0.0)
        decides = np.take_along_axis(offset, np.abs(offset).argmax(1)[:, None], 1)[:, 0]
        return np.where(decides < 0.0, -least, least)

    def _normals(self, index: np.ndarray) -> np.ndarray:
        """Return unit normals of the triangles that points of the surface are on, (k, 3)."""
        a, b, c = np.moveaxis(self.corners[self.face[index]], 1, 0)
        normal = np.cross(b - a, c - a)
        return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)


@lru_cache(_REMEMBERED)
def space_of(solid: Mesh) -> Space | None:
    """Return the space in the largest cavity of a closed solid as it stands, z up; None where it has none."""
    inside = interior_of(solid)
    if not inside.hollows:
        return None
    hollow, wall, columns = inside.hollows[0], inside.walls[0], inside.columns
    axis = np.average(wall.centres, axis=0, weights=wall.radii**2)
    bottoms = np.full(columns.shape, np.inf)
    np.minimum.at(bottoms.reshape(-1), columns.column[hollow.intervals], hollow.bottom)
    corners = solid.vertices[solid.faces].astype(np.float64)
    points, face = spread(corners, OUTSIDE_POINTS)
    return Space(
        wall=wall,
        axis=axis,
        floor=hollow.floor,
        brim=hollow.brim,
        radii=least_radii(wall, axis),
        bottoms=bottoms,
        origin=columns.origin,
        pitch=columns.pitch,
        corners=corners,
        near=cKDTree(points),
        face=face,
    )
