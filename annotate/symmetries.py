"""Symmetries of objects: rigid motions that map the surface onto itself, so that the poses look the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..core.mesh import Mesh, joined
from ..procedural.description.scene import MeshVessel, Prop, SceneObject, Vessel

#: Largest distance of a moved vertex from the nearest vertex, as a fraction of the longest side: tessellation is
#: accurate to parts of a millimetre.
_POSITION_TOLERANCE = 1e-3
#: Faces around a vertex whose normals differ by less than this are coplanar.
_NORMAL_TOLERANCE = 1e-3
#: Largest order of rotation about z that is tried: prisms have up to eight sides.
_MAX_FOLD = 12
#: Number of vertices that a motion is tried on first; most motions fail on these.
_FIRST_VERTICES = 64


@dataclass(frozen=True, eq=False)
class Symmetry:
    """The motions under which an object looks the same."""

    turns: bool  #: every rotation about the z axis
    ball: bool  #: every rotation about the centre
    motions: np.ndarray  #: (m, 4, 4) float64, object frame [m]: the identity first; with `turns`, besides these


#: No symmetry, that of a solid of revolution whose ends differ, and that of a ball.
ASYMMETRIC, REVOLUTION, BALL = (
    Symmetry(turns, ball, np.eye(4)[None]) for turns, ball in ((False, False), (True, False), (True, True))
)


def symmetry_of(item: SceneObject) -> Symmetry:
    """Return the symmetry of an object's shape; its material is ignored."""
    if isinstance(item, Vessel):  # an open end, and often a liquid
        return REVOLUTION
    turns = item.symmetric
    if item.symmetries and not turns:
        return Symmetry(turns=False, ball=False, motions=np.stack([np.eye(4), *item.symmetries]))
    if isinstance(item, MeshVessel):
        if turns and item.cavities:  # an open end
            return REVOLUTION
        mesh = item.solid
    else:
        mesh = item.mesh if isinstance(item, Prop) else joined([part.mesh for part in item.interfaces], item.name)
    if turns and is_ball(mesh):
        return BALL
    return Symmetry(turns=turns, ball=False, motions=motions_of(mesh, turns))


def is_ball(mesh: Mesh) -> bool:
    """Return whether all vertices are equally far from the origin."""
    away = np.linalg.norm(mesh.vertices.astype(np.float64), axis=1)
    return bool(np.ptp(away) < _POSITION_TOLERANCE * away.max())


def motions_of(mesh: Mesh, turns: bool = False) -> np.ndarray:
    """Return the rotations that map every vertex of a mesh onto a vertex, (m, 4, 4), the identity first.

    All are about the mean of the vertices, which each of them keeps fixed. Candidates are the rotations of a cube,
    those of a prism about z, and half turns about axes across it; for a solid of revolution, one half turn.

    Parameters
    ----------
    mesh : Mesh
        Mesh in the object frame.
    turns : bool
        Whether it is a solid of revolution about z.
    """
    vertices = _shaping(mesh)
    centre = vertices.mean(axis=0)
    if turns:
        centre[:2] = 0.0
    centred = vertices - centre
    tree, reach = cKDTree(centred), _POSITION_TOLERANCE * float(np.ptp(vertices, axis=0).max())

    def same(rotation: np.ndarray) -> bool:
        few = centred[:: max(1, len(centred) // _FIRST_VERTICES)]
        return all((tree.query(points @ rotation.T)[0] < reach).all() for points in (few, centred))

    if turns:
        candidates = [_about((1.0, 0.0, 0.0), np.pi)]
    else:
        fold = next((n for n in range(_MAX_FOLD, 1, -1) if same(_about((0.0, 0.0, 1.0), 2.0 * np.pi / n))), 1)
        candidates = _candidates(fold)
    found = [np.eye(4)]
    for rotation in candidates:
        known = any(np.abs(rotation - motion[:3, :3]).max() < 1e-6 for motion in found)
        if not known and same(rotation):
            motion = np.eye(4)
            motion[:3, :3], motion[:3, 3] = rotation, centre - rotation @ centre
            found.append(motion)
    return np.stack(found)


def _shaping(mesh: Mesh) -> np.ndarray:
    """Return the vertices where a mesh is not flat, (n, 3) float64; others depend on the tessellation alone."""
    positions, number = np.unique(mesh.vertices.astype(np.float64), axis=0, return_inverse=True)
    faces = number.reshape(-1)[mesh.faces]
    a, b, c = (positions[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    low, high = (np.full((len(positions), 3), bound) for bound in (np.inf, -np.inf))
    for corner in faces.T:
        np.minimum.at(low, corner, normals)
        np.maximum.at(high, corner, normals)
    return positions[(high - low > _NORMAL_TOLERANCE).any(axis=1)]


def _candidates(fold: int) -> list[np.ndarray]:
    cube = list(Rotation.create_group("O").as_matrix())
    turns = [_about((0.0, 0.0, 1.0), 2.0 * np.pi * k / fold) for k in range(1, fold)]
    lines = np.pi * np.arange(2 * fold) / (2 * fold)
    return cube + turns + [_about((np.cos(angle), np.sin(angle), 0.0), np.pi) for angle in lines]


def _about(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    return Rotation.from_rotvec(angle * np.array(axis)).as_matrix()
