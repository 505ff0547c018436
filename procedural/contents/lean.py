"""How a straw, a spoon or a rod leans in a vessel: its foot in a corner of the floor, its shaft on the rim opposite.

All happens in one plane through the vessel's axis: the foot slides outwards until the wall stops it, and the shaft tips
over until it touches the rim. That is at rest where the centre of mass lies between both contacts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from ..profiles.clearance import along_edges
from .room import Room

#: Distance from the glass at rest [m]: that of objects and the table.
GAP = 1e-4
#: How much higher than its lowest place a foot may climb in the corner's rounding [m].
_CLIMB = 5e-4
#: Parts of the shaft beyond which its middle would pull it over the rim [1]: the centre of mass of a uniform one is at
#: a half, and a tenth of that is margin.
MOST_BEYOND = 0.9
#: Tilts from the vertical that are tried [rad]. Flatter ones slide.
_TILTS = (np.radians(1.0), np.radians(60.0))
#: Halvings in search of the tilt, to 0.03 degrees, and of the place [1].
_HALVINGS, _STEPS = 11, 12
#: Height of the foot's part [m]: a spoon's bowl is as long. And of its tip, which stands on the floor [m].
_FOOT, _TIP = 0.05, 5e-3
#: Distances of points on a shaft in search of where it meets the rim [m].
_COARSE, _FINE = 3e-3, 4e-4
#: Distance from the glass within which a shaft has room or not [m]. It is over `_COARSE`: where a shaft goes into the
#: wall, a point of it is in the wall and nearer to its surface than this.
_CLOSE = 4e-3
#: Distances from the axis that are tried before the search [1].
_PLACES = 24


@dataclass(frozen=True, eq=False)
class Leaning:
    """The pose of a leaning body, and where it meets the rim.

    Parameters
    ----------
    vessel_T_body : (4, 4) float64
        The body's z axis points up along its shaft; it leans in the room's x z plane towards +x.
    reach : float
        Distance along the shaft from the foot to where it meets the rim [m].
    """

    vessel_T_body: np.ndarray
    reach: float


def leaning(mesh: Mesh, room: Room) -> Leaning | None:
    """Return how a body leans in a vessel; None where it finds no rest.

    Parameters
    ----------
    mesh : Mesh
        Its shaft along z, its foot at z = 0 [m].
    room : Room
        The vessel, in the frame of the plane in which it leans.
    """
    points = mesh.vertices.astype(np.float64)
    foot, shaft = points[points[:, 2] < _FOOT], _shaft(points, mesh.faces)
    low, high = _TILTS
    if _shaft_room(foot, shaft, room, low) < GAP:
        return None
    for _ in range(_HALVINGS):
        tilt = 0.5 * (low + high)
        low, high = (tilt, high) if _shaft_room(foot, shaft, room, tilt) >= GAP else (low, tilt)
    pose = _pose(foot, room, low)
    if pose is None:
        return None
    if room.clearance(points @ pose[:3, :3].T + pose[:3, 3]).min() < 0.5 * GAP:
        return None
    free, reach = _nearest(shaft, room, pose, _CLOSE)
    return Leaning(pose, reach if np.isfinite(free) else _nearest(shaft, room, pose)[1])


def _shaft(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the edges above the foot, on the side that meets the rim, (n, 2, 3) [m]."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], -1).reshape(-1, 2), axis=1)
    edges = points[np.unique(ends, axis=0)]
    edges = edges[(edges[..., 2] >= _FOOT).any(1)]
    across, along = np.moveaxis(np.abs(edges[:, 1] - edges[:, 0]), -1, 0)[0], np.abs(np.diff(edges[..., 2])[:, 0])
    # Those along the shaft: points between them are as near to them as the shaft's rings are fine.
    return edges[(edges[..., 0] > 0.6 * edges[..., 0].max()).all(1) & (across < 0.05 * along)]


def _nearest(shaft: np.ndarray, room: Room, pose: np.ndarray, within: float = np.inf) -> tuple[float, float]:
    """Return the least distance of the shaft from the glass [m], and how high on the shaft that is [m].

    The distance may be inf, and the height any, where it is over `within`. The place is sought coarsely, and around the
    place that is found finely: rims are about a millimetre round.
    """
    points, place = along_edges(shaft, _COARSE), 0.0
    free = np.full(1, np.inf)
    for step in (_COARSE, _FINE):
        if step == _FINE:
            low, high = place - 3.0 * _COARSE, place + 3.0 * _COARSE
            points = along_edges(shaft, step)
            points = points[(points[:, 2] > low) & (points[:, 2] < high)]
        free = room.clearance(points @ pose[:3, :3].T + pose[:3, 3], within)
        place = float(points[int(free.argmin()), 2])
    return float(free.min()), place


def _shaft_room(foot: np.ndarray, shaft: np.ndarray, room: Room, tilt: float) -> float:
    """Return the least distance of the shaft from the glass [m] where the foot stands in its corner; -inf: nowhere."""
    pose = _pose(foot, room, tilt)
    return -np.inf if pose is None else _nearest(shaft, room, pose, _CLOSE)[0]


def _pose(foot: np.ndarray, room: Room, tilt: float) -> np.ndarray | None:
    """Return the pose at a tilt in which the foot is as far out as the wall lets it be; None where it has no room."""
    c, s = np.cos(tilt), np.sin(tilt)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    turned = foot @ turn.T
    tip = turned[foot[:, 2] < _TIP]
    lowest = _height(tip, room, 0.0)
    if not np.isfinite(lowest):  # the foot is wider than the vessel
        return None
    places = np.linspace(0.0, room.widest, _PLACES)
    free = [place for place in places.tolist() if _height(turned, room, place) <= lowest + _CLIMB]
    if not free:
        return None
    near, far = free[-1], free[-1] + float(places[1])
    for _ in range(_STEPS):
        out = 0.5 * (near + far)
        near, far = (out, far) if _height(turned, room, out) <= lowest + _CLIMB else (near, out)
    best = _height(turned, room, near)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, (-near, 0.0, best)
    return pose


def _height(turned: np.ndarray, room: Room, out: float) -> float:
    """Return the least height of the foot where it clears the floor and the wall, at a distance from the axis [m]."""
    places = turned[:, :2] - np.array([out, 0.0])
    return float((room.floor_under(places, GAP) - turned[:, 2]).max()) + GAP
