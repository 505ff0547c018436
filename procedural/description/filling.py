"""Fill a vessel: liquids that float on each other, and bodies in them, with every surface between two media.

What a body displaces counts: the volume of a liquid is that of its body, and its level is higher by what is in it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.units import volume_text
from ..cavities.interior import Interior, interior_of, most_volume
from ..cavities.pierce import pierced
from ..cavities.space import Space, space_of
from ..cavities.split import split_at, volume_below
from ..optics.medium import AIR, Medium
from ..optics.turbid import is_turbid
from ..profiles.clearance import clearance
from ..profiles.liquid import brimful_volume, level_of_volume
from ..profiles.liquid import volume_below as below_level
from ..profiles.liquid_surface import most_volume as most_of_revolution
from .bodies import Content, Interface, Liquid, MeshVessel, Vessel
from .floating import GAP, Floater, draught_of, equilibrium, lying_rise, raised
from .interfaces import clouded, dry_interfaces, wetted
from .mesh_vessel import dry_interfaces_of
from .refill import section_of
from .stack import (
    Pour,
    Stack,
    Stacker,
    ThinLayerError,
    Top,
    check_layers,
    ordered,
    raise_thin,
    stacker_of_mesh,
    stacker_of_revolution,
)

#: Largest relative error of a liquid's volume at which the search for the levels ends, and most rounds of it [1]; each
#: leaves what bodies displace between the last two levels, a few per cent of the error before.
VOLUME_ERROR, MOST_ROUNDS = 2e-4, 8
#: How much bodies may be in the glass and still count as touching it [m], as on the table.
ALLOWANCE = 5e-4


@dataclass(frozen=True, eq=False)
class Body:
    """A body in a vessel: its closed surface in the vessel's frame, and what a vessel's record says of it.

    Bodies that stand in a vessel and are objects of their own have no record.
    """

    mesh: Mesh
    record: Content | None = None

    @property
    def density(self) -> float | None:
        """Its density where it floats [kg/m^3]; None for what stays where it is."""
        return self.record.medium.density if self.record is not None and self.record.kind == "ice cube" else None


@dataclass(frozen=True, eq=False)
class Filled:
    """A vessel with liquids and bodies in it.

    Parameters
    ----------
    vessel : Vessel or MeshVessel
        With its interfaces.
    standing : tuple
        Of each body without a record: the pieces of its surface, each with the medium before it.
    """

    vessel: Vessel | MeshVessel
    standing: tuple[tuple[tuple[Medium, Mesh], ...], ...]


def fill_vessel(
    vessel: Vessel | MeshVessel, pours: Sequence[Pour], bodies: Sequence[Body] = (), inside: Interior | None = None
) -> Filled:
    """Return a vessel with liquids and bodies in it; what it held before is gone.

    Parameters
    ----------
    vessel : Vessel or MeshVessel
        It stands upright: z is up.
    pours : sequence of Pour
        Liquids in any order; the heaviest comes to lie on the floor. None leaves bodies in air.
    bodies : sequence of Body
        Closed, apart from the glass and from each other. Ice rises or falls to where it floats or lies on the floor;
        all others stay where they are.
    inside : Interior, optional
        Cavities of a `MeshVessel`, where they are known.

    Raises
    ------
    InputError
        For liquids that mix or cannot float on each other (`stack.ordered`), that do not fit in below the rim with what
        is in them, or of which a layer is too thin; for bodies where a liquid's surface overhangs, and ice that has no
        room where it floats.
    """
    empty = vessel.model_copy(update={"liquid": None, "layers": (), "contents": ()})
    pours = ordered(vessel.name, pours)
    media = [pour.medium for pour in pours]
    if isinstance(vessel, MeshVessel):
        inside = inside or interior_of(vessel.solid)
    room = _room(vessel, inside)
    floaters = [_floater(vessel, body) for body in bodies]
    if not pours:
        _, rises = equilibrium(room.capacity, room.limits, (), floaters, ())
        placed = _placed(vessel, bodies, rises)
        return _with_bodies(empty, None, (), placed)
    if isinstance(vessel, MeshVessel):
        assert inside is not None
        stacker = stacker_of_mesh(vessel, media, inside)
    else:
        stacker = stacker_of_revolution(vessel, media)
    stack, placed = _settled(vessel, stacker, pours, bodies, floaters, room)
    check_layers(vessel.name, stack, media, [pour.volume for pour in pours])
    return _with_bodies(empty, stack, pours, placed)


def most_liquid(vessel: Vessel | MeshVessel, medium: Medium, inside: Interior | None = None) -> tuple[float, float]:
    """Return the volume up to the brim, and the most that liquids and bodies take below their surface [m^3]."""
    if isinstance(vessel, MeshVessel):
        inside = inside or interior_of(vessel.solid)
        return inside.volume, most_volume(inside)
    inner = section_of(vessel)[1]
    return brimful_volume(inner.points), most_of_revolution(inner, medium, vessel.glass)


@dataclass(frozen=True, eq=False)
class _Room:
    """The cavity of a vessel under flat levels."""

    capacity: Callable[[float], float]  #: volume below a level [m^3]
    limits: tuple[float, float]  #: floor and brim [m]


def _room(vessel: Vessel | MeshVessel, inside: Interior | None) -> _Room:
    if isinstance(vessel, Vessel):
        inner = np.array(vessel.inner)
        return _Room(lambda level: below_level(inner, level), (float(inner[0, 1]), float(inner[-1, 1])))
    assert inside is not None
    if not inside.hollows:
        raise InputError(f"{vessel.name}, liquids", "a vessel with a cavity", "none")
    hollow = inside.hollows[0]
    return _Room(hollow.volume_below, (hollow.floor, hollow.brim))


def _floater(vessel: Vessel | MeshVessel, body: Body) -> Floater:
    draught = draught_of(body.mesh, body.density is not None)
    if body.density is None:
        return Floater(draught)
    if isinstance(vessel, Vessel):
        return Floater(draught, body.density, lying_rise(body.mesh, np.array(vessel.inner)))
    return Floater(draught, body.density, _lying_rise(body.mesh, _space(vessel)))


def _space(vessel: MeshVessel) -> Space:
    found = space_of(vessel.solid)
    if found is None:
        raise InputError(f"{vessel.name}, contents", "a vessel with a cavity", "none")
    return found


def _lying_rise(mesh: Mesh, space: Space) -> float:
    """Return by how much a body has to rise to lie on the floor of a cavity, `GAP` above it [m]."""
    points = mesh.vertices.astype(np.float64)
    rise = space.bottom_at(points[:, :2]) - points[:, 2]
    # Within the distance of two lines of the wall the bottom is not known there: what lies there is over a corner.
    rise = rise[np.isfinite(rise)]
    return float(rise.max() if len(rise) else space.floor - points[:, 2].min()) + GAP


def _settled(
    vessel: Vessel | MeshVessel,
    stacker: Stacker,
    pours: Sequence[Pour],
    bodies: Sequence[Body],
    floaters: Sequence[Floater],
    room: _Room,
) -> tuple[Stack, list[Body]]:
    """Return the stack in which each liquid has its volume, whatever bodies displace, and the bodies in it."""
    wanted = np.cumsum([pour.volume for pour in pours])
    if not bodies:
        return _stacked(vessel, stacker, pours, wanted), []
    liquids = [(pour.medium.density or 0.0, float(total)) for pour, total in zip(pours, wanted, strict=True)]
    offsets = [0.0] * len(pours)

    def afloat() -> tuple[list[float], list[float], np.ndarray]:
        levels, rises = equilibrium(room.capacity, room.limits, liquids, floaters, offsets)
        displaced = [
            sum(one.draught.below(level + up - rise) for one, rise in zip(floaters, rises, strict=True))
            for level, up in zip(levels, offsets, strict=True)
        ]
        return levels, rises, wanted + np.array(displaced)

    # First with flat levels, then with those of the true surfaces.
    levels, rises, targets = afloat()
    stack = _stacked(vessel, stacker, pours, targets)
    offsets = [top.centre - level for top, level in zip(stack.tops, levels, strict=True)]
    levels, rises, targets = afloat()
    stack = _stacked(vessel, stacker, pours, targets)
    placed = _placed(vessel, bodies, rises)
    for _ in range(MOST_ROUNDS):
        missing = wanted - _volumes_below(stack, placed)
        if (np.abs(missing) <= VOLUME_ERROR * wanted).all():
            break
        targets = targets + missing
        stack = _stacked(vessel, stacker, pours, targets)
    return stack, placed


def _volumes_below(stack: Stack, bodies: Sequence[Body]) -> np.ndarray:
    """Return the volume of liquid below each surface, without what bodies displace [m^3]."""
    displaced = [sum(volume_below(body.mesh, top.height) for body in bodies) for top in stack.tops]
    return np.array(stack.volumes) - np.array(displaced)


def _placed(vessel: Vessel | MeshVessel, bodies: Sequence[Body], rises: Sequence[float]) -> list[Body]:
    """Return bodies where they float or lie.

    Raises
    ------
    InputError
        Where one of them is in the glass there.
    """
    placed = []
    for body, rise in zip(bodies, rises, strict=True):
        if body.density is None or body.record is None:
            placed.append(body)
            continue
        x, y, z = body.record.centre
        moved = Body(raised(body.mesh, rise), body.record.model_copy(update={"centre": (x, y, z + rise)}))
        depth = -float(_clearance(vessel, moved.mesh.vertices.astype(np.float64)).min())
        if depth > ALLOWANCE:
            where, expected = f"{vessel.name}, contents", f"room for its {body.record.kind} at this level"
            raise InputError(where, expected, f"{1e3 * depth:.1f} mm of it in the glass")
        placed.append(moved)
    return placed


def _clearance(vessel: Vessel | MeshVessel, points: np.ndarray) -> np.ndarray:
    if isinstance(vessel, Vessel):
        return clearance(np.array(vessel.outer), np.array(vessel.inner), points)
    return _space(vessel).clearance(points)


def _stacked(vessel: Vessel | MeshVessel, stacker: Stacker, pours: Sequence[Pour], targets: np.ndarray) -> Stack:
    try:
        return stacker(targets.tolist())
    except ThinLayerError as error:
        pour = pours[max(error.number, 0)]
        area = np.pi * (0.5 * max(vessel.size[:2])) ** 2
        raise_thin(vessel.name, pour.medium, pour.volume, error.missing, area)
        raise
    except InputError as error:
        if not str(error).startswith("liquid.volume"):
            raise
        total, medium = float(targets[-1]), pours[-1].medium
        most = most_liquid(vessel, medium)[1]
        limit = f"at most {volume_text(most)} of liquids and what is in them (below the rim)"
        raise InputError(f"{vessel.name}, liquids", limit, volume_text(total)) from error


def _with_bodies(
    vessel: Vessel | MeshVessel, stack: Stack | None, pours: Sequence[Pour], bodies: Sequence[Body]
) -> Filled:
    name = _prefix(vessel)
    tops = () if stack is None else stack.tops
    media = [pour.medium for pour in pours]
    holes: list[list[np.ndarray]] = [[] for _ in tops]
    interfaces: list[Interface] = []
    records, standing = [], []
    for body in bodies:
        pieces = _pieces(vessel.name, body.mesh, tops, media, holes)
        if body.record is None:
            standing.append(tuple(pieces))
            continue
        number = len(records)
        records.append(body.record)
        for k, (medium, mesh) in enumerate(pieces):
            mesh = replace(mesh, name=f"{name}-content-{number}-{k}")
            back = body.record.medium
            interfaces.append(Interface(part="content", mesh=mesh, front=medium, back=back, content=number))
    if stack is None:
        changes = {"interfaces": (*_dry(vessel, name), *interfaces), "contents": tuple(records)}
        return Filled(vessel.model_copy(update=changes), tuple(standing))
    made = [pierced(top.mesh, rings, top.normal, top.flatten) for top, rings in zip(tops, holes, strict=True)]
    outside = Interface(
        part="outside",
        mesh=replace(stack.outside, name=f"{name}-outside"),
        front=AIR,
        back=vessel.glass,
        roughness=vessel.roughness,
    )
    wet = wetted(stack.walls, made, media, glass=vessel.glass, roughness=vessel.roughness, name=name)
    held = _records(vessel, stack, pours, bodies)
    changes = {
        "interfaces": (outside, *wet, *(clouded(part) for part in interfaces)),
        "liquid": held[0],
        "layers": tuple(held[1:]),
        "contents": tuple(records),
    }
    return Filled(vessel.model_copy(update=changes), tuple(standing))


def _pieces(
    name: str, mesh: Mesh, tops: Sequence[Top], media: Sequence[Medium], holes: list[list[np.ndarray]]
) -> list[tuple[Medium, Mesh]]:
    """Return the pieces of a body's surface by the medium before each, and add the holes that it makes in surfaces."""
    pieces, rest = [], mesh
    for number, (top, medium) in enumerate(zip(tops, media, strict=True)):
        halves = split_at(rest, top.height)
        if halves.rings and not top.single:
            raise InputError(f"{name}, contents", "bodies away from a surface that overhangs", mesh.name)
        holes[number] += halves.rings
        if halves.below is not None:
            pieces.append((medium, halves.below))
        if halves.above is None:
            return pieces
        rest = halves.above
    return [*pieces, (AIR, rest)]


def _records(vessel: Vessel | MeshVessel, stack: Stack, pours: Sequence[Pour], bodies: Sequence[Body]) -> list[Liquid]:
    volumes = [pour.volume for pour in pours]
    if isinstance(vessel, MeshVessel):
        brimful, levels = sum(cavity.volume for cavity in vessel.cavities), [top.contact for top in stack.tops]
        # Levels keep away from vertices (`cavities.cut.clear_level`): of a thin layer that is a percent of its volume.
        volumes = np.diff(_volumes_below(stack, bodies), prepend=0.0).tolist()
    else:
        inner = np.array(vessel.inner)
        brimful, levels = brimful_volume(inner), [level_of_volume(inner, volume) for volume in stack.volumes]
    return [
        Liquid(
            medium=pour.medium,
            level=level,
            centre=top.centre,
            contact=top.contact,
            contact_angle=top.contact_angle,
            fill=min(volume / brimful, 1.0),
            volume=volume,
            turbid=is_turbid(pour.medium),
        )
        for pour, volume, top, level in zip(pours, volumes, stack.tops, levels, strict=True)
    ]


def _dry(vessel: Vessel | MeshVessel, name: str) -> tuple[Interface, ...]:
    if isinstance(vessel, MeshVessel):
        return dry_interfaces_of(vessel.solid, vessel.glass, vessel.roughness)
    outer, inner, segments = section_of(vessel)
    return dry_interfaces(outer, inner, glass=vessel.glass, roughness=vessel.roughness, segments=segments, name=name)


def _prefix(vessel: Vessel | MeshVessel) -> str:
    """Return the prefix of the names of a vessel's meshes."""
    outside = next(part.mesh for part in vessel.interfaces if part.part == "outside")
    return outside.name.removesuffix("-outside")
