"""Loads a room that is in its place: its surfaces as bodies of the scene, and the light that they send out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...procedural.description.material import OpaqueMaterial, UniformTexture
from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import ROOM_IDS, RoomEnvironment
from ...procedural.optics.medium import AIR
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.metering import irradiance
from ...procedural.surroundings.outside_view import bake_outside
from ...procedural.surroundings.room_bodies import RoomBody, room_bodies, world_T_room
from .._mitsuba import dr, mi
from .bodies import Body, opaque_bsdf
from .emitters import Emitters
from .lighting import make_literals_opaque
from .room_emitter import RoomEmitter, room_emitter
from .room_light_map import first_corners, lit_room
from .spectrum import in_channel
from .surfaces import ROOM_OBJECT, Surface, registry_id

# Rays end at the room, so its surfaces have a reflectance alone; its colour is that of each surface's own tile.
_MATT = OpaqueMaterial(name="room", base_colour=UniformTexture(colour=(0.5, 0.5, 0.5)), roughness=1.0)


@dataclass(frozen=True, eq=False)
class RoomSurface:
    """A surface of the room, as described and as loaded."""

    described: RoomBody
    body: Body


def room_surfaces_of(scene: Scene, has_light: bool = False, channel: int | None = None) -> list[RoomSurface]:
    """Return the surfaces of a scene's room; none where it is a map at infinity.

    None either in other than RGB variants, but for those of one channel where the scene's `lit_emitter` is given the
    light of the room's surfaces.
    """
    room = scene.environment
    if not isinstance(room, RoomEnvironment) or room.at_infinity or mi.is_spectral:
        return []
    if not has_light and (not mi.is_rgb or mi.is_polarized):
        return []
    pose = world_T_room(room)
    return [_surface(described, pose, channel) for described in room_bodies(room)]


def lamp_surface(in_room: bool) -> Surface:
    """Return the record of an area light: without depth in labels, but for lamps in a room that has one."""
    if not in_room:
        return Surface(0, -1, True, AIR, AIR, 0.0)
    return Surface(0, ROOM_OBJECT, True, AIR, AIR, 0.0, label=ROOM_IDS["lamp"])


def _surface(described: RoomBody, pose: np.ndarray, channel: int | None) -> RoomSurface:
    surface = Surface(0, ROOM_OBJECT, True, AIR, AIR, 0.0, label=ROOM_IDS[described.part])
    bsdf = mi.load_dict(opaque_bsdf(_MATT, in_channel(np.array(described.pixels), channel)))
    return RoomSurface(described, Body(described.mesh, pose, bsdf, surface, material=_MATT))


def lit_emitter(
    scene: Scene,
    mi_scene: mi.Scene,
    surfaces: list[RoomSurface],
    stored: np.ndarray | None = None,
    channel: int | None = None,
) -> RoomEmitter | None:
    """Return what the room sends out; None without a room in its place.

    Parameters
    ----------
    scene : Scene
        The description.
    mi_scene : mi.Scene
        The loaded scene, whose shapes are ``body0`` (the table) and so on, the room's last.
    surfaces : list of RoomSurface
        The room's, in the order of the shapes.
    stored : (n, 3) float32, optional
        Irradiance of the corners of all faces, as it was gathered before.
    channel : int, optional
        One of red, green and blue (`spectrum.in_channel`).
    """
    if not surfaces:
        return None
    assert isinstance(scene.environment, RoomEnvironment)
    shapes = {shape.id(): shape for shape in mi_scene.shapes()}
    bodies = [shape for name, shape in shapes.items() if name.startswith("body")]
    names = [f"body{k}" for k in range(len(bodies) - len(surfaces), len(bodies))]
    rows = [int(registry_id(mi.ShapePtr(shapes[name]))[0]) for name in names]
    corners = {
        row: first_corners(s.described) * scene.environment.strength for row, s in zip(rows, surfaces, strict=True)
    }
    outside = in_channel(bake_outside(scene.environment), channel) * np.float32(scene.environment.strength)
    alone = mi.load_dict({"type": "scene", **{name: shapes[name] for name in names}}, optimize=False)
    estimate = room_emitter(scene.environment, mi_scene, alone, corners, outside)
    if stored is not None:
        kept = mi.Float(stored.astype(np.float32).ravel())
        dr.make_opaque(kept)
        return replace(estimate, irradiance=kept)
    lamps = {name: shape for name, shape in shapes.items() if name.startswith("light")}
    parts = {name: shapes[name] for name in ("body0", *names)} | lamps
    bake = mi.load_dict({"type": "scene", "environment": mi_scene.environment(), **parts}, optimize=False)
    make_literals_opaque(bake)
    level = irradiance(bake_environment(scene.environment), scene.environment.strength, scene.lights)
    described = [(row, s.described, s.body.world_T_mesh) for row, s in zip(rows, surfaces, strict=True)]
    return replace(lit_room(Emitters(bake, estimate), described, float(luminance(level))), surfaces=alone)
