"""Draw what is in a vessel: liquids in layers, turbid ones, ice, beads, bubbles, and what leans in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, volume_of
from ...core.weighted import weights_of
from ..description.bodies import Content, GlassBody, MeshVessel, Prop, SceneObject, Vessel
from ..description.filling import Body, fill_vessel
from ..description.pouring import held
from ..description.stack import Pour
from ..description.standing import restood
from ..optics.catalogue import ice, olive_oil, soda_lime
from ..optics.interfacial import kind_of
from ..optics.medium import AIR, Medium
from ..optics.turbid import is_turbid, turbid_medium
from ..profiles.clearance import along_edges
from .fits import bead_places, bubble_places, ice_places
from .room import Room, room_of
from .settings import ContentsSettings
from .shapes import BUBBLE_STEPS, balls, rounded_box
from .standing import draw_standing

#: How often what does not fit is drawn again [1].
TRIES = 12
#: Rounding of an ice cube's edges, and heights of the waves on its faces, over its edge [1]: ice from a tray that has
#: begun to melt.
_ROUNDING, _WAVES = (0.12, 0.25), (0.0, 0.012)
#: Number of waves [1], and range of their lengths over the edge [1].
_WAVE_COUNT, _WAVELENGTHS = 6, (0.7, 2.0)

#: From a kind of content to its own stream of the vessel.
Streams = Callable[[str], np.random.Generator]


@dataclass(frozen=True, eq=False)
class Drawn:
    """A vessel with its contents, and the objects that lean in it, posed as if the vessel's frame were the world's."""

    vessel: GlassBody
    standing: tuple[SceneObject, ...] = ()


@dataclass(eq=False)
class _Tries:
    """How often something was drawn again."""

    count: int = 0


def draw_contents(
    streams: Streams,
    settings: ContentsSettings,
    vessel: GlassBody,
    *,
    may_stand: bool,
    chosen: bool = False,
) -> Drawn:
    """Draw what is in a vessel that has been drawn with one liquid or none.

    Parameters
    ----------
    streams : callable
        Streams of the vessel, by what they are for.
    settings : ContentsSettings
        Probabilities and ranges.
    vessel : GlassBody
        At the origin of its own frame. Of a vessel from a file only the liquids change.
    may_stand : bool
        Whether something may lean in it.
    chosen : bool
        Whether the user has chosen the liquids: they are then replaced or covered only where that is asked for.

    Raises
    ------
    InputError
        Where something with a probability of 1 does not fit.
    """
    if not isinstance(vessel, Vessel | MeshVessel):
        return Drawn(vessel)
    tries = _Tries()
    pours = _liquids(streams, settings, vessel, tries, chosen)
    # Of vessels from files too little is known: what is their inside may be a handle's hole.
    room = room_of(vessel) if vessel.origin is None else None
    if room is None:
        changed = vessel if pours == held(vessel) else _filled(vessel, pours)
        return Drawn(_counted(changed, tries))

    def takes(*bodies: Body) -> bool:
        return not pours or _filled_with(vessel, pours, bodies) is not None

    item, again = None, 0
    if may_stand:
        item, again = draw_standing(
            streams("standing"), settings, vessel, room, lambda found: takes(Body(_in_vessel(found)))
        )
        tries.count += again
    leaning = [] if item is None else [_in_vessel(item)]
    others = [Body(mesh) for mesh in leaning]
    bodies = _beads(streams("beads"), settings, vessel, room, leaning, tries)
    if bodies and not takes(*bodies, *others):
        bodies = _left_out(vessel, "beads", settings.beads, tries)
    bodies += _ice(streams("ice"), settings, vessel, room, pours, bodies, others, tries)
    if pours == held(vessel) and not bodies and not leaning and settings.bubbles == 0.0:
        return Drawn(_counted(vessel, tries))
    bubbles = _bubbles(streams("bubbles"), settings, vessel, room, pours, bodies, leaning, tries)
    if bubbles and not takes(*bodies, *bubbles, *others):
        bubbles = _left_out(vessel, "bubbles", settings.bubbles, tries)
    if pours == held(vessel) and not bodies and not leaning and not bubbles:
        return Drawn(_counted(vessel, tries))
    filled = fill_vessel(vessel, pours, [*bodies, *bubbles, *others])
    standing = () if item is None else (restood(item, filled.standing[0], np.eye(4)),)
    return Drawn(_counted(filled.vessel, tries), standing)


def _filled_with(
    vessel: Vessel | MeshVessel, pours: tuple[Pour, ...], bodies: Sequence[Body]
) -> Vessel | MeshVessel | None:
    """Return a vessel with liquids and bodies in it; None where it does not hold them."""
    try:
        return fill_vessel(vessel, pours, bodies).vessel
    except InputError:
        return None


def _left_out(vessel: GlassBody, what: str, probability: float, tries: _Tries) -> list[Body]:
    """Count what does not fit in a vessel, and return nothing; InputError where it is always asked for."""
    if probability == 1.0:
        expected = f"a probability below 1, or what leaves room for them in {vessel.name} (a {vessel.category})"
        raise InputError(f"vessels.contents.{what}", expected, "1")
    tries.count += 1
    return []


def _counted(vessel: GlassBody, tries: _Tries) -> GlassBody:
    return vessel.model_copy(update={"redrawn": tries.count}) if tries.count else vessel


def _filled(vessel: Vessel | MeshVessel, pours: tuple[Pour, ...]) -> GlassBody:
    return fill_vessel(vessel, pours).vessel


def _liquids(
    streams: Streams, settings: ContentsSettings, vessel: Vessel | MeshVessel, tries: _Tries, chosen: bool
) -> tuple[Pour, ...]:
    """Return the liquids of a vessel: those that it has, a turbid one in their place, or two in layers."""
    rng = streams("liquids")
    turbid, layered = rng.random() < settings.turbid, rng.random() < settings.layered
    if chosen:
        turbid, layered = settings.turbid == 1.0, settings.layered == 1.0
    names = weights_of(settings.turbid_liquids)
    weight = np.array(list(names.values()))
    name = list(names)[int(rng.choice(len(weight), p=weight / weight.sum()))]
    pours = held(vessel)
    if not pours:
        return pours
    if turbid:
        return (Pour(turbid_medium(name), pours[0].volume),)
    if not layered or kind_of(pours[0].medium) != "aqueous" or is_turbid(pours[0].medium):
        return pours
    for _ in range(TRIES):
        fraction = float(rng.uniform(*settings.layer_fraction))
        total = pours[0].volume
        layers = (Pour(pours[0].medium, (1.0 - fraction) * total), Pour(olive_oil(), fraction * total))
        try:
            _filled(vessel, layers)
        except InputError:
            if settings.layered == 1.0:
                raise
            tries.count += 1
            continue
        return layers
    return pours


def _in_vessel(item: SceneObject) -> Mesh:
    """Return the surface of an object in the vessel's frame, which is the world's here."""
    mesh = item.mesh if isinstance(item, Prop) else item.interfaces[0].mesh
    pose = item.world_T_object
    x, y, z = mesh.vertices.astype(np.float64).T
    points = np.stack([a * x + b * y + c * z + t for a, b, c, t in pose[:3]], axis=1)
    normals = None if mesh.normals is None else mesh.normals @ pose[:3, :3].T
    return replace(mesh, vertices=points, normals=normals)


def body_of(kind: str, mesh: Mesh, medium: Medium, count: int = 1) -> Body:
    """Return a body with its record."""
    low, high = mesh.bounds
    centre, size = (0.5 * (low + high)).tolist(), (high - low).tolist()
    record = Content.model_validate(
        {"kind": kind, "count": count, "medium": medium, "centre": centre, "size": size, "volume": volume_of(mesh)}
    )
    return Body(mesh, record)


def _beads(
    rng: np.random.Generator,
    settings: ContentsSettings,
    vessel: Vessel | MeshVessel,
    room: Room,
    leaning: list[Mesh],
    tries: _Tries,
) -> list[Body]:
    wanted, radius = rng.random() < settings.beads, float(rng.uniform(*settings.bead_radius))
    count = int(rng.integers(settings.bead_count[0], settings.bead_count[1] + 1))
    if not wanted:
        return []
    neck = room.narrowest(room.floor + 2.0 * radius, room.brim)
    places = np.zeros((0, 3))
    if neck >= radius + 1e-3:  # they could have come in
        places = bead_places(rng, room, radius, count, [_dense(mesh) for mesh in leaning])
    if not len(places):
        return _left_out(vessel, "beads", settings.beads, tries)
    mesh = balls(places, np.full(len(places), radius), "beads")
    return [body_of("beads", mesh, soda_lime(), len(places))]


def _ice(
    rng: np.random.Generator,
    settings: ContentsSettings,
    vessel: Vessel | MeshVessel,
    room: Room,
    pours: tuple[Pour, ...],
    beads: list[Body],
    leaning: list[Body],
    tries: _Tries,
) -> list[Body]:
    wanted = rng.random() < settings.ice
    if not wanted or not pours:
        return []
    dense = [_dense(body.mesh) for body in (*leaning, *beads)]
    mouth = room.narrowest(vessel.liquids[-1].centre, room.brim)
    sinks = any((pour.medium.density or 0.0) < (ice().density or 0.0) for pour in pours)
    for attempt in range(TRIES):
        count = int(rng.integers(settings.ice_count[0], settings.ice_count[1] + 1))
        edges = rng.uniform(*settings.ice_edge, count)
        # Later tries are of smaller and fewer cubes, within the ranges.
        smaller = attempt / (TRIES - 1)
        edges = edges - smaller * (edges - settings.ice_edge[0])
        count = max(settings.ice_count[0], round(count * (1.0 - smaller)))
        bodies = _cubes(rng, room, edges[:count], vessel.liquids[-1].centre, dense, mouth, sinks=sinks)
        if bodies is not None and _fits(vessel, room, pours, [*beads, *bodies, *leaning]):
            return bodies
        tries.count += 1
    if settings.ice == 1.0:
        most = max(0.0, np.sqrt(2.0) * (mouth - 1e-3))
        expected = f"edges of at most about {1e3 * most:.0f}mm, or fewer cubes, for {vessel.name} (a {vessel.category})"
        found = " ".join(f"{1e3 * edge:g}mm" for edge in settings.ice_edge)
        raise InputError("vessels.contents.ice_edge", expected, found)
    return []


def _cubes(
    rng: np.random.Generator,
    room: Room,
    edges: np.ndarray,
    level: float,
    others: list[np.ndarray],
    mouth: float,
    *,
    sinks: bool,
) -> list[Body] | None:
    if edges.max() * np.sqrt(0.5) > mouth - 1e-3:  # they could not have come in
        return None
    places = ice_places(rng, room, edges, level, others, sinks=sinks)
    if places is None:
        return None
    return [
        body_of("ice cube", _cube(rng, edge, place, level), ice()) for edge, place in zip(edges, places, strict=True)
    ]


def _cube(rng: np.random.Generator, edge: float, place: np.ndarray, level: float) -> Mesh:
    x, y, turn = place.tolist()
    size = edge * np.array([1.0, rng.uniform(0.9, 1.0), rng.uniform(0.85, 1.0)])
    directions = rng.normal(size=(_WAVE_COUNT, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    vectors = directions * (2.0 * np.pi / (edge * rng.uniform(*_WAVELENGTHS, (_WAVE_COUNT, 1))))
    heights = edge * rng.uniform(*_WAVES, (_WAVE_COUNT, 1)) / _WAVE_COUNT
    bumps = np.concatenate([vectors, rng.uniform(0.0, 2.0 * np.pi, (_WAVE_COUNT, 1)), heights], 1)
    # Waves add up to 1 % of the edge; the box is smaller by that, so that the cube keeps within its square.
    mesh = rounded_box(tuple((0.985 * size).tolist()), edge * rng.uniform(*_ROUNDING), bumps, "ice")
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert mesh.normals is not None
    points = mesh.vertices.astype(np.float64) @ rotation.T + np.array([x, y, level - 0.42 * size[2]])
    return replace(mesh, vertices=points, normals=mesh.normals @ rotation.T)


def _fits(vessel: Vessel | MeshVessel, room: Room, pours: tuple[Pour, ...], bodies: list[Body]) -> bool:
    filled = _filled_with(vessel, pours, bodies)
    if filled is None:
        return False
    return max(content.centre[2] + 0.5 * content.size[2] for content in filled.contents) < room.brim + 0.01


def _bubbles(
    rng: np.random.Generator,
    settings: ContentsSettings,
    vessel: Vessel | MeshVessel,
    room: Room,
    pours: tuple[Pour, ...],
    bodies: list[Body],
    leaning: list[Mesh],
    tries: _Tries,
) -> list[Body]:
    wanted = rng.random() < settings.bubbles
    count = int(rng.integers(settings.bubble_count[0], settings.bubble_count[1] + 1))
    radii = rng.uniform(*settings.bubble_radius, count)
    if not wanted or not pours or any(is_turbid(pour.medium) for pour in pours):
        return []
    filled = fill_vessel(vessel, pours, [*bodies, *(Body(mesh) for mesh in leaning)]).vessel
    levels = [min(liquid.centre, liquid.contact) for liquid in filled.liquids]
    meshes = [part.mesh for part in filled.interfaces if part.part == "content"]
    tops = [part.mesh for part in filled.interfaces if part.part in ("liquid_interface", "liquid_surface")]
    places = bubble_places(rng, room, radii, levels, [*meshes, *leaning, *tops])
    if not len(places):
        return _left_out(vessel, "bubbles", settings.bubbles, tries)
    return [body_of("bubbles", balls(places[:, :3], places[:, 3], "bubbles", BUBBLE_STEPS), AIR, len(places))]


def _dense(mesh: Mesh) -> np.ndarray:
    """Return points on a body's edges at most 2 mm apart, (n, 3) [m]; its triangles are small, or long and thin."""
    ends = np.sort(np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]), axis=1)
    return along_edges(mesh.vertices.astype(np.float64)[np.unique(ends, axis=0)], 2e-3)
