"""Whether two solid bodies overlap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

#: How deep two bodies may be in each other and still count as touching [m]: the coarsest meshes (0.2 mm of chord error
#: each) and files of scanned objects that rest on each other are off by as much.
ALLOWANCE = 5e-4
#: Longest edge of the triangles whose middles stand for a surface [m]: what is smaller may be missed.
SAMPLE_EDGE = 5e-3
#: Steps in search of a separating plane before the bodies' surfaces are looked at. Bodies a few millimetres apart need
#: 5 to 30.
PLANE_STEPS = 60
#: Vertical test rays are moved by this, so that they run through no vertex or edge of a regular mesh [m].
_SIDESTEP = np.array([3.1e-7, 1.7e-7])


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed triangle mesh in the world frame.

    Parameters
    ----------
    points : (n, 3) float64
        Vertices [m].
    faces : (m, 3) int
        Triangles, counter-clockwise seen from outside.
    """

    points: np.ndarray
    faces: np.ndarray

    @cached_property
    def exact(self) -> Any:
        """The body as a `manifold3d.Manifold`; None where its surface is not closed."""
        from manifold3d import Error, Manifold, Mesh64

        rows = np.ascontiguousarray(self.points + 0.0)  # + 0.0 turns -0 into 0
        _, first, index = np.unique(rows.view("V24").ravel(), return_index=True, return_inverse=True)
        found = Manifold(Mesh64(rows[first], index.reshape(-1)[self.faces].astype(np.uint64)))
        return found if found.status() == Error.NoError and found.volume() > 0.0 else None


def union(a: Solid, b: Solid) -> Solid:
    """Return what is in one of two bodies or in both; where a surface is not closed, both surfaces as they are."""
    if a.exact is None or b.exact is None:
        return Solid(np.concatenate([a.points, b.points]), np.concatenate([a.faces, b.faces + len(a.points)]))
    mesh = (a.exact + b.exact).to_mesh64()
    return Solid(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))


def overlap(a: Solid, b: Solid) -> bool:
    """Return whether the bodies overlap by more than `ALLOWANCE` of depth.

    Bounding boxes and then a separating plane of the convex hulls clear most pairs, and of closed bodies an empty
    intersection clears the others that are apart. Otherwise the surface of each, moved inwards by the allowance, is
    tested for points inside the other.
    """
    low, high = np.maximum(a.points.min(0), b.points.min(0)), np.minimum(a.points.max(0), b.points.max(0))
    if (low > high - ALLOWANCE).any() or hulls_apart(a.points, b.points):
        return False
    if a.exact is not None and b.exact is not None:
        common = a.exact ^ b.exact
        if common.is_empty():
            return False
        box = np.array(common.bounding_box()).reshape(2, 3)
        low, high = box[0], box[1]
    return _reaches_into(a, b, low, high) or _reaches_into(b, a, low, high)


def hulls_apart(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether a plane separates two sets of points (n, 3) and (m, 3).

    False also where none is found in `PLANE_STEPS` steps.

    Seeks the point of the Minkowski difference nearest to the origin by going to the best support point each time
    (Gilbert 1966, "An iterative procedure for computing the minimum of a quadratic form on a convex set"). A support
    plane that the origin lies behind proves that the hulls are apart.
    """
    nearest = a.mean(0) - b.mean(0)
    for _ in range(PLANE_STEPS):
        support = a[np.argmin(a @ nearest)] - b[np.argmax(b @ nearest)]
        if support @ nearest > 0.0:
            return True
        step = nearest - support
        if not step.any():  # the hulls' points lie over each other
            return False
        nearest = nearest - min(1.0, float(nearest @ step) / float(step @ step)) * step
    return False


def contains(body: Solid, points: np.ndarray) -> np.ndarray:
    """Return which points (k, 3) lie inside: a ray upwards leaves the body once more than it enters it."""
    corners = body.points[body.faces]
    low, high = corners[..., :2].min(1), corners[..., :2].max(1)
    return np.array([_crossings(corners, low, high, point) != 0 for point in points], dtype=bool)


def _crossings(corners: np.ndarray, low: np.ndarray, high: np.ndarray, point: np.ndarray) -> int:
    x = point[:2] + _SIDESTEP
    near = corners[((low <= x) & (x <= high)).all(1)]
    p, q, r = (near[:, i, :2] - x for i in range(3))
    # Twice the signed areas of the three triangles with the point, seen from above.
    areas = np.stack([_cross(q, r), _cross(r, p), _cross(p, q)], axis=1)
    total = areas.sum(1)
    hit = (total != 0.0) & ((areas * np.sign(total)[:, None]) >= 0.0).all(1)
    height = (areas[hit] * near[hit, :, 2]).sum(1) / total[hit]
    return int(np.sign(total[hit])[height > point[2]].sum())


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _reaches_into(a: Solid, b: Solid, low: np.ndarray, high: np.ndarray) -> bool:
    """Return whether a point under the surface of one body is in the other; they meet within a box."""
    points = _inner_samples(a)
    within = ((points >= low - ALLOWANCE) & (points <= high + ALLOWANCE)).all(1)
    return bool(contains(b, points[within]).any())


def _inner_samples(body: Solid) -> np.ndarray:
    """Return the middles of the surface's triangles, moved inwards by the allowance."""
    import trimesh  # here, as it takes half a second to load

    points, faces, *_ = trimesh.remesh.subdivide_to_size(body.points, body.faces, SAMPLE_EDGE, max_iter=12)
    a, b, c = np.moveaxis(points[faces], 1, 0)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    kept = length > 0.0
    return ((a + b + c) / 3.0)[kept] - ALLOWANCE * normals[kept] / length[kept, None]
