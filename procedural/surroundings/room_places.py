"""Whether a lamp has a place in a room: inside it, and clear of its furniture."""

from __future__ import annotations

import numpy as np

from ..description.surroundings import AreaLight, RoomEnvironment

#: Least distance of a lamp to walls, windows, ceiling, floor and furniture [m]: half the depth of a fitting.
CLEARANCE = 0.05


def fits_in_room(room: RoomEnvironment, light: AreaLight, clearance: float = CLEARANCE) -> bool:
    """Return whether a lamp is inside a room and outside its blocks, with a clearance [m] to all of them."""
    corners = room_corners(room, light)
    if (corners < clearance).any() or (corners > np.array(room.size) - clearance).any():
        return False
    boxes = [(np.array(block.lower) - clearance, np.array(block.upper) + clearance) for block in room.blocks]
    if any(_meets_box(corners, lower, upper) for lower, upper in boxes):
        return False
    return not _meets_details(corners, room, clearance)


def _meets_details(corners: np.ndarray, room: RoomEnvironment, clearance: float) -> bool:
    """Return whether the bounds of a lamp meet those of a small body, other than the lamp's own housing."""
    low, high = corners.min(axis=0) - clearance, corners.max(axis=0) + clearance
    for detail in room.details:
        reach = 0.5 * np.abs(np.asarray(detail.room_T_detail)[:3, :3]) @ np.array(detail.size)
        middle = np.asarray(detail.room_T_detail)[:3, 3]
        if detail.part != "lamp" and (middle - reach < high).all() and (middle + reach > low).all():
            return True
    return False


def room_corners(room: RoomEnvironment, light: AreaLight) -> np.ndarray:
    """Return the corners of a lamp from the room's corner, (4, 3) float64 [m], in order round the rectangle."""
    pose = light.world_T_light
    signs = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    corners = pose[:3, 3] + (signs * np.array(light.size)) @ pose[:3, :2].T
    # The room's map is turned counter-clockwise by its rotation; the world's points are turned back.
    cos, sin = np.cos(room.rotation), np.sin(room.rotation)
    turned = corners @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return turned + np.array(room.eye)


def _meets_box(corners: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    """Return whether a rectangle meets an axis-aligned box (separating axes; Gottschalk et al., SIGGRAPH 1996)."""
    across, up = corners[1] - corners[0], corners[3] - corners[0]
    axes = [*np.eye(3), np.cross(across, up)]
    axes += [np.cross(edge, axis) for edge in (across, up) for axis in np.eye(3)]
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    for axis in axes:
        along, reach = (corners - middle) @ axis, half @ np.abs(axis)
        if along.min() > reach or along.max() < -reach:
            return False
    return True
