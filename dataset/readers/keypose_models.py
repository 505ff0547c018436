"""KeyPose's models: a mesh with its keypoints, and the pose that puts them onto keypoints that were measured."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...annotate.symmetries import ASYMMETRIC, BALL, REVOLUTION, Symmetry
from ...core.errors import InputError, cause_of

#: Symmetries by category. The data set states none of a heart and a tree, whose models are no solids of revolution.
_SYMMETRIES = {"ball": BALL, "bottle": REVOLUTION, "cup": REVOLUTION, "mug": ASYMMETRIC}
#: Largest mean distance between aligned keypoints of a model and those of a frame [m]: beyond it they are those of
#: another object. KeyPose states 3.4 mm of error for its own labels.
_WORST_FIT = 0.01
#: Longest side of a model [m]: longer ones are not in metres.
_LONGEST = 1.0
#: Spread across the axis that makes keypoints lie on one, over that along it [1].
_ON_AXIS = 1e-3


@dataclass(frozen=True, eq=False)
class KeyposeModel:
    """A model; its frame has its origin at the centre of the mesh's box, and the axes of the file."""

    size: np.ndarray  #: (3,) float64 [m]
    keypoints: np.ndarray  #: (k, 3) float64 [m]


def category_of(name: str) -> str:
    """Return the category of an object, such as ``bottle`` of ``bottle_0``."""
    return re.sub(r"_\d+$", "", name)


def symmetry_of_category(category: str) -> Symmetry | None:
    """Return the symmetry of a category's objects; None where the data set states none (the heart)."""
    return _SYMMETRIES.get(category)


def read_model(path: Path) -> KeyposeModel:
    """Return a model of an OBJ file with the groups ``mesh`` and ``kp.000``, ``kp.001`` and so on, in metres.

    A keypoint is a small cube, and its centre the point.
    """
    groups = _vertices(path)
    mesh = groups.pop("mesh", None)
    if mesh is None or not groups:
        raise InputError(path, "a group mesh, and groups kp.000 and so on", ", ".join(sorted(groups)) or "none")
    low, high = mesh.min(axis=0), mesh.max(axis=0)
    if not ((high - low) > 0.0).all() or not (high - low).max() < _LONGEST:
        raise InputError(path, f"a mesh in metres, of sides up to {_LONGEST:g} m", f"sides {(high - low).tolist()}")
    points = np.stack([(groups[name].min(axis=0) + groups[name].max(axis=0)) / 2.0 for name in sorted(groups)])
    if len(points) == 1:  # a ball, whose keypoint is its centre; the vertices of the file cover it unevenly
        diameter = 2.0 * float(np.median(np.linalg.norm(mesh - points[0], axis=1)))
        return KeyposeModel(np.full(3, diameter), np.zeros((1, 3)))
    return KeyposeModel(high - low, points - (low + high) / 2.0)


def aligned(model: KeyposeModel, points: np.ndarray, symmetry: Symmetry | None, where: str) -> np.ndarray | None:
    """Return the pose that brings the keypoints of a model to measured ones with the least squares, (4, 4) float64.

    With keypoints on an axis of revolution the turn about it is arbitrary: the one that turns the model least. None
    where keypoints on a line, or a single one, leave a turn open that the object's symmetry does not. (Kabsch, Acta
    Crystallographica A 32, 1976, with the sign of the determinant fixed.)

    Parameters
    ----------
    model : KeyposeModel
        The model.
    points : (k, 3) float
        Its keypoints in the camera frame [m], in the same order; KeyPose labels fewer than a model has, the first ones.
    symmetry : Symmetry, optional
        Of the object.
    where : str
        File and field, for the error where the fit is bad.
    """
    if len(points) > len(model.keypoints):
        raise InputError(where, f"at most the {len(model.keypoints)} keypoints of the model", len(points))
    local = model.keypoints[: len(points)]
    middle, centre = points.mean(axis=0), local.mean(axis=0)
    if not _is_determined(local - centre, symmetry):
        return None
    pose = np.eye(4)
    pose[:3, :3] = _rotation(local - centre, points - middle)
    pose[:3, 3] = middle - pose[:3, :3] @ centre
    error = float(np.linalg.norm(local @ pose[:3, :3].T + pose[:3, 3] - points, axis=1).mean())
    if error > _WORST_FIT:
        raise InputError(where, f"keypoints within {1e3 * _WORST_FIT:g} mm of the model's", f"{1e3 * error:.1f} mm")
    return pose


def _is_determined(local: np.ndarray, symmetry: Symmetry | None) -> bool:
    """Return whether keypoints, about their mean, and a symmetry leave no turn open."""
    spread = np.linalg.svd(local, compute_uv=False)
    if len(spread) > 1 and spread[1] > _ON_AXIS * spread[0] > 0.0:
        return True
    return symmetry is not None and (symmetry.ball or (symmetry.turns and len(local) > 1))


def _rotation(local: np.ndarray, points: np.ndarray) -> np.ndarray:
    spread = np.linalg.svd(local, compute_uv=False)
    if len(local) < 2 or spread[0] == 0.0:
        return np.eye(3)
    if len(spread) < 2 or spread[1] < _ON_AXIS * spread[0]:
        along = local[np.argmax(np.linalg.norm(local, axis=1))]
        return _shortest_turn(along, points[np.argmax(np.linalg.norm(local, axis=1))])
    U, _, Vt = np.linalg.svd(points.T @ local)
    return U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt


def _shortest_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the rotation by the least angle that takes one direction to another."""
    a, b = start / np.linalg.norm(start), end / np.linalg.norm(end)
    axis, cosine = np.cross(a, b), float(a @ b)
    if cosine < -1.0 + 1e-9:  # half a turn, about any axis across
        across = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        across /= np.linalg.norm(across)
        return 2.0 * np.outer(across, across) - np.eye(3)
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def _vertices(path: Path) -> dict[str, np.ndarray]:
    """Return the vertices of an OBJ file by group."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise InputError(path, "a readable OBJ file", cause_of(error)) from error
    found: dict[str, list[list[float]]] = {}
    name = ""
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if words[:1] == ["o"] or words[:1] == ["g"]:
            name = words[1] if len(words) > 1 else ""
        elif words[:1] == ["v"]:
            try:
                x, y, z = (float(word) for word in words[1:4])
            except ValueError as error:  # too few words, as at the end of half a file, or no numbers
                raise InputError(f"{path}, line {number}", "three numbers", line) from error
            found.setdefault(name, []).append([x, y, z])
    return {name: np.array(rows) for name, rows in found.items()}
