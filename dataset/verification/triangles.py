"""The triangles of a scene, in the world, from its description and the meshes stored beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh, turned
from ...procedural.description.scene import TABLE_ID, Interface, Prop, Scene
from ...procedural.description.surroundings import ROOM_IDS, AreaLight, RoomEnvironment
from ...procedural.surroundings.room_bodies import room_bodies, world_T_room

#: Kinds of surfaces, in the order of the codes of ``layers.exr``; lamps, which labels leave out, come last.
OPAQUE, OUTSIDE, WET_WALL, LIQUID_SURFACE, LIQUID_INTERFACE, CONTENT, LAMP = range(7)
_KINDS = {
    "outside": OUTSIDE,
    "wet_wall": WET_WALL,
    "liquid_surface": LIQUID_SURFACE,
    "liquid_interface": LIQUID_INTERFACE,
    "content": CONTENT,
}


@dataclass(frozen=True, eq=False)
class Triangles:
    """n triangles."""

    corners: np.ndarray  #: (n, 3, 3) float64, world [m]; counter-clockwise seen from the front
    normals: np.ndarray  #: (n, 3, 3) float64, unit shading normals at the corners, world
    id: np.ndarray  #: (n,) int, instance id; 0 for lamps
    kind: np.ndarray  #: (n,) int, `OPAQUE`, an opaque solid's, to `LAMP`
    opaque: np.ndarray  #: (n,) bool, those of opaque solids and of turbid liquids
    medium: np.ndarray  #: (n, 2) int, in front and behind: numbers in `media`, -1 for an opaque solid
    media: tuple  #: media of the scene, air first


def triangles_of(scene: Scene) -> Triangles:
    """Return every surface that straight and refracted rays can meet."""
    media: list = []
    rows = [_row(scene.table.mesh, np.eye(4), TABLE_ID, OPAQUE, True, (-1, -1))]
    for item in scene.objects:
        pose = np.asarray(item.world_T_object)
        if isinstance(item, Prop):
            rows.append(_row(item.mesh, pose, item.id, OPAQUE, True, (-1, -1)))
            continue
        for part in item.interfaces:
            front, back = (_number(media, medium) for medium in (part.front, part.back))
            # Opaque surfaces turn their front to the medium that they are seen from.
            mesh, sides = (turned(part.mesh), (back, front)) if part.seen_from_back else (part.mesh, (front, back))
            rows.append(_row(mesh, pose, item.id, _KINDS[part.part], part.opaque is not None, sides))
    room = scene.environment if isinstance(scene.environment, RoomEnvironment) else None
    in_place = room is not None and not room.at_infinity and not scene.picture.spectral
    if room is not None and in_place:
        pose = world_T_room(room)
        rows += [_row(body.mesh, pose, ROOM_IDS[body.part], OPAQUE, True, (-1, -1)) for body in room_bodies(room)]
    rows += [_lamp(light, in_place) for light in scene.lights]
    columns = [np.concatenate(column) for column in zip(*rows, strict=True)]
    return Triangles(*columns, media=tuple(media))


def opaque_ids(scene: Scene) -> list[int]:
    """Return the ids of all that has an opaque surface, with those of the parts of a room."""
    return [
        TABLE_ID,
        *(ROOM_IDS.values() if isinstance(scene.environment, RoomEnvironment) else ()),
        *(item.id for item in scene.objects if isinstance(item, Prop) or any(map(_is_opaque, item.interfaces))),
    ]


def partly_opaque_ids(scene: Scene) -> list[int]:
    """Return the ids of vessels with a turbid liquid: opaque surfaces behind transparent ones."""
    return [item.id for item in scene.vessels if any(map(_is_opaque, item.interfaces))]


def _is_opaque(part: Interface) -> bool:
    return part.opaque is not None


def _number(media: list, medium: object) -> int:
    if medium not in media:
        media.append(medium)
    return media.index(medium)


def _row(
    mesh: Mesh, pose: np.ndarray, number: int, kind: int, opaque: bool, sides: tuple[int, int]
) -> tuple[np.ndarray, ...]:
    # The renderer places float32 positions in the world and rounds them there: so do these.
    turn, shift = pose[:3, :3], pose[:3, 3]
    places = (mesh.vertices.astype(np.float64) @ turn.T + shift).astype(np.float32).astype(np.float64)
    corners = places[mesh.faces]
    if mesh.normals is None:
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.repeat(flat[:, None], 3, axis=1)
    else:
        normals = (mesh.normals.astype(np.float64) @ turn.T)[mesh.faces]
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    n = len(corners)
    return corners, normals, np.full(n, number), np.full(n, kind), np.full(n, opaque), np.tile(sides, (n, 1))


def _lamp(light: AreaLight, in_place: bool) -> tuple[np.ndarray, ...]:
    x, y = 0.5 * light.size[0], 0.5 * light.size[1]
    corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    mesh = Mesh("lamp", corners, np.array([[0, 1, 2], [0, 2, 3]]))
    # A lamp in a room in its place is one of the room's; others have no depth.
    number, kind = (ROOM_IDS["lamp"], OPAQUE) if in_place else (0, LAMP)
    return _row(mesh, np.asarray(light.world_T_light), number, kind, in_place, (-1, -1))
