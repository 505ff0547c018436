"""From an outline and a shape to the glass of a vessel: its closed mesh and its cavity."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.mesh import Mesh
from ..cavities.known import KnownCavity
from ..vessels.outline import Outline
from .double_wall import double_walled
from .forms import Form
from .loft import HalfSection, Inside, Loft, Solid, cavity_solid, loft, lowest_edge
from .section import half_section, moved
from .shapes import Handle, Shape, handle_axes, handle_path
from .spouts import spout_solids
from .sweep import swept
from .unite import Bodies, united

#: Largest chord error over the wall's thickness [1]: of thin plastic the rows are finer.
FINE = 0.015
#: Part of the wall that a handle goes into [1], and how far beyond the inside its ends begin [m].
_EMBEDDED, _DEEP = 0.5, 0.004
#: Every so many columns and rows that solid has [1]: a third of the circle's are off by 0.15 mm, less than half a wall.
_COARSER = 3
#: How far the solid that keeps handles out of the inside goes on above the rim [m].
_ABOVE = 0.05


@dataclass(frozen=True)
class Glass:
    """How the glass of a vessel lies [m].

    Parameters
    ----------
    wall : float
        Smallest thickness across the wall.
    taper : float
        How much thicker it is at the bottom; it falls off quadratically.
    uneven : float
        How much thicker it is on one side, of the wall [1].
    side : float
        The place around of that side [turns].
    base, fillet, corner, punt, dome : float
        Thickness of the base; radii of the outer corner at the base and of the inner one at the floor; heights of the
        hollow under the base and of the floor's middle.
    """

    wall: float
    taper: float
    uneven: float
    side: float
    base: float
    fillet: float
    corner: float
    punt: float
    dome: float


@dataclass(frozen=True, eq=False)
class Outside:
    """The outside of a vessel's wall, for what is put on it: form and curve, in the frame before `matrix`.

    Parameters
    ----------
    form : Form
        Its cross-sections.
    section : HalfSection
        Its half section.
    matrix : (3, 3) float64
        The irregularity of the whole vessel.
    centre : (3,) float64
        The object frame's origin, after `matrix` [m].
    """

    form: Form
    section: HalfSection
    matrix: np.ndarray
    centre: np.ndarray


@dataclass(frozen=True, eq=False)
class ShapedGlass:
    """The glass of a vessel, its box about the origin."""

    mesh: Mesh
    cavity: KnownCavity
    wall: float  #: smallest thickness [m]
    outside: Outside
    fold: int  #: turns about z that leave it unchanged; 0 for all of them

    @property
    def brimful(self) -> float:
        """Volume up to the brim [m^3]."""
        return self.cavity.volume


def shaped_glass(
    outline: Outline, shape: Shape, glass: Glass, matrix: np.ndarray, chord_error: float, name: str
) -> ShapedGlass:
    """Return the glass of a vessel.

    Parameters
    ----------
    outline : Outline
        Its wall's outside, the base on z = 0.
    shape : Shape
        Cross-sections and what is joined to it.
    glass : Glass
        Thickness and roundings.
    matrix : (3, 3) float64
        Its irregularity (`section.irregularity`).
    chord_error : float
        Largest distance of the mesh from the true surface [m].
    name : str
        Of the mesh.

    Raises
    ------
    NoRoomError
        Where the wall leaves no room inside.
    """
    chord_error = min(chord_error, FINE * glass.wall)
    section = half_section(outline, glass.fillet, glass.punt, chord_error)
    # (The surfaces of two walls have the same columns: their chords make both walls thicker, not thinner.)
    inside = _inside(glass, outline.height, chord_error * (0.5 if shape.gap else 1.0), 1.0)
    if shape.gap:
        solid, brim = double_walled(section, shape.form, inside, shape.gap, chord_error)
    else:
        made = loft(section, shape.form, shape.measured, inside)
        solid, brim = _joined(made, section, shape, glass, outline, chord_error), made.brim
        if shape.spout is not None:
            brim = min(brim, lowest_edge(solid))
    solid = moved(solid, matrix)
    low, high = solid.vertices.min(0), solid.vertices.max(0)
    centre = 0.5 * (low + high)
    mesh = Mesh(name, solid.vertices - centre, solid.faces, solid.normals)
    cavity = KnownCavity(mesh, solid.inner, brim - float(centre[2]))
    fold = shape.form.fold if shape.handle is None and shape.spout is None else 1
    return ShapedGlass(mesh, cavity, glass.wall, Outside(shape.form, section, matrix, centre), fold)


def _inside(glass: Glass, height: float, chord_error: float, part: float) -> Inside:
    """Return the inside of a wall of a part of the thickness."""
    wall = glass.wall + 2.0 * chord_error

    def thickness(u: np.ndarray, z: np.ndarray) -> np.ndarray:
        uneven = 0.5 * glass.uneven * (1.0 + np.cos(2.0 * np.pi * (u - glass.side)))
        return part * (wall * (1.0 + uneven) + glass.taper * (1.0 - z / height) ** 2)

    return Inside(thickness, glass.punt + part * glass.base, glass.corner, part * glass.dome)


def _joined(
    made: Loft, section: HalfSection, shape: Shape, glass: Glass, outline: Outline, chord_error: float
) -> Solid:
    """Return the vessel with its handle and its spout."""
    if shape.handle is None:
        return made.solid
    half = loft(*_coarse(section, shape.measured), _inside(glass, outline.height, chord_error, _EMBEDDED))
    kept_out = cavity_solid(half, _ABOVE)
    added = [(_handle(shape.handle, outline, glass), kept_out)]
    bored = []
    if shape.spout is not None:
        tube, bore = spout_solids(shape.spout, outline)
        added.append((tube, kept_out))
        bored.append(bore)
    return united(Bodies(made.solid, tuple(added), tuple(bored)))


def _coarse(section: HalfSection, form: Form) -> tuple[HalfSection, Form, Form]:
    """Return a coarser section and form, for a surface in the middle of the wall that nobody sees."""
    rows = np.unique([*section.rows[::_COARSER], section.side, section.rows[-1]])
    fewer = replace(form, columns=form.columns[::_COARSER])
    return replace(section, rows=rows), fewer, fewer


def _handle(handle: Handle, outline: Outline, glass: Glass) -> Solid:
    def radius(z: float) -> float:
        return float(outline.derivative(np.array([z]), 0)[0])

    path = handle_path(handle, radius, glass.wall + glass.taper + _DEEP)
    return swept(path, *handle_axes(handle, len(path)))
