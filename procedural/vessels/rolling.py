"""A ball rolled along the inside of a wall: the construction of base corners and insides.

Let S be the solid ``{r <= f(z), z >= floor}``. Eroding it by ``clearance + ball`` and dilating the result by ``ball``
(a morphological opening after an erosion, Serra 1982, "Image Analysis and Mathematical Morphology", ch. II) gives
all points that a ball reaches which keeps ``clearance`` from the wall. The result is never nearer to the wall than
``clearance``; its convex corners are round with the radius of the ball; and because the erosion of a graph over z by
discs is again a graph over z, it never crosses itself, however tight the wall's curvature is.
"""

from __future__ import annotations

import numpy as np

from ..profiles.curve import ARC_STEP, Curve, arc, chained, directions

#: How much nearer than touching another point of the wall may be [m]: absorbs the discretisation of the wall
#: (points 0.1 mm apart see their own disc's envelope wrong by less), and is far below every length that matters.
TOUCH_TOLERANCE = 1e-7


class NoRoomError(ValueError):
    """The wall leaves no room inside: a shape that no vessel has."""


def rolled(wall: Curve, clearance: np.ndarray, ball: float, floor: float) -> tuple[Curve, int]:
    """Return the boundary of what the ball reaches, and which point of the wall it touches last.

    Parameters
    ----------
    wall : Curve
        The wall, going up: z never falls along it; normals point away from the side where the ball is, and turn
        little from point to point (it is smooth, or its corners are round).
    clearance : (n,) float
        Distance to keep at each point of the wall; changes slowly [m].
    ball : float
        Radius of the ball [m].
    floor : float
        Height below which the ball does not reach [m]; over a tight corner of the wall it may not come down to it.

    Returns
    -------
    Curve
        From the axis at the floor (or where the wall leaves no more room) up; normals point towards the wall.
    int
        Index of the wall's point that the end of the curve faces, at exactly ``clearance``.

    Raises
    ------
    NoRoomError
        Where the wall leaves the ball no room above the floor.
    """
    centres, towards, index = _free_centres(wall, clearance + ball)
    centres, towards = _above(centres, towards, floor + ball)
    angles = np.arctan2(towards[:, 1], towards[:, 0])
    centres, angles = _with_round_kinks(centres, angles)
    normals = directions(angles)
    side = Curve(centres + ball * normals, normals)
    corner = arc(centres[0], ball, -0.5 * np.pi, angles[0])
    # Exactly below the centre: on the axis to the last bit where the centre is.
    corner.points[0], corner.normals[0] = centres[0] - (0.0, ball), (0.0, -1.0)
    if centres[0, 0] == 0.0:
        return chained(corner, side), index
    down = np.array([[0.0, -1.0], [0.0, -1.0]])
    return chained(Curve(np.array([[0.0, corner.points[0, 1]], corner.points[0]]), down), corner, side), index


def _free_centres(wall: Curve, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Centres of the discs of radius `reach` that touch the wall at one of its points and cut it nowhere.

    The centre belongs to the envelope of the family of discs, so the direction to the touched point is the wall's
    normal turned by arcsin of the reach's derivative along the wall.
    """
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(wall.points, axis=0).T))])
    slope = np.gradient(reach, length)[:, None]
    tangents = np.stack([-wall.normals[:, 1], wall.normals[:, 0]], axis=-1)
    towards = slope * tangents + np.sqrt(1.0 - slope**2) * wall.normals
    centres = wall.points - reach[:, None] * towards
    free = _gap(centres, wall.points, reach) >= -TOUCH_TOLERANCE
    # Along the boundary of a graph over z, heights rise; points that do not rise are due to the tolerance.
    highest = np.maximum.accumulate(np.where(free, centres[:, 1], -np.inf))
    free &= np.concatenate([[True], centres[1:, 1] > highest[:-1]])
    if not free.any():
        raise NoRoomError(f"the wall leaves no room for a ball and a clearance of {reach.min():.4f} m anywhere")
    return centres[free], towards[free], int(np.flatnonzero(free)[-1])


def _gap(centres: np.ndarray, wall: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Smallest of (distance to a wall point - its reach) over the wall points within reach in height, (n,)."""
    first = np.searchsorted(wall[:, 1], centres[:, 1] - reach.max())
    after = np.searchsorted(wall[:, 1], centres[:, 1] + reach.max(), side="right")
    window = first[:, None] + np.arange((after - first).max())[None, :]
    window = np.minimum(window, len(wall) - 1)
    distance = np.hypot(wall[window, 0] - centres[:, :1], wall[window, 1] - centres[:, 1:])
    return (distance - reach[window]).min(axis=1)


def _above(centres: np.ndarray, towards: np.ndarray, lowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Keep the part connected to the top end that is off the axis and not below `lowest`.

    Where the ball touches the wall twice before it comes down to `lowest`, as over a tight corner at the base, all of
    it is kept: the floor then lies as low as the ball goes.
    """
    room = np.minimum(centres[:, 0], centres[:, 1] - lowest)
    blocked = np.flatnonzero(room <= 0.0)
    if len(blocked) == 0:
        return centres, towards
    if blocked[-1] + 1 >= len(room):
        raise NoRoomError(f"the wall leaves no room for the ball above {lowest:.4f} m")
    i = int(blocked[-1])
    at_axis, at_floor = (
        0.0 if low > 0.0 else -low / (high - low)
        for low, high in zip(centres[i] - (0.0, lowest), centres[i + 1] - (0.0, lowest), strict=True)
    )
    fraction = max(at_axis, at_floor)
    start = centres[i] + fraction * (centres[i + 1] - centres[i])
    if at_axis >= at_floor:
        start[0] = 0.0
    facing = towards[i] + fraction * (towards[i + 1] - towards[i])
    centres = np.concatenate([start[None], centres[i + 1 :]])
    return centres, np.concatenate([facing[None] / np.hypot(*facing), towards[i + 1 :]])


def _with_round_kinks(centres: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Insert points where the ball touches the wall twice, so that the jump of its direction becomes an arc."""
    pieces = np.maximum(1, np.ceil(np.abs(np.diff(angles)) / ARC_STEP)).astype(int)
    part = np.arange(1, pieces.sum() + 1) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    position = np.concatenate([[0.0], np.repeat(np.arange(len(pieces)), pieces) + part / np.repeat(pieces, pieces)])
    index = np.arange(len(angles))
    finer = np.stack([np.interp(position, index, column) for column in centres.T], axis=-1)
    return finer, np.interp(position, index, angles)
