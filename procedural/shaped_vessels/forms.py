"""Cross-sections of vessels: where a point of the half section goes at each place around the vessel.

A form maps (u, r, z) to (x, y): u in [0, 1) goes once around, counter-clockwise; (r, z) is a point of the half section.
The height z stays. All forms are homothetic in r near the axis, so that a flat base stays flat.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

#: (u, r, z), which broadcast, to (..., 2) [m].
PlaneMap = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
#: A weight over the height [m], 0 to 1.
Weight = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Form:
    """A cross-section that may vary with the height.

    Parameters
    ----------
    xy : callable
        The map.
    columns : tuple of float
        Places around at which the mesh has vertices, ascending.
    fold : int
        Number of turns about z that leave it unchanged; 0 where all do.
    heights : tuple of (float, float)
        Ranges of height in which the cross-section changes: the mesh has rows there [m].
    """

    xy: PlaneMap
    columns: tuple[float, ...]
    fold: int
    heights: tuple[tuple[float, float], ...] = ()


def everywhere(z: np.ndarray) -> np.ndarray:
    """Return the weight 1."""
    return np.ones_like(z)


def rising(low: float, high: float) -> Weight:
    """Return a weight that rises from 0 to 1 between two heights [m], with a continuous curvature.

    The quintic ``6 t^5 - 15 t^4 + 10 t^3`` (Perlin 2002, "Improving noise").
    """

    def weight(z: np.ndarray) -> np.ndarray:
        t = np.clip((z - low) / (high - low), 0.0, 1.0)
        return t**3 * (t * (6.0 * t - 15.0) + 10.0)

    return weight


def falling(low: float, high: float) -> Weight:
    """Return a weight that falls from 1 to 0 between two heights [m]."""
    up = rising(low, high)
    return lambda z: 1.0 - up(z)


def directions(u: np.ndarray) -> np.ndarray:
    """Return the unit vectors at fractions of a turn, (..., 2)."""
    return np.stack([np.cos(2.0 * np.pi * u), np.sin(2.0 * np.pi * u)], axis=-1)


def round_form(columns: int | tuple[float, ...]) -> Form:
    """Return the form of a solid of revolution."""
    places = tuple((np.arange(columns) / columns).tolist()) if isinstance(columns, int) else columns
    return Form(lambda u, r, z: r[..., None] * directions(u + 0.0 * r), places, 0)


def polygon_form(corners: np.ndarray, fold: int, corner: float, arc_steps: int, side_steps: int) -> Form:
    """Return a convex polygon with round corners.

    At r it is the polygon, scaled by ``r (1 - corner)``, with a disc of radius ``r corner`` rolled around it. Its sides
    are flat where the section is straight.

    Parameters
    ----------
    corners : (n, 2) float
        Counter-clockwise, about the origin; the nearest side is 1 away from the origin.
    fold : int
        Number of turns that leave it unchanged.
    corner : float
        Radius of the corners over r, above 0 and below 1 [1].
    arc_steps, side_steps : int
        Segments of each corner and of each side.
    """
    count = len(corners)
    along = np.roll(corners, -1, axis=0) - corners
    angle = np.unwrap(np.arctan2(-along[:, 0], along[:, 1]))  # of the normal of the side that begins at each corner
    before = np.concatenate([[angle[-1] - 2.0 * np.pi], angle[:-1]])

    def xy(u: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = np.mod(u, 1.0) * count
        k = np.minimum(place.astype(int), count - 1)
        part = place - k
        turn, slide = np.minimum(2.0 * part, 1.0), np.maximum(2.0 * part - 1.0, 0.0)
        phi = before[k] + turn * (angle[k] - before[k])
        core = corners[k] + slide[..., None] * along[k]
        turned = (1.0 - corner) * core + corner * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
        return (r + 0.0 * z)[..., None] * turned

    within = np.concatenate([0.5 * np.arange(arc_steps) / arc_steps, 0.5 + 0.5 * np.arange(side_steps) / side_steps])
    columns = ((np.arange(count)[:, None] + within) / count).ravel()
    return Form(xy, tuple(columns.tolist()), fold)


def rounding(form: Form, weight: Weight, heights: tuple[float, float], widening: float = 1.0) -> Form:
    """Return a form that turns into a circle of radius ``widening r`` as a weight over the height goes to 1."""

    def xy(u: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        unit = form.xy(u, np.ones_like(r), z)
        circle = widening * unit / np.linalg.norm(unit, axis=-1, keepdims=True)
        return (r * (1.0 - weight(z)))[..., None] * unit + (r * weight(z))[..., None] * circle

    return replace(form, xy=xy, heights=(*form.heights, heights))


def regular_corners(sides: int) -> np.ndarray:
    """Return a regular polygon whose sides are 1 away from the origin, (n, 2)."""
    return directions((np.arange(sides) + 0.5) / sides) / np.cos(np.pi / sides)


def rectangle_corners(ratio: float) -> np.ndarray:
    """Return a rectangle, 2 deep (y) and 2 x ratio wide (x), (4, 2)."""
    return np.array([[ratio, -1.0], [ratio, 1.0], [-ratio, 1.0], [-ratio, -1.0]])


def fluted(form: Form, count: int, rise: Callable[[np.ndarray], np.ndarray], depth: float, weight: Weight) -> Form:
    """Return a form with vertical waves: radii grow by ``depth r rise(phase)`` at phases of `count` waves around."""

    def xy(u: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        grown = r * (1.0 + depth * weight(z) * rise(2.0 * np.pi * count * u))
        return form.xy(u, grown, z)

    return replace(form, xy=xy, fold=count)


def flute(phase: np.ndarray) -> np.ndarray:
    """Return the rise of concave flutes with narrow ridges between them: 0 in their middle, 1 on the ridges."""
    sharp = 0.02  # how round ridges are
    return 1.0 - np.sqrt((np.cos(0.5 * phase) ** 2 + sharp) / (1.0 + sharp))


def ripple(phase: np.ndarray) -> np.ndarray:
    """Return the rise of even waves: 0 in the grooves, 1 on the ribs."""
    return 0.5 - 0.5 * np.cos(phase)


def stretched(form: Form, ratio: Callable[[np.ndarray], np.ndarray], heights: tuple[tuple[float, float], ...]) -> Form:
    """Return a form that is wider along x by a ratio that depends on the height [m]: ellipses from circles."""

    def xy(u: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        flat = form.xy(u, r, z)
        return np.stack([flat[..., 0] * ratio(z), flat[..., 1] + 0.0 * flat[..., 0]], axis=-1)

    return replace(form, xy=xy, fold=2 if form.fold % 2 == 0 else 1, heights=(*form.heights, *heights))


def lipped(form: Form, reach: float, width: float, low: float, high: float) -> Form:
    """Return a form with a pouring lip at +x that bends outwards over a range of heights.

    Parameters
    ----------
    form : Form
        Without it.
    reach : float
        How far the lip stands out [m].
    width : float
        Standard deviation of the lip, as an angle about z [rad].
    low, high : float
        Where the lip begins, and the rim [m].
    """

    def xy(u: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
        flat = form.xy(u, r, z)
        away = (np.mod(u + 0.5, 1.0) - 0.5) * 2.0 * np.pi / width
        t = np.clip((z - low) / (high - low), 0.0, None)
        # Beside the lip the rim is drawn in a little, as the hand that pulls the lip out does.
        bump = (1.0 - 0.15 * away**2) * np.exp(-0.5 * away**2)
        shift = reach * t**2 * bump
        return np.stack([flat[..., 0] + shift, flat[..., 1] + 0.0 * shift], axis=-1)

    return replace(form, xy=xy, fold=1, heights=(*form.heights, (low, high)))


def denser(form: Form, width: float, count: int) -> Form:
    """Return a form with `count` more columns within an angle of `width` [rad] on both sides of +x."""
    extra = np.mod(np.linspace(-width, width, count) / (2.0 * np.pi), 1.0)
    far = [u for u in form.columns if np.abs((u + 0.5) % 1.0 - 0.5) * 2.0 * np.pi > 1.02 * width]
    return replace(form, columns=tuple(np.unique(np.concatenate([far, extra])).tolist()))
