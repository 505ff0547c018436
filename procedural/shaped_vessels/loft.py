"""From half a section and its cross-sections to the closed surface of a glass solid with an inside.

The outside is the half section's curve, mapped by a form at each place around. The inside keeps the wall's thickness
along the normal of the surface that the glass is measured from, so that the thickness holds across the wall wherever
its curvature radius is larger. A ball that rolls around between floor and wall rounds the inside's corner.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..profiles.curve import Curve
from ..vessels.rolling import NoRoomError
from .forms import Form

#: Step of the central differences of a form, in fractions of a turn [1] and in lengths [m]: errors are below 1e-8.
_STEP_U, _STEP = 1e-6, 1e-6
#: Points along the side in search of the place where floor and wall meet [1], and those of the arc between them, of
#: half the rim, and of the floor.
_SEARCH, _ARC, _RIM, _FLOOR = 160, 7, 6, (0.35, 0.7)
#: Longest rows where a cross-section changes [m].
_ROW = 2.5e-3

#: (u, z) to the thickness there [m].
Thickness = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class HalfSection:
    """The outside of half a section.

    Parameters
    ----------
    curve : Curve
        Dense, from the axis at the base to where the rim begins, normals out of the glass.
    side : int
        The point of the curve where the wall begins, above the base's corner.
    rows : (m,) int
        Points of the curve that the mesh has, both ends included.
    """

    curve: Curve
    side: int
    rows: np.ndarray


@dataclass(frozen=True, eq=False)
class Inside:
    """How the glass lies inside its outside.

    Parameters
    ----------
    thickness : callable
        Across the wall.
    floor : float
        Height of the floor [m].
    corner : float
        Radius of the corner between floor and wall [m].
    dome : float
        How much higher the floor's middle is [m].
    """

    thickness: Thickness
    floor: float
    corner: float
    dome: float = 0.0


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface.

    Parameters
    ----------
    vertices, normals : (n, 3) float64
        Positions [m], and unit normals out of the solid.
    faces : (m, 3) int64
        Counter-clockwise seen from outside.
    inner : (m,) bool
        Which faces are around the cavity.
    """

    vertices: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    inner: np.ndarray


@dataclass(frozen=True, eq=False)
class Loft:
    """A lofted vessel: its solid, and its outside for what is put on it."""

    solid: Solid
    brim: float  #: height of the lowest place of the rim's crest [m]


def surface(form: Form, curve: Curve, u: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and unit normals of the surface that a form makes of a curve.

    Parameters
    ----------
    form : Form
        The cross-sections.
    curve : Curve
        Dense; its points are numbered.
    u, s : (n, m) float
        Place around, and (broken) number of the curve's point.

    Returns
    -------
    (n, m, 3), (n, m, 3) float64
    """
    u, s = np.broadcast_arrays(u, s)
    number = np.arange(len(curve.points))
    r, z = (np.interp(s, number, column) for column in curve.points.T)
    nr, nz = (np.interp(s, number, column) for column in curve.normals.T)
    length = np.hypot(nr, nz)
    along_r, along_z = -nz / length, nr / length
    flat = form.xy(u, r, z)
    by_u = (form.xy(u + _STEP_U, r, z) - form.xy(u - _STEP_U, r, z)) / (2.0 * _STEP_U)
    by_r = (form.xy(u, r + _STEP, z) - form.xy(u, r - _STEP, z)) / (2.0 * _STEP)
    by_z = (form.xy(u, r, z + _STEP) - form.xy(u, r, z - _STEP)) / (2.0 * _STEP)
    around = np.concatenate([by_u, np.zeros_like(r)[..., None]], axis=-1)
    upward = np.concatenate([by_r * along_r[..., None] + by_z * along_z[..., None], along_z[..., None]], axis=-1)
    normal = np.cross(around, upward)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    on_axis = size[..., 0] <= 1e-12
    normal = np.where(on_axis[..., None], np.stack([0 * r, 0 * r, np.sign(nz)], -1), normal / np.maximum(size, 1e-30))
    return np.concatenate([flat, z[..., None]], axis=-1), normal


def loft(outside: HalfSection, form: Form, measured: Form, inside: Inside) -> Loft:
    """Return the glass between the outside that a form gives to a half section, and an inside.

    Parameters
    ----------
    outside : HalfSection
        The outside.
    form : Form
        Its cross-sections.
    measured : Form
        Cross-sections of the surface that the thickness is measured from: `form`, or one that lies within it and
        touches it, as a circle does a polygon.
    inside : Inside
        Thickness and floor.

    Raises
    ------
    NoRoomError
        Where the wall leaves no room inside.
    """
    u = np.array(form.columns)[:, None]
    rows = _rows(outside, form)
    out, out_normals = surface(form, outside.curve, u, rows[None])
    # A column of the outside at an angle is one of the measured surface at the same angle.
    place = _places(measured, form, u)
    wall, wall_normals, floor_ring = _inner_side(outside, measured, place, rows[rows >= outside.side], inside)
    rim, rim_normals = _rim(out[:, -1], out_normals[:, -1], wall[:, 0], wall_normals[:, 0])
    floor, floor_normals, pole = _floor(floor_ring, inside)
    grid = np.concatenate([out[:, 1:], rim, wall, floor], axis=1)
    normals = np.concatenate([out_normals[:, 1:], rim_normals, wall_normals, floor_normals], axis=1)
    bottom = np.array([0.0, 0.0, outside.curve.points[0, 1]])
    first_inner = out.shape[1] - 1 + rim.shape[1] // 2
    solid = _closed(grid, normals, (bottom, pole), first_inner)
    return Loft(solid, float(rim[..., 2].max(1).min()))


def _rows(outside: HalfSection, form: Form) -> np.ndarray:
    """Return the points of the curve that the mesh has, with more where the cross-section changes."""
    rows = [outside.rows.astype(np.float64)]
    heights = outside.curve.points[outside.side :, 1]
    for low, high in form.heights:
        wanted = np.linspace(low, high, max(2, int(np.ceil((high - low) / _ROW)) + 1))
        wanted = wanted[(wanted > heights[0] + 1e-4) & (wanted < heights[-1] - 1e-4)]
        rows.append(outside.side + np.interp(wanted, heights, np.arange(len(heights))))
    every = np.unique(np.concatenate(rows))
    # Rows that nearly coincide make needles.
    kept = np.concatenate([[True], np.diff(every) > 1.0])
    kept[np.searchsorted(every, outside.rows)] = True
    return every[kept]


def _places(measured: Form, form: Form, u: np.ndarray) -> np.ndarray:
    if measured.xy is form.xy:
        return u
    flat = form.xy(u, np.ones_like(u), np.zeros_like(u))
    return np.mod(np.arctan2(flat[..., 1], flat[..., 0]) / (2.0 * np.pi), 1.0)


def _inner_side(
    outside: HalfSection, measured: Form, u: np.ndarray, rows: np.ndarray, inside: Inside
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the inner wall from the rim down with the corner at the floor, its normals, and the floor's ring."""
    last = float(rows[-1])
    search = np.linspace(outside.side, last, _SEARCH)[None]
    points, normals = surface(measured, outside.curve, u, search)
    reach = inside.thickness(u + 0.0 * search, points[..., 2]) + inside.corner
    centres = points[..., 2] - reach * normals[..., 2]
    above = centres >= inside.floor + inside.corner
    if not above[:, -1].all():
        raise NoRoomError(f"the wall leaves no room above the floor at {inside.floor:.4f} m")
    # The last place, from the top, where the ball's centre is above the floor by its radius.
    first = above.shape[1] - np.argmin(above[:, ::-1], axis=1)
    first = np.where(above.all(1), 0, first)
    index = np.arange(len(first))
    below = np.maximum(first - 1, 0)
    low, high = centres[index, below], centres[index, np.minimum(first, _SEARCH - 1)]
    part = np.where(first > 0, (inside.floor + inside.corner - low) / np.maximum(high - low, 1e-12), 0.0)
    start = search[0, below] + np.clip(part, 0.0, 1.0) * (search[0, 1] - search[0, 0]) * (first > 0)
    # Above all corners the inside has the rows of the outside, which are fine where it bends.
    knee = min(int(np.searchsorted(rows, start.max() + 1.0)), len(rows) - 1)
    fraction = np.minimum((rows - rows[0]) / (rows[knee] - rows[0]), 1.0)
    lower = start[:, None] + fraction[None] * (rows[knee] - start[:, None])
    s = np.where(np.arange(len(rows)) < knee, lower, rows)
    points, normals = surface(measured, outside.curve, u, s)
    thickness = inside.thickness(u + 0.0 * s, points[..., 2])
    wall = points - thickness[..., None] * normals
    arc, arc_normals = _corner(points[:, 0], normals[:, 0], thickness[:, 0], inside)
    side = np.concatenate([arc[:, :-1], wall], axis=1)[:, ::-1]
    facing = -np.concatenate([arc_normals[:, :-1], normals], axis=1)[:, ::-1]
    _check_unfolded(side)
    return side, facing, arc[:, 0]


def _corner(
    points: np.ndarray, normals: np.ndarray, thickness: np.ndarray, inside: Inside
) -> tuple[np.ndarray, np.ndarray]:
    """Return the arcs from the floor to the wall and their outward directions, (n, k, 3) each."""
    centre = points - (thickness + inside.corner)[:, None] * normals
    cosine = np.clip(-normals[:, 2], -1.0, 1.0)
    angle = np.arccos(cosine)[:, None]  # between down and the wall's normal
    t = np.linspace(0.0, 1.0, _ARC + 1)[None]
    sine = np.sin(angle)
    down, to_wall = np.sin((1.0 - t) * angle) / sine, np.sin(t * angle) / sine
    direction = to_wall[..., None] * normals[:, None]
    direction[..., 2] -= down
    arc = centre[:, None] + inside.corner * direction
    arc[:, 0, 2] = inside.floor
    return arc, direction


def _rim(
    start: np.ndarray, start_normal: np.ndarray, end: np.ndarray, end_normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half circles over the wall's two edges, without their ends, and their normals."""
    centre, half = 0.5 * (start + end), 0.5 * (start - end)
    radius = np.linalg.norm(half, axis=1, keepdims=True)
    across = half / radius
    up = np.array([0.0, 0.0, 1.0]) - across[:, 2:] * across
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    beta = (np.pi * np.arange(1, 2 * _RIM) / (2 * _RIM))[None, :, None]
    normals = np.cos(beta) * across[:, None] + np.sin(beta) * up[:, None]
    return centre[:, None] + radius[:, None] * normals, normals


def _floor(ring: np.ndarray, inside: Inside) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rows of the floor inside its ring, their normals, and the pole."""
    middle = np.array([*ring[:, :2].mean(0), inside.floor])
    fractions = np.array(_FLOOR)[::-1]
    rise = 0.5 * inside.dome * (1.0 + np.cos(np.pi * fractions))
    slope = 0.5 * inside.dome * np.pi * np.sin(np.pi * fractions)  # over the ring's distance
    flat = ring - middle
    rows = middle + fractions[None, :, None] * flat[:, None]
    rows[..., 2] += rise
    distance = np.linalg.norm(flat[:, :2], axis=1)[:, None, None]
    normals = np.zeros_like(rows)
    normals[..., 2] = 1.0
    normals[..., :2] = slope[None, :, None] * flat[:, None, :2] / distance**2
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return rows, normals, middle + [0.0, 0.0, inside.dome]


def _check_unfolded(side: np.ndarray) -> None:
    """Refuse an inside that crosses itself: its columns or its rows come back."""
    along = np.diff(side, axis=1)
    around = np.roll(side, -1, axis=0) - side
    # From the rim down, counter-clockwise: rows turn the same way as a circle's.
    turn = side[:, :, 0] * around[..., 1] - side[:, :, 1] * around[..., 0]
    if (turn < -1e-12).any() or (np.linalg.norm(along, axis=-1).max(1) <= 0.0).any():
        raise NoRoomError("the wall leaves no room inside: the inside crosses itself")
    back = (along[:, 1:] * along[:, :-1]).sum(-1)
    if (back < -1e-10).any():
        raise NoRoomError("the wall leaves no room inside: the inside crosses itself")


def _closed(grid: np.ndarray, normals: np.ndarray, poles: tuple[np.ndarray, np.ndarray], first_inner: int) -> Solid:
    """Return the closed surface of a grid (columns, rows, 3) between two poles."""
    columns, rows = grid.shape[:2]
    number = 1 + np.arange(columns * rows).reshape(rows, columns)  # row by row
    here, after = number, np.roll(number, -1, axis=1)
    a, b, c, d = here[:-1], after[:-1], after[1:], here[1:]
    bands = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(rows - 1, -1, 3)
    last = columns * rows + 1
    first_fan = np.stack([np.zeros(columns, int), after[0], here[0]], -1)
    last_fan = np.stack([np.full(columns, last), here[-1], after[-1]], -1)
    faces = np.concatenate([first_fan, bands.reshape(-1, 3), last_fan])
    band = np.concatenate([np.full(columns, -1), np.repeat(np.arange(rows - 1), 2 * columns), np.full(columns, rows)])
    vertices = np.concatenate([poles[0][None], grid.transpose(1, 0, 2).reshape(-1, 3), poles[1][None]])
    down, up = np.array([[0.0, 0.0, -1.0]]), np.array([[0.0, 0.0, 1.0]])
    facing = np.concatenate([down, normals.transpose(1, 0, 2).reshape(-1, 3), up])
    return Solid(vertices, facing, faces.astype(np.int64), band >= first_inner)


def cavity_solid(made: Loft, above: float) -> Solid:
    """Return the solid that fills the inside of a lofted vessel and goes on above its rim [m]."""
    solid = made.solid
    border = _border(solid)
    count, number = len(solid.vertices), len(border)
    lifted = solid.vertices[border] + [0.0, 0.0, above]
    top = np.append(lifted[:, :2].mean(0), lifted[:, 2].max())
    high, after = count + np.arange(number), count + np.roll(np.arange(number), -1)
    following = np.roll(border, -1)
    # The border's edges are passed from start to end by the inside's faces, so what joins them goes back.
    wall = np.concatenate([np.stack([following, border, high], 1), np.stack([following, high, after], 1)])
    lid = np.stack([after, high, np.full(number, count + number)], 1)
    faces = np.concatenate([solid.faces[solid.inner], wall, lid])[:, ::-1]
    vertices = np.concatenate([solid.vertices, lifted, top[None]])
    used, index = np.unique(faces, return_inverse=True)
    normals = np.tile([0.0, 0.0, 1.0], (len(used), 1))
    return Solid(vertices[used], normals, index.reshape(-1, 3), np.zeros(len(faces), bool))


def _border(solid: Solid) -> np.ndarray:
    """Return the vertices of the line around the faces of a lofted cavity, in its direction."""
    ring = dict(_border_edges(solid.faces[solid.inner]).tolist())
    order = [next(iter(ring))]
    while ring[order[-1]] != order[0]:
        order.append(ring[order[-1]])
    return np.array(order)


def _border_edges(faces: np.ndarray) -> np.ndarray:
    """Return the edges that one of the faces has, and no other one back, (k, 2)."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(faces.max()) + 1
    alone = ~np.isin(start * count + end, end * count + start)
    return np.stack([start[alone], end[alone]], axis=1)


def lowest_edge(solid: Solid) -> float:
    """Return the height of the lowest place where the faces around the cavity end [m]: over it, liquid flows out."""
    _, place = np.unique(solid.vertices, axis=0, return_inverse=True)
    positions = place.reshape(-1)
    heights = np.zeros(positions.max() + 1)
    heights[positions] = solid.vertices[:, 2]
    return float(heights[_border_edges(positions[solid.faces[solid.inner]])].min())
