"""Stated symmetries of objects against their surfaces."""

from __future__ import annotations

import numpy as np
import trimesh

from ...procedural.description.scene import MeshVessel, SceneObject
from ..format.objects_file import ContinuousSymmetry, ObjectRecord
from .fault import Fault
from .solids import CHORD, solid_meshes, triangles_of_meshes, worst_distance

#: How far a symmetry may move the surface of a body from a file from itself, as a fraction of the diagonal [1]: who
#: made the file states it, or it is found in scans.
FROM_FILES = 1e-2
#: Irregularities of drawn vessels that are no solids of revolution, which their symmetries leave out (docs/vessels.md,
#: "How a shape is made"): difference of two radii, of the radius; lean of the axis, of the height; difference of the
#: wall's thickness on two sides, of the thickness [1].
OVAL, LEAN, UNEVEN = 4e-3, 6e-3, 0.12
#: Part of a turn that is tried of an axis of revolution [1]: far from none, and of no polygon but those of seven sides.
_TURN = 3.0 / 7.0
#: Vertices that motions are tried on, spread over the surface.
_TRIED = 50


def symmetry_faults(item: SceneObject, record: ObjectRecord, file: str) -> list[Fault]:
    """Check that every symmetry maps the surface onto itself; that of a vessel is its glass."""
    motions = [(np.asarray(motion), reach_of(item, turns=False)) for motion in record.symmetries_discrete]
    motions += [(_turned(axis), reach_of(item, turns=True)) for axis in record.symmetries_continuous]
    if not motions:
        return []
    triangles = triangles_of_meshes(solid_meshes(item))
    points = np.unique(triangles.reshape(-1, 3), axis=0)
    some, faults = points[:: max(1, len(points) // _TRIED)], []
    for motion, reach in motions:
        worst = worst_distance(triangles, some @ motion[:3, :3].T + motion[:3, 3], reach)
        if worst > reach:
            text = f"one that moves it by {1e3 * worst:.2f} mm"
            faults.append(Fault("objects", file, f"object {item.id} symmetries", "motions onto itself", text))
    return faults


def reach_of(item: SceneObject, turns: bool) -> float:
    """Return how far a symmetry may move an object's surface from itself [m].

    Parameters
    ----------
    item : SceneObject
        The object.
    turns : bool
        Whether the symmetry is every turn about the z axis, or a single motion about the object's own axis.
    """
    whole = float(np.linalg.norm(item.size))
    if item.origin is not None:
        return FROM_FILES * whole
    if not isinstance(item, MeshVessel):
        return CHORD * whole
    # A half turn about the vertical through the axis at half height moves both ends by the lean times the height. The
    # middle of the box, through which z goes, is beside that point by half as much at most: by twice the lean then.
    x, y, z = item.size
    lean = (2.0 if turns else 1.0) * LEAN * z
    return CHORD * whole + lean + OVAL * 0.5 * max(x, y) + UNEVEN * (item.wall or 0.0)


def _turned(axis: ContinuousSymmetry) -> np.ndarray:
    return trimesh.transformations.rotation_matrix(2.0 * np.pi * _TURN, axis.axis, axis.offset)
