"""The surfaces of a room in its place, as meshes: walls with openings, windows, lamps, pictures and furniture.

Coordinates are the room's own: metres from its corner, as in `room_geometry`. Surfaces of one part and one finish are
one mesh. Each vertex has a first estimate of the light that arrives there (`room_light`); the renderer gathers it again
with all small bodies (`render.scene.room_light_map`).
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...core.mesh import Mesh
from ..description.surroundings import Detail, RoomEnvironment, RoomPart, Window
from .room_finishes import Finish, palette, shell_finish, solid_finish
from .room_geometry import ALONG, WALL_FACES, Boxes, boxes_of, face_axis, face_frames, face_points
from .room_light import room_irradiance
from .room_patches import BODY_STEP, Patch, box_patches, cylinder_patches, grid_faces
from .room_walls import LAMP_DEPTH, WallFrame, on_walls

# Distance of the vertices on walls and ceiling, and on the floor near the table [m]: as fine as the light changes. The
# floor is near the table up to the distance after these [m].
_SHELL_STEP, _FLOOR_STEP, _NEAR = 0.15, 0.05, 1.3
_FLOOR = 5
_WALL_NAMES = {number: name for name, number in WALL_FACES.items()}


@dataclass(frozen=True, eq=False)
class RoomBody:
    """Surfaces of one part and one finish. Faces are seen from their front alone."""

    part: RoomPart
    mesh: Mesh  #: room frame; texture coordinates are repeats of the finish
    normals: np.ndarray  #: (n, 3) float64, of the vertices
    inward: np.ndarray  #: (n, 3) float64, from each vertex a little towards the middle of its surface [m]
    irradiance: np.ndarray  #: (n, 3) float64, the estimate, radiance times steradians
    pixels: np.ndarray  #: (h, w, 3) float32, reflectance of one repeat
    radiance: tuple[float, float, float] | None = None  #: of what shines by itself [kcd/m^2]


@dataclass(frozen=True, eq=False)
class _Light:
    """The estimate: irradiance of the faces of room and furniture, and their mean for all small bodies."""

    boxes: Boxes
    faces: list[np.ndarray]
    mean: np.ndarray

    def at(self, face: int, points: np.ndarray) -> np.ndarray:
        """Return the irradiance at points of a face, (n, 3)."""
        corner, size, _ = face_frames(self.boxes)
        grid, along = self.faces[face], ALONG[face_axis(np.array([face]))[0]]
        fraction = (points[:, along] - corner[face]) / size[face]
        cell = np.clip((fraction * grid.shape[:2]).astype(int), 0, np.array(grid.shape[:2]) - 1)
        return grid[cell[:, 0], cell[:, 1]].astype(np.float64)


def world_T_room(room: RoomEnvironment) -> np.ndarray:
    """Return the pose of a room's corner, (4, 4) float64 [m]: its eye is the world's origin."""
    cos, sin = np.cos(room.rotation), np.sin(room.rotation)
    pose = np.eye(4)
    pose[:2, :2] = [[cos, -sin], [sin, cos]]
    pose[:3, 3] = -pose[:3, :3] @ np.array(room.eye)
    return pose


def room_bodies(room: RoomEnvironment) -> list[RoomBody]:
    """Return the surfaces of a room, without its ``strength``, in an order that depends on the description alone."""
    boxes = boxes_of(room)
    faces = room_irradiance(room)
    cells = np.concatenate([face.reshape(-1, 3) for face in faces])
    light = _Light(boxes, faces, cells.mean(axis=0, dtype=np.float64))
    parts: dict[tuple[RoomPart, Finish], list[Patch]] = defaultdict(list)
    for face in range(6):
        part: RoomPart = "floor" if face == _FLOOR else "ceiling" if face == WALL_FACES["ceiling"] else "wall"
        parts[part, shell_finish(room, face)].append(_shell(room, light, face))
    for number, block in enumerate(room.blocks, start=1):
        lower, upper = np.array(block.lower), np.array(block.upper)
        for face, patch in box_patches(lower, upper, BODY_STEP):
            lit = light.at(6 * number + face, patch.points)
            found = Patch(patch.points, patch.normals, patch.faces, patch.uv, lit)
            parts["furniture", solid_finish(room, block.colour, "plain")].append(found)
    for detail in room.details:
        parts[detail.part, solid_finish(room, detail.colour, detail.finish)] += _detail(detail)
    for part, finish, patch in on_walls(room, boxes):
        parts[part, finish].append(patch)
    bodies = _bodies(parts, light.mean)
    lamps = [window for window in room.windows if window.kind == "lamp"]
    return bodies + [_lamp(room, boxes, lamp, len(bodies) + k, light.mean) for k, lamp in enumerate(lamps)]


def _bodies(parts: dict[tuple[RoomPart, Finish], list[Patch]], mean: np.ndarray) -> list[RoomBody]:
    """Return one body for each part and finish; all plain colours of a part are one body with a palette."""
    plain: dict[RoomPart, list[tuple[Finish, Patch]]] = defaultdict(list)
    bodies: list[RoomBody] = []
    for (part, finish), patches in parts.items():
        if finish.kind == "plain":
            plain[part] += [(finish, patch) for patch in patches]
            continue
        bodies.append(_joined(len(bodies), part, patches, mean, finish.pixels(), finish.sides))
    for part, items in plain.items():
        colours = list(dict.fromkeys(finish.colour for finish, _ in items))
        patches = []
        for finish, patch in items:
            uv = np.full((len(patch.points), 2), 0.5)
            uv[:, 0] = (colours.index(finish.colour) + 0.5) / len(colours)
            patches.append(replace(patch, uv=uv))
        bodies.append(_joined(len(bodies), part, patches, mean, palette(colours)))
    return bodies


def _joined(
    number: int,
    part: RoomPart,
    patches: list[Patch],
    mean: np.ndarray,
    pixels: np.ndarray,
    tile: np.ndarray | float = 1.0,
) -> RoomBody:
    counts = np.cumsum([0, *(len(patch.points) for patch in patches)])
    faces = np.concatenate([patch.faces + first for patch, first in zip(patches, counts[:-1], strict=True)])
    uv = np.concatenate([patch.uv for patch in patches]) / tile
    points = np.concatenate([patch.points for patch in patches])
    lit = [mean + np.zeros_like(p.points) if p.irradiance is None else p.irradiance for p in patches]
    inward = [np.mean(patch.points, axis=0) - patch.points for patch in patches]
    mesh = Mesh(f"room-{number:03d}", points, faces, uv=uv)
    normals = np.concatenate([patch.normals for patch in patches])
    return RoomBody(part, mesh, normals, np.concatenate(inward), np.concatenate(lit), pixels)


def _shell(room: RoomEnvironment, light: _Light, face: int) -> Patch:
    """Return a wall, floor or ceiling as a grid of vertices, with holes where its windows are."""
    corner, size, normals = face_frames(light.boxes)
    holes = [w for w in room.windows if w.kind == "window" and WALL_FACES[w.wall] == face]
    axes = []
    for k in range(2):
        edges = [w.centre[k] + sign * 0.5 * w.size[k] for w in holes for sign in (-1.0, 1.0)]
        breaks = np.unique(np.round([corner[face][k], corner[face][k] + size[face][k], *edges], 6))
        eye = room.eye[ALONG[face_axis(np.array([face]))[0]][k]]
        axes.append(_subdivided(breaks, eye if face == _FLOOR else None))
    a, b = axes
    grid = np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1).reshape(-1, 2)
    points = face_points(light.boxes, np.full(len(grid), face), grid).astype(np.float64)
    middle = np.stack(np.meshgrid(0.5 * (a[1:] + a[:-1]), 0.5 * (b[1:] + b[:-1]), indexing="ij"), axis=-1)
    closed = np.ones(middle.shape[:2], bool)
    for hole in holes:
        closed &= (np.abs(middle - np.array(hole.centre)) > 0.5 * np.array(hole.size)).any(axis=-1)
    faces = grid_faces((len(a), len(b)), points, normals[face])[closed.ravel()].reshape(-1, 3)
    return Patch(points, np.tile(normals[face], (len(points), 1)), faces, grid, light.at(face, points))


def _subdivided(breaks: np.ndarray, near: float | None) -> np.ndarray:
    """Return coordinates between breaks at most a step apart, which is fine near a place of the floor."""
    if near is not None:
        inner = [near - _NEAR, near + _NEAR]
        breaks = np.unique([*breaks, *(x for x in inner if breaks[0] < x < breaks[-1])])
    found = [breaks[:1]]
    for low, high in pairwise(breaks):
        fine = near is not None and abs(0.5 * (low + high) - near) < _NEAR
        count = max(1, int(np.ceil((high - low) / (_FLOOR_STEP if fine else _SHELL_STEP) - 1e-6)))
        found.append(low + (high - low) * np.arange(1, count + 1) / count)
    return np.concatenate(found)


def _detail(detail: Detail) -> list[Patch]:
    half, pose = 0.5 * np.array(detail.size), np.asarray(detail.room_T_detail)
    patches = (
        cylinder_patches(half) if detail.shape == "cylinder" else [p for _, p in box_patches(-half, half, BODY_STEP)]
    )
    shift = pose[:3, 3]
    return [
        Patch(p.points @ pose[:3, :3].T + shift, p.normals @ pose[:3, :3].T, p.faces, p.uv + shift[:2]) for p in patches
    ]


def _lamp(room: RoomEnvironment, boxes: Boxes, lamp: Window, number: int, mean: np.ndarray) -> RoomBody:
    """Return the diffuser of a lamp in the room's wall or ceiling."""
    face = WALL_FACES[lamp.wall]
    place, normal = WallFrame(boxes, face), face_frames(boxes)[2][face]
    signs = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    points = np.array(
        [
            place.point((lamp.centre[0] + u * lamp.size[0], lamp.centre[1] + v * lamp.size[1]), LAMP_DEPTH)
            for u, v in signs
        ]
    )
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    if np.linalg.det([points[1] - points[0], points[2] - points[0], normal]) < 0.0:
        faces = faces[:, ::-1]
    patch = Patch(points, np.tile(normal, (4, 1)), faces, np.array(signs))
    body = _joined(number, "lamp", [patch], mean, np.ones((1, 1, 3), np.float32))
    return replace(body, radiance=lamp.radiance)
