"""Rigid motions under which an object's surface is the same, so that no picture of its shape tells its poses apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..core.mesh import Mesh, joined
from ..procedural.description.scene import Prop, SceneObject, Vessel

#: A vertex moved this far from the nearest one, as a share of the longest side, is still in its place: meshes are cut
#: to parts of a millimetre.
_SAME = 1e-3
#: Normals of the faces round a vertex that differ less than this lie in one plane.
_FLAT = 1e-3
#: Turns about z that are tried: prisms of up to eight sides, and some to spare.
_MOST_FOLD = 12
#: Vertices that a motion is tried on first; most fail with these.
_FEW = 64


@dataclass(frozen=True, eq=False)
class Symmetry:
    """How an object may be moved and look the same."""

    turns: bool  #: by every turn about its z axis
    ball: bool  #: by every rotation about its middle
    motions: np.ndarray  #: (m, 4, 4) float64, object frame [m]: the identity first; with `turns`, besides these


#: No symmetry, that of a solid of revolution whose ends differ, and that of a ball.
ASYMMETRIC, REVOLUTION, BALL = (
    Symmetry(turns, ball, np.eye(4)[None]) for turns, ball in ((False, False), (True, False), (True, True))
)


def symmetry_of(item: SceneObject) -> Symmetry:
    """Return the symmetry of an object's shape; looks are not regarded."""
    if isinstance(item, Vessel):  # an open end, and often a liquid
        return REVOLUTION
    mesh = item.mesh if isinstance(item, Prop) else joined([part.mesh for part in item.interfaces], item.name)
    turns = item.symmetric
    if turns and is_ball(mesh):
        return BALL
    return Symmetry(turns=turns, ball=False, motions=motions_of(mesh, turns))


def is_ball(mesh: Mesh) -> bool:
    """Return whether all vertices are equally far from the origin."""
    away = np.linalg.norm(mesh.vertices.astype(np.float64), axis=1)
    return bool(np.ptp(away) < _SAME * away.max())


def motions_of(mesh: Mesh, turns: bool = False) -> np.ndarray:
    """Return the rotations that put every vertex of a mesh onto a vertex, (m, 4, 4), the identity first.

    They turn about the mean of the vertices, which each of them leaves where it is. Tried are the rotations of a cube,
    those of a prism about z, and half turns about lines across it; of a solid of revolution, one half turn.

    Parameters
    ----------
    mesh : Mesh
        Of the object, in its frame.
    turns : bool
        Whether it is a solid of revolution about z.
    """
    vertices = _shaping(mesh)
    middle = vertices.mean(axis=0)
    if turns:
        middle[:2] = 0.0
    centred = vertices - middle
    tree, reach = cKDTree(centred), _SAME * float(np.ptp(vertices, axis=0).max())

    def same(rotation: np.ndarray) -> bool:
        few = centred[:: max(1, len(centred) // _FEW)]
        return all((tree.query(points @ rotation.T)[0] < reach).all() for points in (few, centred))

    if turns:
        tried = [_about((1.0, 0.0, 0.0), np.pi)]
    else:
        fold = next((n for n in range(_MOST_FOLD, 1, -1) if same(_about((0.0, 0.0, 1.0), 2.0 * np.pi / n))), 1)
        tried = _candidates(fold)
    found = [np.eye(4)]
    for rotation in tried:
        known = any(np.abs(rotation - motion[:3, :3]).max() < 1e-6 for motion in found)
        if not known and same(rotation):
            motion = np.eye(4)
            motion[:3, :3], motion[:3, 3] = rotation, middle - rotation @ middle
            found.append(motion)
    return np.stack(found)


def _shaping(mesh: Mesh) -> np.ndarray:
    """Return the positions where a mesh is not flat, (n, 3) float64: others say how it was cut, not what it is."""
    positions, number = np.unique(mesh.vertices.astype(np.float64), axis=0, return_inverse=True)
    faces = number.reshape(-1)[mesh.faces]
    a, b, c = (positions[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    low, high = (np.full((len(positions), 3), bound) for bound in (np.inf, -np.inf))
    for corner in faces.T:
        np.minimum.at(low, corner, normals)
        np.maximum.at(high, corner, normals)
    return positions[(high - low > _FLAT).any(axis=1)]


def _candidates(fold: int) -> list[np.ndarray]:
    cube = list(Rotation.create_group("O").as_matrix())
    turns = [_about((0.0, 0.0, 1.0), 2.0 * np.pi * k / fold) for k in range(1, fold)]
    lines = np.pi * np.arange(2 * fold) / (2 * fold)
    return cube + turns + [_about((np.cos(angle), np.sin(angle), 0.0), np.pi) for angle in lines]


def _about(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    return Rotation.from_rotvec(angle * np.array(axis)).as_matrix()
