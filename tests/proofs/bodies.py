"""Meshes of closed forms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from glassware.core.mesh import Mesh, turned
from glassware.procedural.primitives.bodies import box_mesh

#: An icosphere's axes meet vertices, which are better than any other point. Balls are turned by this rotation vector,
#: so that rays meet what rays meet.
_TURN = np.array([0.3, 0.5, 0.7])
#: Triangles smaller than this are the halves of quads that the axis shrinks to nothing [m^2].
_NO_AREA = 1e-16


def box(lower: Sequence[float], upper: Sequence[float], name: str = "box") -> Mesh:
    """Return an axis-parallel box between two corners [m], flat."""
    low, high = np.array(lower, float), np.array(upper, float)
    return box_mesh(tuple(high - low), name, tuple(0.5 * (low + high)))


def prism(apex: float, side: float, height: float) -> Mesh:
    """Return an upright prism over an isosceles triangle, apex towards +y, symmetric about x = 0, flat.

    Parameters
    ----------
    apex : float
        Angle between its two faces [rad].
    side : float
        Length of the two equal sides [m]; their middles lie at y = 0.
    height : float
        Extent along z, symmetric about z = 0 [m].
    """
    across, along = side * np.sin(apex / 2), side * np.cos(apex / 2)
    corners = np.array([[0.0, along / 2], [-across, -along / 2], [across, -along / 2]])
    vertices = np.array([[x, y, z] for z in (-height / 2, height / 2) for x, y in corners])
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    return Mesh("prism", vertices, faces)


def ball(radius: float, subdivisions: int = 6, flat: bool = False, name: str = "ball") -> Mesh:
    """Return a ball about the origin, normals outwards: an icosphere turned away from its symmetry."""
    solid = trimesh.creation.icosphere(subdivisions=subdivisions)
    directions = Rotation.from_rotvec(_TURN).apply(solid.vertices)
    return Mesh(name, radius * directions, solid.faces, None if flat else directions)


def shell(outer: float, inner: float, subdivisions: int = 5, flat: bool = False) -> tuple[Mesh, Mesh]:
    """Return the outer and the inner surface of a hollow ball, normals out of the shell."""
    return ball(outer, subdivisions, flat, "outer"), turned(ball(inner, subdivisions, flat, "inner"))


def both(one: Mesh, other: Mesh) -> Mesh:
    """Return two meshes with normals as one."""
    faces = np.concatenate([one.faces, other.faces + len(one.vertices)])
    normals = None if one.normals is None or other.normals is None else np.concatenate([one.normals, other.normals])
    return Mesh("both", np.concatenate([one.vertices, other.vertices]), faces, normals)


def revolved(profile: Sequence[np.ndarray], normals: Sequence[np.ndarray], segments: int, name: str) -> Mesh:
    """Return a surface of revolution about z.

    Parameters
    ----------
    profile : sequence of (k, 2) float
        Curves (r, z) [m], each smooth, with the outside on the right hand.
    normals : sequence of (k, 2) float
        Unit normals at their points.
    segments : int
        Segments of a ring.
    name : str
        Name of the mesh.
    """
    angle = 2.0 * np.pi * np.arange(segments) / segments
    cos, sin = np.cos(angle), np.sin(angle)
    parts, start = [], 0
    for points, out in zip(profile, normals, strict=True):
        k = len(points)
        vertices = np.stack(
            [np.outer(points[:, 0], cos), np.outer(points[:, 0], sin), _rows(points[:, 1], segments)], -1
        )
        turned_out = np.stack([np.outer(out[:, 0], cos), np.outer(out[:, 0], sin), _rows(out[:, 1], segments)], -1)
        low = start + (np.arange(k - 1)[:, None] * segments + np.arange(segments)).ravel()
        right = start + (np.arange(k - 1)[:, None] * segments + (np.arange(segments) + 1) % segments).ravel()
        quads = np.concatenate(
            [np.stack([low, right, right + segments], 1), np.stack([low, right + segments, low + segments], 1)]
        )
        parts.append((vertices.reshape(-1, 3), turned_out.reshape(-1, 3), quads))
        start += k * segments
    vertices, out, faces = (np.concatenate(column) for column in zip(*parts, strict=True))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(name, vertices, faces[0.5 * area > _NO_AREA], out)


def _rows(values: np.ndarray, count: int) -> np.ndarray:
    return np.repeat(values[:, None], count, axis=1)


def tube(radius: float, height: float, segments: int, name: str, inwards: bool = False) -> Mesh:
    """Return an upright cylinder about the origin with both its ends closed; smooth round, sharp at the rims."""
    z, one = height / 2, 1.0
    curves = [[[0, -z], [radius, -z]], [[radius, -z], [radius, z]], [[radius, z], [0, z]]]
    out = [[[0, -one]] * 2, [[one, 0]] * 2, [[0, one]] * 2]
    mesh = revolved([np.array(c, float) for c in curves], [np.array(n, float) for n in out], segments, name)
    return turned(mesh) if inwards else mesh


def plano_convex(radius: float, aperture: float, edge: float, rings: int, segments: int) -> Mesh:
    """Return a plano-convex lens about z: flat face at z = 0, the curved one towards +z.

    Parameters
    ----------
    radius : float
        Of curvature [m].
    aperture : float
        Half the diameter [m].
    edge : float
        Thickness at the edge [m].
    rings, segments : int
        Of the curved face's mesh.
    """
    sag = radius - np.sqrt(radius**2 - aperture**2)
    angle = np.linspace(np.arcsin(aperture / radius), 0.0, rings)
    out = np.stack([np.sin(angle), np.cos(angle)], 1)
    curved = radius * out + [0.0, edge + sag - radius]
    flat, rim = np.array([[0.0, 0.0], [aperture, 0.0]]), np.array([[aperture, 0.0], [aperture, edge]])
    normals = [np.array([[0.0, -1.0]] * 2), np.array([[1.0, 0.0]] * 2), out]
    return revolved([flat, rim, curved], normals, segments, "lens")
