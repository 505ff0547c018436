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
from ..description.surroundings import Detail, Panel, RoomEnvironment, RoomPart, Window
from .room_finishes import Finish, palette, panel_finish, shell_finish, solid_finish
from .room_geometry import ALONG, WALL_FACES, Boxes, boxes_of, face_axis, face_frames, face_points
from .room_light import room_irradiance
from .windows import BAR_REFLECTANCE, BAR_WIDTH

# Distance of the vertices on walls and ceiling, on the floor near the table and on furniture [m]: as fine as the light
# changes there. The floor is near the table up to the distance after these [m].
_SHELL_STEP, _FLOOR_STEP, _BODY_STEP, _NEAR = 0.15, 0.05, 0.25, 1.3
# Depth of a window in its wall [m]: the part of a masonry wall inside of the frame, which is as deep as a mullion.
_REVEAL = 0.14
# How far a sill stands out of the wall, and its thickness [m]; windows that begin lower than the last have none.
_SILL_DEPTH, _SILL_THICKNESS, _LOWEST_SILL = 0.06, 0.03, 0.3
# Distance of a lamp's diffuser to its wall, and the width of the frame round it [m].
_LAMP_DEPTH, _LAMP_FRAME = 0.03, 0.015
# Thickness of a picture's frame and of what it holds [m]; the second lies inside the first.
_PANEL_DEPTHS = (0.02, 0.012)
# Sides of a cylinder: seen from a metre a lamp shade of 0.4 m is round to a millimetre.
_SIDES = 24
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
class _Patch:
    """One flat or round piece of a body before it is joined with others."""

    points: np.ndarray  #: (n, 3) [m]
    normals: np.ndarray
    faces: np.ndarray
    uv: np.ndarray  #: (n, 2) along the surface [m]
    irradiance: np.ndarray | None = None


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
    parts: dict[tuple[RoomPart, Finish], list[_Patch]] = defaultdict(list)
    for face in range(6):
        part: RoomPart = "floor" if face == _FLOOR else "ceiling" if face == WALL_FACES["ceiling"] else "wall"
        parts[part, shell_finish(room, face)].append(_shell(room, light, face))
    for number, block in enumerate(room.blocks, start=1):
        lower, upper = np.array(block.lower), np.array(block.upper)
        for face, patch in _box(lower, upper, _BODY_STEP):
            lit = light.at(6 * number + face, patch.points)
            found = _Patch(patch.points, patch.normals, patch.faces, patch.uv, lit)
            parts["furniture", solid_finish(room, block.colour, "plain")].append(found)
    for detail in room.details:
        parts[detail.part, solid_finish(room, detail.colour, detail.finish)] += _detail(detail)
    for part, finish, patch in _on_walls(room, boxes):
        parts[part, finish].append(patch)
    bodies = _bodies(parts, light.mean)
    lamps = [window for window in room.windows if window.kind == "lamp"]
    return bodies + [_lamp(room, boxes, lamp, len(bodies) + k, light.mean) for k, lamp in enumerate(lamps)]


def _bodies(parts: dict[tuple[RoomPart, Finish], list[_Patch]], mean: np.ndarray) -> list[RoomBody]:
    """Return one body for each part and finish; all plain colours of a part are one body with a palette."""
    plain: dict[RoomPart, list[tuple[Finish, _Patch]]] = defaultdict(list)
    bodies: list[RoomBody] = []
    for (part, finish), patches in parts.items():
        if finish.kind == "plain":
            plain[part] += [(finish, patch) for patch in patches]
            continue
        bodies.append(_joined(len(bodies), part, patches, mean, finish.pixels(), finish.tile))
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
    number: int, part: RoomPart, patches: list[_Patch], mean: np.ndarray, pixels: np.ndarray, tile: float = 1.0
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


def _shell(room: RoomEnvironment, light: _Light, face: int) -> _Patch:
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
    faces = _grid_faces((len(a), len(b)), points, normals[face])[closed.ravel()].reshape(-1, 3)
    return _Patch(points, np.tile(normals[face], (len(points), 1)), faces, grid, light.at(face, points))


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


def _grid_faces(shape: tuple[int, int], points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return two triangles for each cell of a grid of vertices that face along the normal, (cells, 2, 3)."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    a, b, c, d = (x.ravel() for x in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=1)
    p, q, r = (points[faces[0, 0, k]] for k in range(3))
    return faces if np.linalg.det([q - p, r - p, normal]) > 0.0 else faces[..., ::-1]


def _box(lower: np.ndarray, upper: np.ndarray, step: float) -> list[tuple[int, _Patch]]:
    """Return the faces of a box seen from outside, numbered as in `room_geometry`."""
    found = []
    for face in range(6):
        axis, side = face // 2, face % 2
        normal = np.zeros(3)
        normal[axis] = 1.0 - 2.0 * side
        along = ALONG[axis]
        counts = [max(1, int(np.ceil((upper[k] - lower[k]) / step - 1e-6))) for k in along]
        lines = [np.linspace(lower[k], upper[k], n + 1) for k, n in zip(along, counts, strict=True)]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        points = np.empty((len(grid), 3))
        points[:, axis] = (upper, lower)[side][axis]
        points[:, along] = grid
        faces = _grid_faces((counts[0] + 1, counts[1] + 1), points, normal).reshape(-1, 3)
        # Texture coordinates along the longest edges: the grain of a board follows it.
        uv = grid - lower[along]
        uv = uv[:, ::-1] if np.ptp(grid[:, 1]) > np.ptp(grid[:, 0]) else uv
        found.append((face, _Patch(points, np.tile(normal, (len(points), 1)), faces, uv)))
    return found


def _detail(detail: Detail) -> list[_Patch]:
    half, pose = 0.5 * np.array(detail.size), np.asarray(detail.room_T_detail)
    patches = _cylinder(half) if detail.shape == "cylinder" else [p for _, p in _box(-half, half, _BODY_STEP)]
    shift = pose[:3, 3]
    return [
        _Patch(p.points @ pose[:3, :3].T + shift, p.normals @ pose[:3, :3].T, p.faces, p.uv + shift[:2])
        for p in patches
    ]


def _cylinder(half: np.ndarray) -> list[_Patch]:
    """Return the side and both ends of a cylinder about z."""
    angle = 2.0 * np.pi * np.arange(_SIDES + 1) / _SIDES
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    outward = np.concatenate([ring / half[:2], np.zeros((len(ring), 1))], axis=1)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    levels = np.array([-half[2], half[2]])
    points = np.concatenate([np.column_stack([ring * half[:2], np.full(len(ring), z)]) for z in levels])
    low, n = np.arange(_SIDES), _SIDES + 1
    side = np.concatenate([np.stack([low, low + 1, low + 1 + n], -1), np.stack([low, low + 1 + n, low + n], -1)])
    uv = np.column_stack([np.tile(angle * half[0], 2), np.repeat(levels, n)])
    patches = [_Patch(points, np.tile(outward, (2, 1)), side, uv)]
    for sign, z in zip((-1.0, 1.0), levels, strict=True):
        cap = np.column_stack([ring[:-1] * half[:2], np.full(_SIDES, z)])
        fan = np.stack([np.zeros(_SIDES - 2, int), np.arange(1, _SIDES - 1), np.arange(2, _SIDES)], -1)
        up = np.tile([0.0, 0.0, sign], (_SIDES, 1))
        patches.append(_Patch(cap, up, fan if sign > 0.0 else fan[:, ::-1], cap[:, :2]))
    return patches


def _on_walls(room: RoomEnvironment, boxes: Boxes) -> list[tuple[RoomPart, Finish, _Patch]]:
    """Return what is in and on the walls: reveals, bars and sills of windows, frames of lamps, pictures and doors."""
    white = solid_finish(room, (BAR_REFLECTANCE,) * 3, "plain")
    found: list[tuple[RoomPart, Finish, _Patch]] = []
    for window in room.windows:
        place = _WallFrame(boxes, WALL_FACES[window.wall])
        if window.kind == "lamp":
            for low, high in _ring(window.centre, window.size, _LAMP_FRAME, outside=True):
                found += [("lamp", white, p) for p in place.box(low, high, 0.0, _LAMP_DEPTH + 0.005)]
            continue
        found += [("window", white, patch) for patch in place.reveal(window)]
        for low, high in _bars(window):
            found += [("window", white, p) for p in place.box(low, high, -_REVEAL, -_REVEAL + BAR_WIDTH)]
        sill = window.centre[1] - 0.5 * window.size[1]
        if sill > _LOWEST_SILL:
            half = 0.5 * window.size[0] + 0.04
            low, high = (window.centre[0] - half, sill - _SILL_THICKNESS), (window.centre[0] + half, sill)
            found += [("window", white, patch) for patch in place.box(low, high, 0.0, _SILL_DEPTH)]
    for number, panel in enumerate(room.panels):
        place, layer = _WallFrame(boxes, WALL_FACES[panel.wall]), int(_lies_on_another(room.panels, number))
        low, high = (tuple(panel.centre[k] + s * 0.5 * panel.size[k] for k in range(2)) for s in (-1.0, 1.0))
        finish = panel_finish(room, number, bool(layer))
        # What a frame holds is set back behind its rim.
        depth = _PANEL_DEPTHS[layer] if layer else _PANEL_DEPTHS[0]
        patches = place.box(low, high, 0.0, depth) if layer or not _has_inside(room.panels, number) else []
        if not patches:
            for a, b in _ring(room.panels[number + 1].centre, room.panels[number + 1].size, 0.03, outside=True):
                patches += place.box(a, b, 0.0, depth)
        if layer:  # its texture is one picture
            patches = [_Patch(p.points, p.normals, p.faces, place.fractions(p.points, low, high)) for p in patches]
        found += [("picture" if layer or _has_inside(room.panels, number) else "wall", finish, p) for p in patches]
    return found


def _lies_on_another(panels: tuple[Panel, ...], number: int) -> bool:
    """Return whether a panel is the picture of the frame before it."""
    before = panels[number - 1] if number else None
    return before is not None and before.wall == panels[number].wall and before.centre == panels[number].centre


def _has_inside(panels: tuple[Panel, ...], number: int) -> bool:
    return number + 1 < len(panels) and _lies_on_another(panels, number + 1)


def _bars(window: Window) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Return the frame and the mullions of a window as rectangles on its wall."""
    low = [window.centre[k] - 0.5 * window.size[k] for k in range(2)]
    high = [window.centre[k] + 0.5 * window.size[k] for k in range(2)]
    found = _ring(window.centre, window.size, BAR_WIDTH, outside=False)
    for bar in range(1, window.bars + 1):
        for axis in range(2):
            middle = low[axis] + window.size[axis] * bar / (window.bars + 1)
            a, b = [x + BAR_WIDTH for x in low], [x - BAR_WIDTH for x in high]
            a[axis], b[axis] = middle - 0.5 * BAR_WIDTH, middle + 0.5 * BAR_WIDTH
            found.append(((a[0], a[1]), (b[0], b[1])))
    return found


def _ring(
    centre: tuple[float, float], size: tuple[float, float], width: float, outside: bool
) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Return the four bars of a frame round a rectangle, or inside its edge, as rectangles."""
    grow = width if outside else 0.0
    x0, y0, x1, y1 = (
        centre[0] - 0.5 * size[0] - grow,
        centre[1] - 0.5 * size[1] - grow,
        centre[0] + 0.5 * size[0] + grow,
        centre[1] + 0.5 * size[1] + grow,
    )
    return [
        ((x0, y0), (x1, y0 + width)),
        ((x0, y1 - width), (x1, y1)),
        ((x0, y0 + width), (x0 + width, y1 - width)),
        ((x1 - width, y0 + width), (x1, y1 - width)),
    ]


class _WallFrame:
    """Rectangles on a wall and their depth before it [m] as places in the room."""

    def __init__(self, boxes: Boxes, face: int) -> None:
        self.axis = face // 2
        self.along = ALONG[self.axis]
        self.inward = -1.0 if face % 2 == 0 else 1.0
        self.plane = float((boxes.upper if face % 2 == 0 else boxes.lower)[0][self.axis])

    def point(self, place: tuple[float, float], depth: float) -> np.ndarray:
        """Return the point at a place on the wall, some depth before it."""
        result = np.empty(3)
        result[self.along], result[self.axis] = place, self.plane + self.inward * depth
        return result

    def fractions(self, points: np.ndarray, low: tuple[float, float], high: tuple[float, float]) -> np.ndarray:
        """Return where points are between the corners of a rectangle, (n, 2) in [0, 1]."""
        return (points[:, self.along] - low) / np.subtract(high, low)

    def box(self, low: tuple[float, float], high: tuple[float, float], near: float, far: float) -> list[_Patch]:
        """Return the faces of the box over a rectangle between two depths, but the one on the wall."""
        a, b = self.point(low, near), self.point(high, far)
        behind = 2 * self.axis + (0 if self.inward < 0.0 else 1)
        return [patch for face, patch in _box(np.minimum(a, b), np.maximum(a, b), _BODY_STEP) if face != behind]

    def reveal(self, window: Window) -> list[_Patch]:
        """Return the four sides of a window's opening, which face its middle."""
        low = tuple(window.centre[k] - 0.5 * window.size[k] for k in range(2))
        high = tuple(window.centre[k] + 0.5 * window.size[k] for k in range(2))
        a, b = self.point(low, 0.0), self.point(high, -_REVEAL)
        sides = _box(np.minimum(a, b), np.maximum(a, b), _BODY_STEP)
        return [_Patch(p.points, -p.normals, p.faces[:, ::-1], p.uv) for face, p in sides if face // 2 != self.axis]


def _lamp(room: RoomEnvironment, boxes: Boxes, lamp: Window, number: int, mean: np.ndarray) -> RoomBody:
    """Return the diffuser of a lamp in the room's wall or ceiling."""
    face = WALL_FACES[lamp.wall]
    place, normal = _WallFrame(boxes, face), face_frames(boxes)[2][face]
    signs = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    points = np.array(
        [
            place.point((lamp.centre[0] + u * lamp.size[0], lamp.centre[1] + v * lamp.size[1]), _LAMP_DEPTH)
            for u, v in signs
        ]
    )
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    if np.linalg.det([points[1] - points[0], points[2] - points[0], normal]) < 0.0:
        faces = faces[:, ::-1]
    patch = _Patch(points, np.tile(normal, (4, 1)), faces, np.array(signs))
    body = _joined(number, "lamp", [patch], mean, np.ones((1, 1, 3), np.float32))
    return replace(body, radiance=lamp.radiance)
