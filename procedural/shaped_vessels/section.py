"""From an outline to the half section that is lofted, and small irregularities of the whole vessel."""

from __future__ import annotations

import numpy as np

from ..profiles.curve import Curve, chained, kept_points
from ..vessels.outline import Outline
from ..vessels.rolling import rolled
from ..vessels.wall import DENSE_STEP, underside
from .loft import HalfSection, Solid

#: Largest irregularities of a vessel: ellipticity, lean of the axis [1]. Drinking glasses are round to 1 % and upright
#: to some 0.5 degrees; what is visible is refused at the cold end.
OVAL, LEAN = 0.004, 0.006


def half_section(outline: Outline, fillet: float, punt: float, chord_error: float) -> HalfSection:
    """Return the outside of half a section: base with a hollow, round corner, wall up to the rim.

    Parameters
    ----------
    outline : Outline
        The wall.
    fillet, punt : float
        Radius of the base's corner, and height of the hollow under the base [m].
    chord_error : float
        Largest distance of the mesh's rows from the curve [m].
    """
    dense = outline.sampled(DENSE_STEP)
    outside, _ = rolled(dense, np.zeros(len(dense.points)), fillet, 0.0)
    wall = Curve(outside.points[1:], outside.normals[1:])
    base = underside(float(wall.points[0, 0]), punt, chord_error)
    curve = chained(base, wall)
    before = len(base.points) - 1
    side = before + _corner_end(wall, fillet)
    # The side's first point is a row, as what is around the cavity begins there.
    rows = [
        np.arange(before),
        before + np.array(kept_points(_part(curve, before, side + 1), chord_error)),
        side + np.array(kept_points(_part(curve, side, None), chord_error)),
    ]
    return HalfSection(curve, side, np.unique(np.concatenate(rows)))


def _corner_end(wall: Curve, fillet: float) -> int:
    """Return the number of the point where the base's corner ends: from there on the curve bends less."""
    angles = np.unwrap(np.arctan2(wall.normals[:, 1], wall.normals[:, 0]))
    lengths = np.maximum(np.hypot(*np.diff(wall.points, axis=0).T), 1e-12)
    return int(np.argmax(np.abs(np.diff(angles)) / lengths < 0.5 / fillet))


def _part(curve: Curve, start: int, stop: int | None) -> Curve:
    return Curve(curve.points[start:stop], curve.normals[start:stop])


def moved(solid: Solid, matrix: np.ndarray) -> Solid:
    """Return a solid under a linear map, (3, 3), that does not turn it inside out."""
    normals = solid.normals @ np.linalg.inv(matrix)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Solid(solid.vertices @ matrix.T, normals, solid.faces, solid.inner)


def irregularity(rng: np.random.Generator) -> np.ndarray:
    """Draw a map near the identity, (3, 3), that makes a vessel a little elliptical and lets it lean a little.

    The plane that it stands on stays, and the wall's thickness changes by less than `OVAL`.
    """
    angle, oval = rng.uniform(0.0, np.pi), 0.5 * OVAL * rng.uniform()
    lean, towards = LEAN * rng.uniform(), rng.uniform(0.0, 2.0 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    matrix = np.eye(3)
    matrix[:2, :2] = turn @ np.diag([1.0 + oval, 1.0 - oval]) @ turn.T
    matrix[:2, 2] = lean * np.cos(towards), lean * np.sin(towards)
    return matrix
