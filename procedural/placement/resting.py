"""How objects come to rest on the table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from ...core.mesh import Mesh


def resting_pose(mesh: Mesh, rng: np.random.Generator) -> np.ndarray:
    """Return a pose in which the mesh rests on z = 0, drawn with the probability that it lands so when dropped.

    Parameters
    ----------
    mesh : Mesh
        Object frame.
    rng : numpy.random.Generator
        Draws the face to rest on and the turn about z.

    Returns
    -------
    (4, 4) float64
        ``world_T_object`` with the lowest vertex at z = 0.
    """
    return lowered(resting_turn(mesh.vertices.astype(np.float64), rng), mesh)


def resting_turn(
    points: np.ndarray,
    rng: np.random.Generator,
    least_tilt: float | None = None,
    centre: Sequence[float] | None = None,
) -> np.ndarray:
    """Return the turn, (4, 4), in which a body rests on a plane, drawn as `resting_pose` does.

    Parameters
    ----------
    points : (n, 3) float
        Vertices of the body.
    rng : numpy.random.Generator
        Draws the face to rest on and the turn about z.
    least_tilt : float, optional
        Angle that the object's z axis then has to the vertical at least, up or down [rad]; where no such pose is
        stable, all poses are drawn from.
    centre : (3,) float, optional
        Centre of mass; by default the hull's.
    """
    normals, probability = stable_faces(points, centre)
    if least_tilt is not None:
        tilted = np.abs(normals[:, 2]) <= np.cos(least_tilt)
        if tilted.any():
            normals, probability = normals[tilted], probability[tilted] / probability[tilted].sum()
    down = normals[rng.choice(len(normals), p=probability)]
    return turn_about_z(rng.uniform(0.0, 2.0 * np.pi)) @ _turned_down(down)


def stable_faces(points: np.ndarray, centre: Sequence[float] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the faces of the convex hull that a body can rest on, and the probability that it lands on each.

    A face is stable where the centre of mass, by default the hull's, stands over it. The probability is proportional to
    the solid angle of the face seen from that centre: the quasi-static estimate without toppling of Goldberg et
    al. 1999, "Part Pose Statistics" (IEEE T-RA 15(5)), section III.

    Parameters
    ----------
    points : (n, 3) float64
        Vertices of the body.
    centre : (3,) float, optional
        Centre of mass.

    Returns
    -------
    normals : (k, 3) float64
        Outward unit normals.
    probability : (k,) float64
        Sum to 1.
    """
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    middle = _centre_of_mass(corners) if centre is None else np.asarray(centre, dtype=np.float64)
    _, face = np.unique(np.round(hull.equations, 6), axis=0, return_inverse=True)
    face = face.reshape(-1)
    solid_angle = np.bincount(face, weights=_solid_angles(corners - middle))
    below = middle - (middle @ hull.equations[:, :3].T + hull.equations[:, 3])[:, None] * hull.equations[:, :3]
    stable = np.flatnonzero(_within(below, corners))
    _, first = np.unique(face[stable], return_index=True)
    chosen = stable[first]
    weight = solid_angle[face[chosen]]
    return hull.equations[chosen, :3], weight / weight.sum()


def _centre_of_mass(corners: np.ndarray) -> np.ndarray:
    origin = corners.mean((0, 1))
    volumes = np.abs(np.linalg.det(corners - origin))  # tetrahedra from an inner point: all count positive
    centres = (corners.sum(1) + origin) / 4.0
    return volumes @ centres / volumes.sum()


def _solid_angles(corners: np.ndarray) -> np.ndarray:
    """Return the solid angle of each triangle (m, 3, 3) seen from the origin.

    van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle", eq. 8.
    """
    a, b, c = (corners[:, i] / np.linalg.norm(corners[:, i], axis=1, keepdims=True) for i in range(3))
    triple = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c)))
    return 2.0 * np.arctan2(triple, 1.0 + (a * b).sum(1) + (b * c).sum(1) + (c * a).sum(1))


def _within(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return which points (m, 3) lie within their triangles (m, 3, 3), both in one plane."""
    a, b, c = (corners[:, i] - points for i in range(3))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sides = [np.einsum("ij,ij->i", np.cross(p, q), normal) for p, q in ((a, b), (b, c), (c, a))]
    # The margin takes in a foot that stands exactly on the edge between two triangles of one face.
    return np.min(sides, axis=0) >= -1e-9 * (normal**2).sum(1)


def _turned_down(normal: np.ndarray) -> np.ndarray:
    """Return the rotation, (4, 4), that takes a unit normal to -z."""
    x = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = [x, np.cross(-normal, x), -normal]
    return pose


def turn_about_z(angle: float) -> np.ndarray:
    """Return the rotation by `angle` [rad] about +z, (4, 4) float64."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


def lowered(pose: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Return the pose moved along z so that the mesh's lowest vertex is at z = 0."""
    lowest = float((mesh.vertices.astype(np.float64) @ pose[2, :3]).min())
    pose = pose.copy()
    pose[2, 3] = -lowest
    return pose
