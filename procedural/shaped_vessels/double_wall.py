"""Double-walled glasses: two walls, joined at the rim, around a sealed space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..profiles.curve import Curve, kept_points
from ..vessels.rolling import rolled
from .forms import Form, falling, round_form
from .loft import HalfSection, Inside, Solid, loft
from .shapes import Drawn, Shape

#: Largest width of the space between the walls, and that at its upper end [m]; it narrows over the upper part of the
#: height [1]; the walls are one above it [m].
GAP, NARROW, NARROWS, JOINED = (0.005, 0.010), 0.0016, (0.15, 1.0), 0.005
#: Thickness of the inner wall across from the outside, over the outer wall's [1]: as the space narrows, it leans.
INNER = 1.06
#: Radius of the space's lower corner, and thickness of its floor over that of the walls [m, 1].
CORNER, FLOOR = 0.004, 1.3


def double_wall(rng: np.random.Generator, drawn: Drawn) -> Shape:
    """Draw the space between two walls."""
    form = round_form(drawn.segments)
    return Shape(form, form, gap=rng.uniform(*GAP))


def double_walled(
    section: HalfSection, form: Form, inside: Inside, gap: float, chord_error: float
) -> tuple[Solid, float]:
    """Return the glass of two walls with a space between them, and the height of its brim [m].

    Parameters
    ----------
    section : HalfSection
        The outside.
    form : Form
        A circle.
    inside : Inside
        Thickness of each wall, floor and corner of a glass without a space.
    gap : float
        Largest width of the space [m].
    chord_error : float
        As in `section.half_section`.

    Raises
    ------
    NoRoomError
        Where the walls leave no room inside.
    """
    top = float(section.curve.points[-1, 1])
    narrowing = falling(NARROWS[0] * top, NARROWS[1] * top)

    def width(u: np.ndarray, z: np.ndarray) -> np.ndarray:
        return NARROW + (gap - NARROW) * narrowing(z) + 0.0 * u

    def whole(u: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (1.0 + INNER) * inside.thickness(u, z) + width(u, z)

    # Above the space the walls are one, and the rim rounds it.
    bottom = inside.floor + gap
    deep = replace(inside, thickness=whole, floor=bottom + FLOOR * float(inside.thickness(np.zeros(1), np.zeros(1))[0]))
    glass = loft(section, form, form, deep)
    within = _within(section, inside, chord_error)
    # The space is as wide as it is across from the outside, not from its own wall, which is a little lower or higher.
    own, normals = within.curve.points[within.side :, 1], within.curve.normals[within.side :, 1]
    from_outside = own + inside.thickness(np.zeros(1), own) * normals

    def own_width(u: np.ndarray, z: np.ndarray) -> np.ndarray:
        return width(u, np.interp(z, own, from_outside))

    space = loft(within, form, form, Inside(own_width, bottom, CORNER))
    turned = space.solid
    count = len(glass.solid.vertices)
    solid = Solid(
        np.concatenate([glass.solid.vertices, turned.vertices]),
        np.concatenate([glass.solid.normals, -turned.normals]),
        np.concatenate([glass.solid.faces, turned.faces[:, ::-1] + count]),
        np.concatenate([glass.solid.inner, np.zeros(len(turned.faces), bool)]),
    )
    return solid, glass.brim


def _within(section: HalfSection, inside: Inside, chord_error: float) -> HalfSection:
    """Return the outside of the space: the inner side of the outer wall."""
    wall = Curve(section.curve.points[section.side :], section.curve.normals[section.side :])
    thickness = inside.thickness(np.zeros(1), wall.points[:, 1])
    curve, _ = rolled(wall, thickness, CORNER, inside.floor)
    kept = curve.points[:, 1] <= wall.points[-1, 1] - JOINED
    # The first point lies on the axis, the floor's edge follows.
    curve = Curve(curve.points[kept], curve.normals[kept])
    side = int(np.argmax(curve.normals[:, 1] > -0.5))
    rows = [np.array(kept_points(Curve(curve.points[a:b], curve.normals[a:b]), chord_error)) for a, b in _parts(side)]
    return HalfSection(curve, side, np.unique(np.concatenate([[0], rows[0] + 1, rows[1] + side])))


def _parts(side: int) -> tuple[tuple[int, int | None], ...]:
    return (1, side + 1), (side, None)
