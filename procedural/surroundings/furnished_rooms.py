"""Rooms in their places: a kitchen, a laboratory, a dining room or a study around the table, with furniture.

The room is as large as its cameras need, so that they stand inside it and clear of what stands along the walls.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..description.camera import Camera
from ..description.surroundings import (
    AreaLight,
    Detail,
    Environment,
    Panel,
    Reflectance,
    RoomEnvironment,
    RoomPart,
    RoomUse,
    Table,
    Wall,
    Window,
)
from .camera_ranges import Workspace
from .furniture import (
    Furniture,
    Item,
    Place,
    Style,
    at_window,
    base_units,
    book_shelf,
    bottle_bench,
    draw_style,
    sideboard,
    skirting,
    tall_cupboard,
    wall_units,
)
from .room_bodies import world_T_room
from .rooms import TABLE_HEIGHT, draw_colours, draw_panels, draw_windows, paint, wood
from .settings import EnvironmentSettings

# Least distance of the table's centre to a wall beyond the farthest camera [m]: benches are 0.75 m deep, with their
# handles; and least height of the ceiling over the farthest camera.
_BEHIND, _ABOVE = 0.85, 0.25
# Side and height of rooms [m]: from a small kitchen to a hall.
_SIDE, _HEIGHT, _HIGHEST = (3.6, 7.5), (2.4, 3.0), 60.0
# Tables stand square to the walls, within this standard deviation [rad].
_SQUARE = 0.03
# Width of items along the walls and of the gap between two [m]; share of stretches that stay free.
_WIDTH, _ITEM_GAP, _FREE = (0.8, 2.4), (0.02, 0.8), 0.25
# Height of the sill from which low furniture stands under a window [m].
_SILL_OVER_FURNITURE = 0.92
# Sides of floor tiles [m]; probabilities of tiles by use, otherwise boards, or a plain floor.
_FLOOR_TILES, _TILED, _BOARDED = (0.2, 0.3, 0.4), {"kitchen": 0.6, "laboratory": 0.4}, 0.65
_BOARD_WIDTH = (0.08, 0.2)
# What stands in a room, by its use: low furniture for under windows, and furniture that reaches up.
_LOW: dict[RoomUse, tuple[Item, ...]] = {
    "kitchen": (base_units,),
    "laboratory": (base_units, sideboard),
    "dining-room": (sideboard,),
    "study": (sideboard,),
}
_HIGH: dict[RoomUse, tuple[Item, ...]] = {
    "kitchen": (wall_units, wall_units, tall_cupboard),
    "laboratory": (bottle_bench, bottle_bench, tall_cupboard),
    "dining-room": (sideboard, book_shelf, tall_cupboard),
    "study": (book_shelf, book_shelf, sideboard, tall_cupboard),
}
# Legs: width, inset from the edge; apron: height, thickness, inset [m]. A round table has a column on a disc.
_LEG, _INSET, _APRON, _APRON_THICKNESS = (0.04, 0.08), 0.05, 0.09, 0.02
_COLUMN, _FOOT, _FOOT_FRACTION = 0.09, 0.03, 0.55
# Chairs: side, height of the seat, its thickness, height of the back, legs; gap between the table and a back [m].
_CHAIR, _SEAT, _SEAT_THICKNESS, _BACK, _CHAIR_LEG = 0.42, 0.45, 0.03, (0.76, 0.88), 0.032
_CHAIR_GAP, _CHAIRS = (0.05, 0.35), 6
# Distance that chairs keep from cameras, and from the lines between them and what they look at [m].
_CLEAR_OF_CAMERA, _CLEAR_OF_VIEW = 0.4, 0.05
# Thickness of a lamp's housing by its kind, how far it stands out beside the diffuser, its distance behind it, and the
# diameter of the rod that it hangs from [m].
_HOUSING = {"bulb": 0.05, "desk-lamp": 0.1, "tube": 0.04, "panel": 0.03, "soft-box": 0.25}
_RIM, _CLEAR_OF_DIFFUSER, _ROD = 0.008, 0.004, 0.012
_SIDES: tuple[Wall, Wall, Wall, Wall] = ("+x", "-x", "+y", "-y")


def room_in_place(
    rng: np.random.Generator, settings: EnvironmentSettings, environment: Environment, table: Table, reach: float
) -> Environment:
    """Return a furnished room in place of a drawn one; other surroundings stay as they are.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream ``"environment/room"``.
    settings : EnvironmentSettings
        Whether rooms are in their places, and what they are used for.
    environment : Environment
        The surroundings that were drawn.
    table : Table
        It gets legs.
    reach : float
        Largest distance of a camera from the table's centre [m].
    """
    if not isinstance(environment, RoomEnvironment) or not settings.room_depth:
        return environment
    use = settings.room_uses[int(rng.integers(len(settings.room_uses)))]
    clear = max(reach, 0.5 * math.hypot(*table.size[:2])) + _BEHIND
    size = _size(rng, clear)
    middle = [rng.uniform(clear, side - clear) for side in size[:2]]
    windows = draw_windows(rng, size)
    colours = draw_colours(rng)
    style, furniture = draw_style(rng, use), Furniture(size)
    panels = _furnish(rng, furniture, windows, style, use)
    tile = float(rng.choice(_FLOOR_TILES)) if rng.random() < _TILED.get(use, 0.1) else 0.0
    floor = paint(rng, (0.15, 0.6), 0.12) if tile else colours[-1]
    boards = 0.0 if tile or rng.random() > _BOARDED else float(rng.uniform(*_BOARD_WIDTH))
    room = RoomEnvironment(
        at_infinity=False,
        use=use,
        size=size,
        eye=(float(middle[0]), float(middle[1]), TABLE_HEIGHT),
        wall_colours=(*colours[:-1], floor),
        windows=windows,
        panels=panels,
        blocks=tuple(furniture.blocks),
        details=tuple(furniture.details),
        board_width=boards,
        floor_tile=tile,
        seed=int(rng.integers(2**31)),
        rotation=float(0.5 * np.pi * rng.integers(4) + rng.normal(0.0, _SQUARE)),
    )
    return room.model_copy(update={"details": (*room.details, *_legs(rng, room, table))})


def _size(rng: np.random.Generator, clear: float) -> tuple[float, float, float]:
    sides = [float(rng.uniform(max(_SIDE[0], 2.0 * clear), max(_SIDE[1], 2.0 * clear + 1.0))) for _ in range(2)]
    highest = TABLE_HEIGHT + clear - _BEHIND + _ABOVE
    return sides[0], sides[1], max(float(rng.uniform(*_HEIGHT)), highest)


def _furnish(
    rng: np.random.Generator, furniture: Furniture, windows: tuple[Window, ...], style: Style, use: RoomUse
) -> tuple[Panel, ...]:
    """Put furniture along the walls; return the doors and pictures that it leaves free."""
    occupied: dict[Wall, list[tuple[float, float, float]]] = {side: [] for side in _SIDES}
    corner = 0.8  # what stands in a corner belongs to one of its walls
    panels = draw_panels(rng, furniture.size, windows)
    doors = [panel for panel in panels if panel.centre[1] - 0.5 * panel.size[1] < 0.01]
    panels = tuple(panel for panel in panels if panel not in doors[1:])
    for side in _SIDES:
        length = furniture.size[1] if side in ("+x", "-x") else furniture.size[0]
        lowest = min((w.centre[1] - 0.5 * w.size[1] for w in windows if w.wall == side), default=None)
        items = _HIGH[use] if lowest is None else _LOW[use] if lowest > _SILL_OVER_FURNITURE else ()
        lamps = any(w.wall == side and w.kind == "lamp" for w in windows)
        x = corner * (side in ("+y", "-y"))
        while items and not lamps and x < length - 1.0 - corner:
            width = min(float(rng.uniform(*_WIDTH)), length - corner - x)
            door = next(
                (d for d in doors[:1] if d.wall == side and abs(d.centre[0] - x - 0.5 * width) < 0.6 + 0.5 * width),
                None,
            )
            if door is not None:
                x = door.centre[0] + 0.6
                continue
            if rng.random() > _FREE:
                item = items[int(rng.integers(len(items)))]
                item(Place(furniture, side, x), rng, style, width)
                occupied[side].append((x, x + width, 1.05 if item in (sideboard, base_units) else furniture.size[2]))
            x += width + (0.0 if use == "kitchen" else float(rng.uniform(*_ITEM_GAP)))
        skirting(furniture, side, length, windows, style.top if use == "laboratory" else _skirting_colour(rng))
    for window in windows:
        if window.kind == "window" and not any(a < window.centre[0] < b for a, b, _ in occupied[window.wall]):
            at_window(furniture, rng, window, style)
    return tuple(panel for panel in panels if not _is_hidden(panel, occupied[panel.wall]))


def _skirting_colour(rng: np.random.Generator) -> Reflectance:
    return wood(rng) if rng.random() < 0.4 else paint(rng, (0.6, 0.8), 0.02)


def _is_hidden(panel: Panel, occupied: list[tuple[float, float, float]]) -> bool:
    """Return whether furniture stands before a door or a picture."""
    low, high = panel.centre[0] - 0.5 * panel.size[0], panel.centre[0] + 0.5 * panel.size[0]
    foot = panel.centre[1] - 0.5 * panel.size[1]
    return any(a < high + 0.03 and low - 0.03 < b and foot < top for a, b, top in occupied)


def _legs(rng: np.random.Generator, room: RoomEnvironment, table: Table) -> list[Detail]:
    """Return the legs of the table: four with an apron, or a column on a disc under a round one."""
    colour = wood(rng) if rng.random() < 0.5 else paint(rng, (0.03, 0.7), 0.05)
    length, width, thickness = table.size
    under = -thickness
    is_round = _is_round(table)
    foot = -TABLE_HEIGHT
    if is_round:
        disc = _FOOT_FRACTION * length
        return [
            _detail(room, "table-leg", (0.0, 0.0, foot + 0.5 * _FOOT), (disc, disc, _FOOT), colour, shape="cylinder"),
            _detail(
                room,
                "table-leg",
                (0.0, 0.0, 0.5 * (foot + _FOOT + under)),
                (_COLUMN, _COLUMN, under - foot - _FOOT),
                colour,
                shape="cylinder",
            ),
            _detail(
                room, "table-leg", (0.0, 0.0, under - 0.02), (0.5 * disc, 0.5 * disc, 0.038), colour, shape="cylinder"
            ),
        ]
    side = float(rng.uniform(*_LEG))
    x, y = 0.5 * length - _INSET - 0.5 * side, 0.5 * width - _INSET - 0.5 * side
    height = under - foot - 0.001
    legs = [
        _detail(room, "table-leg", (a * x, b * y, foot + 0.5 * height), (side, side, height), colour)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    z = under - 0.001 - 0.5 * _APRON
    aprons = [
        _detail(room, "table-leg", (0.0, b * y, z), (2 * x - side, _APRON_THICKNESS, _APRON), colour) for b in (-1, 1)
    ]
    aprons += [
        _detail(room, "table-leg", (a * x, 0.0, z), (_APRON_THICKNESS, 2 * y - side, _APRON), colour) for a in (-1, 1)
    ]
    return legs + aprons


def _is_round(table: Table) -> bool:
    corner = table.mesh.vertices[:, :2].astype(float)
    return bool((np.abs(corner) / (0.5 * np.array(table.size[:2]))).sum(axis=1).max() < 1.6)


def _detail(
    room: RoomEnvironment,
    part: RoomPart,
    centre: tuple[float, float, float],
    size: tuple[float, float, float],
    colour: Reflectance,
    world_R_detail: np.ndarray | None = None,
    shape: str = "box",
) -> Detail:
    """Return a small body that is given in the world."""
    world_T_detail = np.eye(4)
    world_T_detail[:3, 3] = centre
    if world_R_detail is not None:
        world_T_detail[:3, :3] = world_R_detail
    pose = np.linalg.inv(world_T_room(room)) @ world_T_detail
    kind = "cylinder" if shape == "cylinder" else "box"
    return Detail(part=part, shape=kind, room_T_detail=pose, size=size, colour=colour)


def with_loose_things(
    rng: np.random.Generator,
    environment: Environment,
    table: Table,
    lights: Sequence[AreaLight],
    cameras: Sequence[Camera],
    workspace: Workspace,
) -> Environment:
    """Return a room with what depends on lamps and cameras: housings of the lamps, and chairs that hide nothing."""
    if not isinstance(environment, RoomEnvironment) or environment.at_infinity:
        return environment
    found = [body for light in lights for body in _housing(environment, light)]
    if environment.use != "laboratory":
        found += _chairs(rng, environment, table, cameras, workspace)
    return environment.model_copy(update={"details": (*environment.details, *found)})


def _housing(room: RoomEnvironment, light: AreaLight) -> list[Detail]:
    depth, pose = _HOUSING.get(light.kind, 0.05), light.world_T_light
    colour = (0.05, 0.05, 0.05) if light.kind in ("soft-box", "desk-lamp") else (0.7, 0.7, 0.7)
    centre = pose[:3, 3] - pose[:3, 2] * (_CLEAR_OF_DIFFUSER + 0.5 * depth)
    size = (light.size[0] + 2 * _RIM, light.size[1] + 2 * _RIM, depth)
    top = room.size[2] - TABLE_HEIGHT
    rod = (float(centre[0]), float(centre[1]), float(0.5 * (centre[2] + top)))
    return [
        _detail(room, "lamp", _triple(centre), size, colour, pose[:3, :3]),
        _detail(room, "lamp", rod, (_ROD, _ROD, float(top - centre[2])), colour, shape="cylinder"),
    ]


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    first, second, third = map(float, values)
    return first, second, third


def _chairs(
    rng: np.random.Generator,
    room: RoomEnvironment,
    table: Table,
    cameras: Sequence[Camera],
    workspace: Workspace,
) -> list[Detail]:
    """Return chairs around the table that stand clear of all cameras and of what they look at."""
    count, back = int(rng.integers(0, _CHAIRS + 1)), float(rng.uniform(*_BACK))
    colour = wood(rng) if rng.random() < 0.6 else paint(rng, (0.03, 0.7), 0.3)
    turns = (
        rng.permutation(8)[:count] * (0.25 * np.pi) if _is_round(table) else rng.permutation(4)[:count] * (0.5 * np.pi)
    )
    found: list[Detail] = []
    for turn in turns:
        gap, swing = float(rng.uniform(*_CHAIR_GAP)), float(rng.normal(0.0, 0.08))
        out = np.array([np.cos(turn), np.sin(turn)])
        edge = 0.5 * table.size[0] if _is_round(table) else 0.5 * abs(out @ np.array(table.size[:2]))
        place = out * (edge + gap)
        if not _is_clear(np.array([*place, back - TABLE_HEIGHT]), cameras, workspace):
            continue
        found += _chair(room, place, float(turn) + swing, back, colour)
    return found


def _is_clear(top: np.ndarray, cameras: Sequence[Camera], workspace: Workspace) -> bool:
    """Return whether a chair whose back ends at a place hides nothing from the cameras, and holds none."""
    for camera in cameras:
        for pose in (camera.world_T_camera, camera.world_T_right):
            eye = pose[:3, 3]
            away = top[:2] - eye[:2]
            if math.hypot(*away) < _CLEAR_OF_CAMERA and eye[2] < top[2] + _CLEAR_OF_CAMERA:
                return False
            line = workspace.centre - eye
            along = float(np.clip(away @ line[:2] / max(float(line[:2] @ line[:2]), 1e-9), 0.0, 1.0))
            beside = math.hypot(*(eye[:2] + along * line[:2] - top[:2]))
            lowest = eye[2] + along * (line[2] - workspace.radius) - _CLEAR_OF_VIEW
            if 0.0 < along < 1.0 and beside < workspace.radius + 0.5 * _CHAIR and lowest < top[2]:
                return False
    return True


def _chair(room: RoomEnvironment, place: np.ndarray, turn: float, back: float, colour: Reflectance) -> list[Detail]:
    """Return a chair whose back is at a place and faces the table."""
    cos, sin = math.cos(turn), math.sin(turn)
    world_R_chair = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    origin, half = np.array([*place, -TABLE_HEIGHT]), 0.5 * _CHAIR
    leg, seat = _CHAIR_LEG, _SEAT

    def body(centre: tuple[float, float, float], size: tuple[float, float, float]) -> Detail:
        return _detail(
            room, "furniture", _triple(origin + world_R_chair @ np.array(centre)), size, colour, world_R_chair
        )

    # The local x axis points away from the table; the back is at x = 0.
    parts = [body((-half, 0.0, seat - 0.5 * _SEAT_THICKNESS), (_CHAIR, _CHAIR, _SEAT_THICKNESS))]
    for y in (-half + 0.5 * leg, half - 0.5 * leg):
        parts.append(body((-0.5 * leg, y, 0.5 * back), (leg, leg, back)))
        front = seat - _SEAT_THICKNESS
        parts.append(body((-_CHAIR + 0.5 * leg, y, 0.5 * front), (leg, leg, front)))
    slats = np.linspace(seat + 0.12, back - 0.03, 3).tolist()
    return parts + [body((-0.5 * leg, 0.0, z), (0.018, _CHAIR - 2 * leg, 0.05)) for z in slats]
