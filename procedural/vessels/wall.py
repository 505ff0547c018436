"""From an outline to a wall: the closed profile of a glass solid with an inside, a base and a rounded rim."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..profiles.curve import Curve, arc, chained, simplified
from .outline import Outline
from .rolling import rolled

#: Distance of points on the dense curves [m]; at the tightest radius they have (about 1 mm) the chord error is 1.3 um.
DENSE_STEP = 1e-4
#: Added to the wall for the chord errors of the dense curves [m].
DENSE_MARGIN = 3e-6
#: Radius of the punt over that of the flat base; the vessel stands on the ring outside it.
PUNT_FRACTION = 0.85


@dataclass(frozen=True)
class WallShape:
    """How the glass lies inside the outline [m].

    Parameters
    ----------
    thickness : float
        Smallest thickness across the wall.
    taper : float
        How much thicker the wall is at the bottom; it falls off quadratically to nothing at the top.
    base : float
        Thickness between the crown of the punt and the floor; where the wall is thicker, the base is as thick.
    fillet : float
        Radius of the outer corner at the base.
    corner : float
        Radius of the corner between floor and wall, and the tightest curve of the inside.
    punt : float
        Height of the hollow under the base; 0 is flat.
    """

    thickness: float
    taper: float
    base: float
    fillet: float
    corner: float
    punt: float


@dataclass(frozen=True, eq=False)
class Section:
    """Half of a vessel's section: two curves from the axis to the crown of the rim. Normals point out of the glass.

    Parameters
    ----------
    outer : Curve
        From the axis at the base along the outside up to the crown.
    inner : Curve
        From the axis at the floor along the inside up to the crown, the same point.
    rim_centre : (2,) float64
        Centre of the half circle that rounds the rim [m].
    rim_radius : float
        Its radius [m].
    """

    outer: Curve
    inner: Curve
    rim_centre: np.ndarray
    rim_radius: float


def glass_section(outline: Outline, shape: WallShape, chord_error: float) -> Section:
    """Return the section of a vessel whose glass is nowhere thinner than its wall.

    The outside is the outline with its base corner rounded by a ball; the inside is what a second ball reaches that
    keeps the wall's thickness from the outside (`rolling.rolled`). So the thickness holds across the wall, not along
    the radius; inside and outside are smooth and never cross; where the outline leaves no room (a stem), the glass is
    solid. The rim is a half circle tangent to both.

    Parameters
    ----------
    outline : Outline
        The outside of the wall.
    shape : WallShape
        Thickness, base and roundings.
    chord_error : float
        Largest distance of the section's polygon from the true curves [m]. The wall is built thicker by twice that,
        so that the polygon itself keeps the thickness.

    Returns
    -------
    Section
        In the outline's frame: the base stands on z = 0.
    """
    dense = outline.sampled(DENSE_STEP)
    outside, _ = rolled(dense, np.zeros(len(dense.points)), shape.fillet, 0.0)
    side = Curve(outside.points[1:], outside.normals[1:])
    thickness = shape.thickness + 2.0 * chord_error + DENSE_MARGIN
    # Quadratic, so that the wall is as thick as its end where the rim begins, and the rim's half circle tangent.
    clearance = thickness + shape.taper * (1.0 - side.points[:, 1] / side.points[-1, 1]) ** 2
    floor = max(shape.punt + max(shape.base, clearance[0] + DENSE_MARGIN), outline.solid_below)
    inside, last = rolled(side, clearance, shape.corner, floor)
    side = Curve(side.points[: last + 1], side.normals[: last + 1])
    return _closed(underside(float(side.points[0, 0]), shape.punt, chord_error), side, inside, chord_error)


def round_section(side: Curve, thickness: float, taper: float, chord_error: float) -> Section:
    """Return the section of a vessel whose outside begins on the axis, as round bottoms do.

    The inside keeps the thickness along the normals, which is its distance where the outside's curves are wider than
    it.

    Parameters
    ----------
    side : Curve
        The outside, dense, from the axis at z = 0 to where the rim begins; normals out of the glass.
    thickness, taper : float
        Smallest thickness, and how much thicker the wall is at the bottom [m].
    chord_error : float
        As in `glass_section`.
    """
    reach = thickness + 2.0 * chord_error + DENSE_MARGIN + taper * (1.0 - side.points[:, 1] / side.points[-1, 1]) ** 2
    inside = Curve(side.points - reach[:, None] * side.normals, side.normals)
    inside.points[0, 0] = 0.0
    return _closed(None, side, inside, chord_error)


def underside(radius: float, punt: float, chord_error: float) -> Curve:
    """Return the base from the axis to `radius`: a hollow with a standing ring around it; normals out of the glass."""
    if punt == 0.0:
        return Curve(np.array([[0.0, 0.0], [radius, 0.0]]), np.array([[0.0, -1.0], [0.0, -1.0]]))
    edge = PUNT_FRACTION * radius
    r = np.linspace(0.0, edge, max(3, int(edge / DENSE_STEP)))
    z = 0.5 * punt * (1.0 + np.cos(np.pi * r / edge))
    slope = -0.5 * punt * np.pi / edge * np.sin(np.pi * r / edge)
    hollow = Curve(np.stack([r, z], -1), np.stack([slope, -np.ones_like(r)], -1) / np.hypot(1.0, slope)[:, None])
    # The ring stays as it is, so that the vessel stands on it.
    return chained(
        simplified(hollow, chord_error),
        Curve(np.array([[edge, 0.0], [radius, 0.0]]), np.array([[0.0, -1.0], [0.0, -1.0]])),
    )


def _closed(base: Curve | None, side: Curve, inside: Curve, chord_error: float) -> Section:
    """Join side and inside by a half circle over their ends, split at its highest point, and simplify both."""
    end, facing = side.points[-1], inside.points[-1]
    centre, radius = 0.5 * (end + facing), 0.5 * float(np.hypot(*(end - facing)))
    start = float(np.arctan2(*side.normals[-1, ::-1]))
    outer_rim = arc(centre, radius, start, 0.5 * np.pi)
    inner_rim = arc(centre, radius, start + np.pi, 0.5 * np.pi)
    # One crown for both, bit for bit.
    inner_rim.points[-1] = outer_rim.points[-1]
    inner_rim.normals[-1] = outer_rim.normals[-1]
    # Each part on its own: a segment from far down the straight wall to some way round the rim would lean the normals
    # of all that is between, and the line of light on a rim becomes a row of dots.
    outside = [simplified(side, chord_error), simplified(outer_rim, chord_error)]
    return Section(
        outer=chained(*outside) if base is None else chained(base, *outside),
        inner=chained(
            simplified(Curve(inside.points, -inside.normals), chord_error), simplified(inner_rim, chord_error)
        ),
        rim_centre=centre,
        rim_radius=radius,
    )
