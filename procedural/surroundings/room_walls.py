"""What is in and on the walls of a room: reveals, bars and sills of windows, frames of lamps, pictures and doors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..description.surroundings import Panel, RoomEnvironment, RoomPart, Window
from .room_finishes import Finish, panel_finish, solid_finish
from .room_geometry import ALONG, WALL_FACES, Boxes
from .room_patches import BODY_STEP, Patch, box_patches
from .windows import BAR_REFLECTANCE, BAR_WIDTH

# Depth of a window in its wall [m]: the part of a masonry wall inside of the frame, which is as deep as a mullion.
_REVEAL = 0.14
# How far a sill stands out of the wall and beside the window, and its thickness [m]; windows that begin lower than the
# last have none.
_SILL_DEPTH, _SILL_BESIDE, _SILL_THICKNESS, _LOWEST_SILL = 0.06, 0.04, 0.03, 0.3
#: Distance of a lamp's diffuser to its wall, and the width of the frame round it [m].
LAMP_DEPTH, _LAMP_FRAME = 0.03, 0.015
# How far the frame stands before the diffuser [m].
_LAMP_RIM = 0.005
# Thickness of a picture's frame, of a door and of what a frame holds, and width of the frame [m].
_FRAME_DEPTH, _PICTURE_DEPTH, _FRAME_WIDTH = 0.02, 0.012, 0.03
#: A place on a wall, in its own coordinates [m].
Place = tuple[float, float] | np.ndarray


def on_walls(room: RoomEnvironment, boxes: Boxes) -> list[tuple[RoomPart, Finish, Patch]]:
    """Return what is in and on the walls."""
    white = solid_finish(room, (BAR_REFLECTANCE, BAR_REFLECTANCE, BAR_REFLECTANCE), "plain")
    found: list[tuple[RoomPart, Finish, Patch]] = []
    for window in room.windows:
        place, part = WallFrame(boxes, WALL_FACES[window.wall]), window.kind
        patches = _lamp_frame(place, window) if part == "lamp" else _window_patches(place, window)
        found.extend((part, white, patch) for patch in patches)
    for number in range(len(room.panels)):
        found.extend(_panel(room, boxes, number))
    return found


def _lamp_frame(place: WallFrame, lamp: Window) -> list[Patch]:
    bars = _ring(lamp.centre, lamp.size, _LAMP_FRAME, outside=True)
    return [patch for low, high in bars for patch in place.box(low, high, 0.0, LAMP_DEPTH + _LAMP_RIM)]


def _window_patches(place: WallFrame, window: Window) -> list[Patch]:
    """Return the reveal, the frame, the mullions and the sill of a window."""
    patches = place.reveal(window)
    for low, high in _bars(window):
        patches += place.box(low, high, -_REVEAL, -_REVEAL + BAR_WIDTH)
    sill = window.centre[1] - 0.5 * window.size[1]
    if sill > _LOWEST_SILL:
        half = 0.5 * window.size[0] + _SILL_BESIDE
        low, high = (window.centre[0] - half, sill - _SILL_THICKNESS), (window.centre[0] + half, sill)
        patches += place.box(low, high, 0.0, _SILL_DEPTH)
    return patches


def _panel(room: RoomEnvironment, boxes: Boxes, number: int) -> list[tuple[RoomPart, Finish, Patch]]:
    """Return a door, the frame of a picture, or the picture, which is set back behind the frame's rim."""
    panel = room.panels[number]
    place, inside = WallFrame(boxes, WALL_FACES[panel.wall]), _lies_on_another(room.panels, number)
    low, high = (np.array(panel.centre) + sign * 0.5 * np.array(panel.size) for sign in (-1.0, 1.0))
    finish = panel_finish(room, number, inside)
    if inside:  # its texture is one picture
        patches = place.box(low, high, 0.0, _PICTURE_DEPTH)
        pictures = [replace(p, uv=place.fractions(p.points, low, high)) for p in patches]
        return [("picture", finish, patch) for patch in pictures]
    if _has_inside(room.panels, number):
        inner = room.panels[number + 1]
        bars = _ring(inner.centre, inner.size, _FRAME_WIDTH, outside=True)
        return [("picture", finish, patch) for a, b in bars for patch in place.box(a, b, 0.0, _FRAME_DEPTH)]
    return [("wall", finish, patch) for patch in place.box(low, high, 0.0, _FRAME_DEPTH)]


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


class WallFrame:
    """Rectangles on a wall and their depth before it [m] as places in the room."""

    def __init__(self, boxes: Boxes, face: int) -> None:
        self.axis = face // 2
        self.along = ALONG[self.axis]
        self.inward = -1.0 if face % 2 == 0 else 1.0
        self.plane = float((boxes.upper if face % 2 == 0 else boxes.lower)[0][self.axis])

    def point(self, place: Place, depth: float) -> np.ndarray:
        """Return the point at a place on the wall, some depth before it."""
        result = np.empty(3)
        result[self.along], result[self.axis] = place, self.plane + self.inward * depth
        return result

    def fractions(self, points: np.ndarray, low: Place, high: Place) -> np.ndarray:
        """Return where points are between the corners of a rectangle, (n, 2) in [0, 1]."""
        return (points[:, self.along] - low) / np.subtract(high, low)

    def box(self, low: Place, high: Place, near: float, far: float) -> list[Patch]:
        """Return the faces of the box over a rectangle between two depths, but the one on the wall."""
        a, b = self.point(low, near), self.point(high, far)
        behind = 2 * self.axis + (0 if self.inward < 0.0 else 1)
        return [patch for face, patch in box_patches(np.minimum(a, b), np.maximum(a, b), BODY_STEP) if face != behind]

    def reveal(self, window: Window) -> list[Patch]:
        """Return the four sides of a window's opening, which face its middle."""
        low = np.array(window.centre) - 0.5 * np.array(window.size)
        high = np.array(window.centre) + 0.5 * np.array(window.size)
        a, b = self.point(low, 0.0), self.point(high, -_REVEAL)
        sides = box_patches(np.minimum(a, b), np.maximum(a, b), BODY_STEP)
        return [Patch(p.points, -p.normals, p.faces[:, ::-1], p.uv) for face, p in sides if face // 2 != self.axis]
