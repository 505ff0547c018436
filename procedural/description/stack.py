"""The liquids in a vessel without anything else: what each wets, and the surface of each, from the floor up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, joined, turned, volume_of
from ...core.units import volume_text
from ..cavities.cut import clear_level
from ..cavities.find import Hollow
from ..cavities.interior import Interior, filled, flat_level, most_volume
from ..cavities.polygon import triangulated
from ..cavities.split import Height, split_at
from ..optics.interfacial import LEAST_DIFFERENCE, mixes
from ..optics.medium import Medium
from ..profiles.curve import Curve, backwards, chained
from ..profiles.cuts import CONTACT_MERGE, cut_at
from ..profiles.liquid_surface import Surface, surface_of_volume
from ..profiles.revolve import revolved
from .bodies import MeshVessel, Vessel
from .mesh_vessel import contact_angle_at
from .refill import section_of

#: Least depth of a layer at the wall and on the axis [m]: less is a film, which real liquids break up into drops.
LEAST_LAYER = 1e-3
#: Factor that absorbs the rounding of sums of volumes.
ROUNDING = 1.0 + 1e-9


@dataclass(frozen=True)
class Pour:
    """A liquid and how much of it [m^3]."""

    medium: Medium
    volume: float


@dataclass(frozen=True, eq=False)
class Top:
    """The surface of a liquid.

    Parameters
    ----------
    mesh : Mesh
        From wall to wall, normals up.
    height : callable
        Height of points (n, 3) over it (n,) [m].
    normal : callable
        Its unit normals (n, 3) at places (n, 3).
    flatten : callable
        The surface laid out in a plane: places (n, 3) to (n, 2) [m].
    centre, contact : float
        Its height on the axis, and where it meets the wall [m].
    contact_angle : float
        Angle inside the liquid between the wall and it [rad].
    single : bool
        Whether there is one height of it above each place: bodies cannot reach through one that overhangs.
    """

    mesh: Mesh
    height: Height
    normal: Callable[[np.ndarray], np.ndarray]
    flatten: Callable[[np.ndarray], np.ndarray]
    centre: float
    contact: float
    contact_angle: float
    single: bool = True


@dataclass(frozen=True, eq=False)
class Stack:
    """Liquids in a vessel, from the floor up.

    Parameters
    ----------
    outside : Mesh
        What of the glass is in air.
    walls : tuple of Mesh
        What each liquid wets; normals out of the glass.
    tops : tuple of Top
        The surface of each.
    volumes : tuple of float
        Volume below each surface [m^3].
    """

    outside: Mesh
    walls: tuple[Mesh, ...]
    tops: tuple[Top, ...]
    volumes: tuple[float, ...]


#: From the volumes below each surface [m^3], from the floor up, to the stack.
Stacker = Callable[[Sequence[float]], Stack]


class ThinLayerError(ValueError):
    """A liquid that has no room of its own on the wall: its number, and the depth that it misses [m]."""

    def __init__(self, number: int, missing: float) -> None:
        super().__init__(f"liquid {number} has no wall of its own")
        self.number, self.missing = number, missing


def ordered(name: str, pours: Sequence[Pour]) -> tuple[Pour, ...]:
    """Return liquids as they come to lie on each other, the heaviest first.

    Raises
    ------
    InputError
        For liquids without a density, that mix, or whose densities hardly differ.
    """
    where = f"{name}, liquids"
    if len(pours) > 1:
        for pour in pours:
            if pour.medium.density is None:
                raise InputError(where, "a density of each", f"none of {pour.medium.name}")
    found = sorted(pours, key=lambda pour: -(pour.medium.density or 0.0))
    for lower, upper in pairwise(found):
        names = f"{lower.medium.name} and {upper.medium.name}"
        if lower.medium == upper.medium or mixes(lower.medium, upper.medium):
            raise InputError(where, "liquids that do not mix, such as water and olive oil", names)
        difference = (lower.medium.density or 0.0) - (upper.medium.density or 0.0)
        if difference < LEAST_DIFFERENCE:
            expected = f"densities that differ by at least {LEAST_DIFFERENCE:g} kg/m^3"
            raise InputError(where, expected, f"{difference:.3g} of {names}")
    return tuple(found)


def stacker_of_revolution(vessel: Vessel, media: Sequence[Medium]) -> Stacker:
    """Return what stacks liquids in a solid of revolution: the volumes below each surface [m^3] give the stack."""
    outer, inner, segments = section_of(vessel)
    chord_error = vessel.size[0] / 2.0 * (1.0 - np.cos(np.pi / segments))
    above = [*media[1:], None]

    def stacked(volumes: Sequence[float]) -> Stack:
        surfaces = [
            surface_of_volume(inner, volume, medium, chord_error, vessel.glass, upper)
            for volume, medium, upper in zip(volumes, media, above, strict=True)
        ]
        return _revolved(outer, inner, surfaces, segments)

    return stacked


def _revolved(outer: Curve, inner: Curve, surfaces: Sequence[Surface], segments: int) -> Stack:
    walls, dry = [], inner
    for surface in surfaces:
        if surface.contact <= float(dry.points[0, 1]) + CONTACT_MERGE:
            raise ThinLayerError(len(walls), LEAST_LAYER)
        wet, dry = cut_at(dry, surface.top.points[-1])
        walls.append(revolved(wet, segments, "wall"))
    outside = revolved(chained(outer, backwards(dry)), segments, "outside")
    tops = tuple(_top(surface, revolved(surface.top, segments, "top")) for surface in surfaces)
    return Stack(outside, tuple(walls), tops, tuple(surface.volume for surface in surfaces))


def _top(surface: Surface, mesh: Mesh) -> Top:
    (r, z), (sideways, up) = surface.top.points.T, surface.top.normals.T

    def height(points: np.ndarray) -> np.ndarray:
        return points[:, 2] - np.interp(np.hypot(points[:, 0], points[:, 1]), r, z)

    def normal(points: np.ndarray) -> np.ndarray:
        radius = np.hypot(points[:, 0], points[:, 1])
        outwards = points[:, :2] / np.maximum(radius, 1e-12)[:, None]
        found = np.column_stack([outwards * np.interp(radius, r, sideways)[:, None], np.interp(radius, r, up)])
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(r), np.diff(z)))])

    def flatten(points: np.ndarray) -> np.ndarray:
        radius = np.hypot(points[:, 0], points[:, 1])
        return points[:, :2] * (np.interp(radius, r, length) / np.maximum(radius, 1e-12))[:, None]

    single = bool((np.diff(r) > 0.0).all())
    return Top(mesh, height, normal, flatten, surface.centre, surface.contact, surface.contact_angle, single)


def stacker_of_mesh(vessel: MeshVessel, media: Sequence[Medium], inside: Interior) -> Stacker:
    """Return what stacks liquids with flat surfaces in a solid of any shape with one cavity, as it stands."""
    if len(inside.hollows) != 1:
        raise InputError(f"{vessel.name}, liquids", "a vessel with one cavity", f"one with {len(inside.hollows)}")

    def stacked(volumes: Sequence[float]) -> Stack:
        most = most_volume(inside)
        if volumes[-1] > most * ROUNDING:
            where, limit = f"{vessel.name}, liquids", f"at most {volume_text(most)} with what is in them"
            raise InputError(where, limit, volume_text(volumes[-1]))
        parts, fillings = filled(vessel.solid, inside, min(volumes[-1], most), ("outside", "wall", "top"))
        level = fillings[0].level
        walls, tops, wet = [], [], parts.wet_wall
        for volume in volumes[:-1]:
            low, wet, top = _layer(wet, inside.hollows[0], volume, len(walls))
            walls.append(low)
            tops.append(top)
        whole = [*tops, _flat(parts.liquid_surface, level, contact_angle_at(parts.wet_wall, level))]
        walls = (*walls, wet)
        below = [volume_of(joined([*map(turned, walls[: k + 1]), top.mesh], "liquid")) for k, top in enumerate(whole)]
        return Stack(parts.outside, walls, tuple(whole), tuple(below))

    return stacked


def _layer(wet: Mesh, hollow: Hollow, volume: float, number: int) -> tuple[Mesh, Mesh, Top]:
    """Return a wall below and above the level of a volume, and the surface there."""
    level = clear_level(wet.vertices[:, 2].astype(np.float64), flat_level(hollow, volume))
    halves = split_at(wet, lambda points: points[:, 2] - level)
    if halves.below is None or halves.above is None or not halves.rings:
        raise ThinLayerError(number, LEAST_LAYER)
    points = np.concatenate(halves.rings)
    ends = np.cumsum([0, *(len(ring) for ring in halves.rings)])
    loops = [np.arange(start, end) for start, end in pairwise(ends)]
    up = np.zeros_like(points)
    up[:, 2] = 1.0
    mesh = Mesh("top", points, triangulated(points[:, :2].astype(np.float64), loops), up)
    return halves.below, halves.above, _flat(mesh, level, contact_angle_at(halves.below, level))


def _flat(mesh: Mesh, level: float, angle: float) -> Top:
    def normal(points: np.ndarray) -> np.ndarray:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), points.shape)

    return Top(mesh, lambda points: points[:, 2] - level, normal, lambda points: points[:, :2], level, level, angle)


def check_layers(name: str, stack: Stack, media: Sequence[Medium], volumes: Sequence[float]) -> None:
    """Refuse layers so thin that one surface comes nearer than `LEAST_LAYER` to the next, with a volume that works."""
    for number, (lower, upper) in enumerate(pairwise(stack.tops)):
        depth = -upper.height(lower.mesh.vertices.astype(np.float64))
        depth = min(float(depth.min()), upper.contact - lower.contact)
        if depth < LEAST_LAYER:
            raise_thin(name, media[number + 1], volumes[number + 1], LEAST_LAYER - depth, _area(upper.mesh))


def raise_thin(name: str, medium: Medium, volume: float, missing: float, area: float) -> None:
    """Refuse a layer with about the least volume that is thick enough."""
    # A tenth more than what the missing depth takes, in whole millilitres.
    least = np.ceil(1e6 * (volume + 1.1 * missing * area)) * 1e-6
    limit = f"at least {volume_text(least)} of {medium.name}, a layer of {1e3 * LEAST_LAYER:g} mm"
    raise InputError(f"{name}, liquids", limit, volume_text(volume))


def _area(top: Mesh) -> float:
    x, y, _ = np.moveaxis(top.vertices.astype(np.float64)[top.faces], -1, 0)
    return 0.5 * float(((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])).sum())
