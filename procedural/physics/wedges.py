"""Solids of revolution as convex bodies: rings of wedges, each the hull of a piece of the section over a small turn.

A wall of glass is hollow, and what lies in a bowl or leans on its rim touches the wall, not the hull around it. Every
wedge contains its piece of the solid: its outer corners lie outside the circle by as much as its chord's middle would
lie inside. So bodies that keep apart from the wedges keep apart from the solid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .sections import area, coarser, convex_pieces, hull

#: How far wedges may reach beyond the solid [m]: in notches of the section, on the outside between facets, and on the
#: inside over chords. A third of the overlap that counts, and below what a picture shows at half a metre.
WEDGE_TOLERANCE = 1.5e-4
#: How far rounded corners may reach beyond the solid so that they have fewer corners [m].
CORNER_TOLERANCE = 5e-5
#: Fewest wedges of a ring [1], and sides of a full turn of a convex piece.
LEAST_WEDGES, FULL_TURN_SIDES = 12, 64
#: How much more area than its mirrored piece a hull may have where a full turn is one convex body [1].
_CONVEX_TURN = 1.005
#: Distance from the axis that counts as on it [m].
_ON_AXIS = 1e-7


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A convex body, repeated about the z axis.

    Parameters
    ----------
    points : (n, 3) float64
        Its corners, object frame [m].
    turns : int
        How often it is there, in equal turns about z; 1 is once.
    """

    points: np.ndarray
    turns: int = 1


def revolved_parts(outline: np.ndarray, tolerance: float = WEDGE_TOLERANCE) -> list[ConvexPart]:
    """Return convex bodies that together contain a solid of revolution about the z axis.

    Parameters
    ----------
    outline : (n, 2) float
        Its half section, counter-clockwise, rows (r, z) with r >= 0 [m].
    tolerance : float
        How far they may reach beyond it [m].
    """
    return [_part(piece, tolerance) for piece in convex_pieces(outline, tolerance)]


def revolved_hull(outline: np.ndarray) -> np.ndarray:
    """Return the corners (n, 3) of a convex body around a solid of revolution: its hull, with flat sides outside."""
    both = hull(_mirrored(outline))
    half = coarser(hull(np.maximum(both, (0.0, -np.inf))), CORNER_TOLERANCE)
    return _turned(half * _outside(FULL_TURN_SIDES), _angles(FULL_TURN_SIDES))


def _part(piece: np.ndarray, tolerance: float) -> ConvexPart:
    piece = coarser(piece, CORNER_TOLERANCE)
    if piece[:, 0].min() <= _ON_AXIS and area(hull(_mirrored(piece))) <= 2.0 * _CONVEX_TURN * area(piece):
        return ConvexPart(_turned(piece * _outside(FULL_TURN_SIDES), _angles(FULL_TURN_SIDES)))
    radius = float(piece[:, 0].max())
    count = max(LEAST_WEDGES, int(np.ceil(np.pi / np.arccos(1.0 - min(tolerance / radius, 1.0)))))
    # The inside keeps its radius, so that the chord over the hollow reaches in; the outside is moved out.
    section = hull(np.concatenate([piece, piece * _outside(count)]))
    return ConvexPart(_turned(section, np.array([-np.pi / count, np.pi / count])), count)


def _outside(count: int) -> np.ndarray:
    """Return the factors (r, z) that move the corners of a regular polygon out until its sides touch the circle."""
    return np.array([1.0 / np.cos(np.pi / count), 1.0])


def _angles(count: int) -> np.ndarray:
    return 2.0 * np.pi * np.arange(count) / count


def _mirrored(piece: np.ndarray) -> np.ndarray:
    return np.concatenate([piece, piece * (-1.0, 1.0)])


def _turned(section: np.ndarray, angles: np.ndarray) -> np.ndarray:
    turned = np.empty((len(angles), len(section), 3))
    turned[..., 0] = np.cos(angles)[:, None] * section[:, 0]
    turned[..., 1] = np.sin(angles)[:, None] * section[:, 0]
    turned[..., 2] = section[:, 1]
    return np.unique(turned.reshape(-1, 3), axis=0)
