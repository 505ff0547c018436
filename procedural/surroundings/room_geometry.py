"""Straight rays in a box-shaped room with boxes in it.

Box 0 is the room, seen from inside; the others stand in it, seen from outside. Face 6 b + 2 a + s of box b is square to
axis a, on the larger (s = 0) or the smaller (s = 1) side: +x -x +y -y ceiling floor for the room. A face's own
coordinates are the two other axes in ascending order [m].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.surroundings import RoomEnvironment

#: The face of the room that each name of a wall stands for.
WALL_FACES = {"+x": 0, "-x": 1, "+y": 2, "-y": 3, "ceiling": 4}
#: The two axes along a face, by the axis that it is square to.
ALONG = np.array([[1, 2], [0, 2], [0, 1]])
# A surface is left behind after this far along a ray [m].
_CLEAR = 1e-3


@dataclass(frozen=True, eq=False)
class Boxes:
    """The room and its blocks."""

    lower: np.ndarray  #: (n, 3) float32 [m]
    upper: np.ndarray  #: (n, 3) float32 [m]
    reflectance: np.ndarray  #: (6 n, 3) float32, by face


def boxes_of(room: RoomEnvironment) -> Boxes:
    """Return the boxes of a room's description."""
    lower = [(0.0, 0.0, 0.0), *(block.lower for block in room.blocks)]
    upper = [room.size, *(block.upper for block in room.blocks)]
    faces = [*room.wall_colours, *(block.colour for block in room.blocks for _ in range(6))]
    return Boxes(*(np.array(values, dtype=np.float32) for values in (lower, upper, faces)))


def cast(boxes: Boxes, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what rays from inside the room meet first.

    Parameters
    ----------
    boxes : Boxes
        The room.
    origins : (n, 3) or (1, 3) float32
        Points in the room [m].
    directions : (n, 3) float32
        Unit vectors.

    Returns
    -------
    faces : (n,) int64
        The face met.
    points : (n, 3) float32
        Where [m].
    """
    inverse, growing = _inverse(directions), directions > 0.0
    exits = (np.where(growing, boxes.upper[0], boxes.lower[0]) - origins) * inverse
    axis, nearest = np.argmin(exits, axis=1), _least(exits)
    faces = 2 * axis + ~_pick(growing, axis)
    for box in range(1, len(boxes.lower)):
        near = _may_meet(boxes, box, origins, directions)
        enter, leave = _slabs(boxes, box, origins if len(origins) == 1 else origins[near], inverse[near])
        first = -_least(-enter)
        met = np.flatnonzero((first > _CLEAR) & (first < _least(leave)) & (first < nearest[near]))
        hit, axis = near[met], np.argmax(enter[met], axis=1)
        nearest[hit] = first[met]
        # A ray that grows along the axis meets the smaller side.
        faces[hit] = 6 * box + 2 * axis + _pick(growing[hit], axis)
    return faces, origins + directions * nearest[:, None]


def blocked(boxes: Boxes, origins: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return whether a block stands between two points, (n, 3) and (n, 3) or (1, 3) float32 [m] -> (n,) bool."""
    offset = ends - origins
    inverse, backward = _inverse(offset), offset / -np.linalg.norm(offset, axis=1, keepdims=True)
    found = np.zeros(len(inverse), dtype=bool)
    for box in range(1, len(boxes.lower)):
        near = _may_meet(boxes, box, ends, backward)
        enter, leave = _slabs(boxes, box, origins[near], inverse[near])
        first, last = -_least(-enter), _least(leave)
        found[near] |= (first < last) & (last > _CLEAR) & (first < 1.0 - _CLEAR)
    return found


def face_axis(faces: np.ndarray) -> np.ndarray:
    """Return the axis that each face is square to."""
    return (faces % 6) // 2


def face_coordinates(faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points in their faces' own coordinates, (n, 2) float32 [m]."""
    return np.take_along_axis(points, ALONG[face_axis(faces)], axis=1)


def in_rectangle(coordinates: np.ndarray, centre: tuple[float, float], size: tuple[float, float]) -> np.ndarray:
    """Return whether points in a face's own coordinates, (n, 2) [m], lie in a rectangle on it, (n,) bool."""
    across = np.abs(coordinates[:, 0] - np.float32(centre[0])) <= np.float32(0.5 * size[0])
    return across & (np.abs(coordinates[:, 1] - np.float32(centre[1])) <= np.float32(0.5 * size[1]))


def face_frames(boxes: Boxes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return corner, size and normal of every face: (f, 2) and (f, 2) own coordinates [m], (f, 3) world."""
    faces = np.arange(6 * len(boxes.lower))
    along = ALONG[face_axis(faces)]
    corner = np.take_along_axis(boxes.lower[faces // 6], along, axis=1)
    size = np.take_along_axis(boxes.upper[faces // 6], along, axis=1) - corner
    outward = np.where(faces % 2 == 0, 1.0, -1.0) * np.where(faces < 6, -1.0, 1.0)
    return corner, size, (np.eye(3)[face_axis(faces)] * outward[:, None]).astype(np.float32)


def face_points(boxes: Boxes, faces: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the points in space of own coordinates on faces, (n,) int and (n, 2) -> (n, 3) float32 [m]."""
    axis = face_axis(faces)
    plane = np.where((faces % 2 == 0)[:, None], boxes.upper[faces // 6], boxes.lower[faces // 6])
    points = np.take_along_axis(plane, axis[:, None], axis=1).repeat(3, axis=1)
    np.put_along_axis(points, ALONG[axis], coordinates.astype(np.float32), axis=1)
    return points


def _slabs(boxes: Boxes, box: int, origins: np.ndarray, inverse: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays enter and leave each of a box's three slabs (Kay and Kajiya 1986)."""
    low, high = (boxes.lower[box] - origins) * inverse, (boxes.upper[box] - origins) * inverse
    return np.minimum(low, high), np.maximum(low, high)


def _may_meet(boxes: Boxes, box: int, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the numbers of the rays that may meet a box: from one origin, those in the cone of its bounding sphere."""
    offset = 0.5 * (boxes.lower[box] + boxes.upper[box]) - origins[0]
    sine = 0.5 * np.linalg.norm(boxes.upper[box] - boxes.lower[box]) / max(np.linalg.norm(offset), _CLEAR)
    if len(origins) > 1 or sine >= 1.0:
        return np.arange(len(directions))
    # float32 directions have cosines to 1e-6.
    cosine = np.sqrt(1.0 - sine**2) - 1e-5
    return np.flatnonzero(directions @ (offset / np.linalg.norm(offset)) >= cosine)


def _pick(values: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the value of each row at its axis, (n, 3) and (n,) int -> (n,)."""
    return np.take_along_axis(values, axis[:, None], axis=1)[:, 0]


def _least(values: np.ndarray) -> np.ndarray:
    # Far faster than a reduction along an axis of three.
    return np.minimum(np.minimum(values[:, 0], values[:, 1]), values[:, 2])


def _inverse(directions: np.ndarray) -> np.ndarray:
    # A direction square to an axis gets a huge, finite inverse instead of a division by 0.
    tiny = np.float32(1e-12)
    return 1.0 / np.where(np.abs(directions) < tiny, np.where(directions > 0.0, tiny, -tiny), directions)
