"""From a profile to a triangle mesh of its surface of revolution."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from .curve import Curve


def segments_for(radius: float, chord_error: float) -> int:
    """Return how many segments a circle needs for its chords to stay within an error.

    The sagitta of a chord over 2 pi / n is ``radius (1 - cos(pi / n))``. The count is a multiple of 8, so that the
    mesh reaches the circle's bounding box exactly.

    Parameters
    ----------
    radius : float
        Largest radius [m].
    chord_error : float
        Largest sagitta [m].
    """
    return 8 * int(np.ceil(np.pi / np.arccos(1.0 - chord_error / radius) / 8.0))


def revolved(curve: Curve, segments: int, name: str) -> Mesh:
    """Return the surface of revolution of a curve about the z axis.

    A point (r, z) becomes the ring ``float32(r * cos a), float32(r * sin a), float32(z)`` over the same angles in
    every mesh of as many segments, so curves with a common point have a common ring bit for bit. The last segment of
    a ring uses the first vertices again: the seam closes exactly. A point on the axis is one vertex with a fan of
    triangles.
    A duplicated point makes two rings in the same place without faces between them: a crease.

    Parameters
    ----------
    curve : Curve
        The profile, in either direction; faces look along its normals. Only its ends may lie on the axis.
    segments : int
        Vertices per ring, a multiple of 8.
    name : str
        Name of the mesh.

    Returns
    -------
    Mesh
        With smooth normals, which are the curve's own turned about the axis.
    """
    if segments < 8 or segments % 8:
        raise ValueError(f"segments: expected a positive multiple of 8, got {segments}")
    on_axis = curve.points[:, 0] == 0.0
    if on_axis[1:-1].any():
        raise ValueError("curve: only its ends may lie on the axis")
    counts = np.where(on_axis, 1, segments)
    vertices, normals = (_rings(pairs, on_axis, segments) for pairs in (curve.points, curve.normals))
    faces = _faces(curve, np.concatenate([[0], np.cumsum(counts)[:-1]]), on_axis, segments)
    return Mesh(name, vertices, faces, normals)


def unit_circle(segments: int) -> np.ndarray:
    """Return (cos a, sin a) of `segments` equal steps, (n, 2), exactly symmetric in all eight octants."""
    angles = 2.0 * np.pi * np.arange(segments // 8 + 1) / segments
    octant = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    quarter = np.concatenate([octant[:-1], octant[:0:-1, ::-1]])
    half = np.concatenate([quarter, np.stack([-quarter[:, 1], quarter[:, 0]], axis=-1)])
    return np.concatenate([half, -half])


def _rings(pairs: np.ndarray, on_axis: np.ndarray, segments: int) -> np.ndarray:
    """Turn (radial, axial) pairs about the axis; a pair on the axis gives one row, the others `segments` rows."""
    turned = np.empty((len(pairs), segments, 3))
    turned[:, :, :2] = pairs[:, None, :1] * unit_circle(segments)
    turned[:, :, 2] = pairs[:, 1:]
    turned[on_axis, :, :2] = 0.0
    used = np.ones((len(pairs), segments), dtype=bool)
    used[on_axis, 1:] = False
    return turned[used]


def _faces(curve: Curve, first: np.ndarray, on_axis: np.ndarray, segments: int) -> np.ndarray:
    ring = np.arange(segments)
    rows = []
    for i, step in enumerate(np.diff(curve.points, axis=0)):
        if not step.any():
            continue
        lower, upper = (first[k] + (0 * ring if on_axis[k] else ring) for k in (i, i + 1))
        lower_next, upper_next = np.roll(lower, -1), np.roll(upper, -1)
        # A triangle with two corners on the axis has no area: at a pole only one of the pair is kept.
        band = [] if on_axis[i] else [np.stack([lower, lower_next, upper_next], axis=-1)]
        band += [] if on_axis[i + 1] else [np.stack([lower, upper_next, upper], axis=-1)]
        # These look to the right of the way along the curve, where (dz, -dr) points.
        to_right = np.array([step[1], -step[0]]) @ (curve.normals[i] + curve.normals[i + 1])
        rows += band if to_right > 0.0 else [triangles[:, ::-1] for triangles in band]
    return np.concatenate(rows)
