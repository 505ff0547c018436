"""The inside of a vessel, as bodies in it find it: by profiles of a solid of revolution, by the mesh of another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol, Self

import numpy as np

from ...core.mesh import Mesh
from ..cavities.space import Space, space_of
from ..description.bodies import MeshVessel, Vessel
from ..profiles.clearance import clearance, floor_under

#: Points on a ball's lower side that are looked at, along each side of a square around it [1].
_BALL = 13
#: Directions in which a wall is measured [1], how much farther than the mean it is there at least where something that
#: leans is at rest in some directions alone [1], and how much less far than the farthest it may be [1].
_DIRECTIONS, _OUT_OF_ROUND, _AS_FAR = 360, 0.03, 0.01
#: Height over the floor at which the wall is measured where a foot stands [m]: above the rounding of most corners.
_FOOT = 8e-3

#: From distances from the axis and directions (n,) [m, rad] to the heights of the middles of balls there (n,) [m].
BallHeights = Callable[[np.ndarray, np.ndarray], np.ndarray]
#: A place on the wall: from a stream and a distance from the wall to a point (3,) [m].
WallPlace = Callable[[np.random.Generator, float], np.ndarray]


class Room(Protocol):
    """The inside of a vessel about a vertical axis; points are in the vessel's frame, but for `turned`."""

    @property
    def axis(self) -> np.ndarray:
        """Where the axis is, (2,) [m]."""
        ...

    @property
    def floor(self) -> float:
        """Height of the floor: on the axis, or its lowest place [m]."""
        ...

    @property
    def brim(self) -> float:
        """Height up to which it is closed around [m]."""
        ...

    @property
    def widest(self) -> float:
        """Largest distance of the inside from the axis [m]."""
        ...

    def narrowest(self, low: float, high: float) -> float:
        """Return the least distance of the wall from the axis between two heights [m]."""
        ...

    def clearance(self, points: np.ndarray, within: float = np.inf) -> np.ndarray:
        """Return the distance of points (k, 3) from the glass, negative in it, or inf where over `within` [m]."""
        ...

    def floor_under(self, places: np.ndarray, beyond: float) -> np.ndarray:
        """Return the height of the floor at places (k, 2), or a little beyond them from the axis; inf in the wall."""
        ...

    def ball_heights(self, radius: float, gap: float) -> BallHeights:
        """Return how high the middles of balls of a radius are that lie on the floor, a gap above it [m]."""
        ...

    def wall_below(self, level: float) -> WallPlace | None:
        """Return what draws places on the wall below a level [m], evenly over its area; None without a wall there."""
        ...

    def azimuth(self, part: float) -> float | None:
        """Return a direction in which something leans at rest, by a number in [0, 1) [rad]; None without one."""
        ...

    def turned(self, azimuth: float) -> Self:
        """Return the room as seen in a frame on its axis whose x axis has a direction [rad]."""
        ...


@dataclass(frozen=True, eq=False)
class RevolvedRoom:
    """The profiles of a vessel.

    Parameters
    ----------
    outer, inner : (n, 2) float64
        Rows (r, z) [m], from the axis to the rim's crown.
    """

    outer: np.ndarray
    inner: np.ndarray
    axis: np.ndarray = field(default_factory=lambda: np.zeros(2))

    @property
    def floor(self) -> float:
        """Height of the floor on the axis [m]."""
        return float(self.inner[0, 1])

    @property
    def brim(self) -> float:
        """Height of the rim's crown [m]."""
        return float(self.inner[-1, 1])

    @property
    def widest(self) -> float:
        """Largest inner radius [m]."""
        return float(self.inner[:, 0].max())

    def radius(self, height: float) -> float:
        """Return the inner radius at a height [m]."""
        return float(np.interp(height, self.inner[:, 1], self.inner[:, 0]))

    def narrowest(self, low: float, high: float) -> float:
        """Return the smallest inner radius between two heights [m]."""
        between = self.inner[(self.inner[:, 1] >= low) & (self.inner[:, 1] <= high), 0]
        return float(min([self.radius(low), self.radius(high), *between.tolist()]))

    def clearance(self, points: np.ndarray, within: float = np.inf) -> np.ndarray:
        """Return the distance of points from the glass [m]."""
        return clearance(self.outer, self.inner, points, within)

    def floor_under(self, places: np.ndarray, beyond: float) -> np.ndarray:
        """Return the height of the floor [m]."""
        return floor_under(self.inner, np.hypot(*places.T) + beyond)

    def ball_heights(self, radius: float, gap: float) -> BallHeights:
        """Return how high balls lie: over the floor at each place under them stands their lower side there."""
        r = np.linspace(0.0, self.widest, 64)
        dense = np.linspace(-1.0, 1.0, 41) * radius
        under = floor_under(self.inner, np.abs(r[:, None] + dense))
        height = (under + np.sqrt(np.maximum(radius**2 - dense**2, 0.0))).max(1) + gap
        return lambda distance, _: np.interp(distance, r, height)

    def wall_below(self, level: float) -> WallPlace | None:
        """Return what draws places on the wall."""
        inner = self.inner[self.inner[:, 1] < level]
        if len(inner) < 2:
            return None
        start, along = inner[:-1], np.diff(inner, axis=0)
        length = np.linalg.norm(along, axis=1)
        area = length * (start[:, 0] + 0.5 * along[:, 0])
        cumulative = np.cumsum(area) / area.sum()

        def place(rng: np.random.Generator, away: float) -> np.ndarray:
            k = min(int(np.searchsorted(cumulative, rng.random())), len(length) - 1)
            on = start[k] + rng.random() * along[k]
            inwards = np.array([-along[k, 1], along[k, 0]]) / max(length[k], 1e-12)
            r, z = on + away * inwards
            angle = rng.uniform(0.0, 2.0 * np.pi)
            return np.array([r * np.cos(angle), r * np.sin(angle), z])

        return place

    def azimuth(self, part: float) -> float:
        """Return any direction: all are the same."""
        return 2.0 * np.pi * part

    def turned(self, azimuth: float) -> Self:
        """Return itself."""
        return self


@dataclass(frozen=True, eq=False)
class MeshRoom:
    """The cavity of a vessel of any shape.

    Parameters
    ----------
    solid : Mesh
        The glass, with one cavity.
    direction : float, optional
        Of the x axis of the frame that points are in, which then is on the cavity's axis [rad]; without it they are in
        the vessel's frame.
    """

    solid: Mesh
    direction: float | None = None

    @property
    def space(self) -> Space:
        """The cavity, which is looked for only where something is to be put into it."""
        found = space_of(self.solid)
        assert found is not None
        return found

    @property
    def axis(self) -> np.ndarray:
        """Where the axis is [m]."""
        return self.space.axis if self.direction is None else np.zeros(2)

    @property
    def floor(self) -> float:
        """Height of the lowest place [m]."""
        return self.space.floor

    @property
    def brim(self) -> float:
        """Height of the lowest place of the rim [m]."""
        return self.space.brim

    @property
    def widest(self) -> float:
        """Largest distance of the inside from the axis [m]."""
        away = self.space.wall.corners[..., :2] - self.space.axis
        return float(np.sqrt((away**2).sum(-1).max()))

    def narrowest(self, low: float, high: float) -> float:
        """Return the least distance of the wall from the axis between two heights [m]."""
        heights, radii = self.space.wall.heights, self.space.radii
        between = radii[(heights >= low) & (heights <= high)]
        return float(min([*np.interp([low, high], heights, radii).tolist(), *between.tolist()]))

    def clearance(self, points: np.ndarray, within: float = np.inf) -> np.ndarray:
        """Return the distance of points from the glass [m]."""
        return self.space.clearance(np.column_stack([self._in_vessel(points[:, :2]), points[:, 2]]), within)

    def floor_under(self, places: np.ndarray, beyond: float) -> np.ndarray:
        """Return the height of the floor [m]."""
        from_axis = places - self.axis
        away = np.maximum(np.hypot(*from_axis.T), np.finfo(float).tiny)[:, None]
        outer = places + beyond * from_axis / away
        heights = [self.space.bottom_at(self._in_vessel(some)) for some in (places, outer)]
        return np.maximum(*heights)

    def ball_heights(self, radius: float, gap: float) -> BallHeights:
        """Return how high balls lie: over the floor at each place under them stands their lower side there."""
        side = np.linspace(-1.0, 1.0, _BALL) * radius
        under = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        under = under[np.hypot(*under.T) <= radius * (1.0 + 1e-9)]
        rise = np.sqrt(np.maximum(radius**2 - (under**2).sum(1), 0.0))

        def heights(distance: np.ndarray, angle: np.ndarray) -> np.ndarray:
            middles = np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=1) + self.axis
            places = (middles[:, None] + under).reshape(-1, 2)
            bottom = self.space.bottom_at(self._in_vessel(places)).reshape(len(middles), -1)
            return (bottom + rise).max(1) + gap

        return heights

    def wall_below(self, level: float) -> WallPlace | None:
        """Return what draws places on the wall."""
        corners = self.space.wall.corners
        corners = corners[corners[..., 2].max(1) < level]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normals, axis=1)
        if not area.sum() > 0.0:
            return None
        cumulative = np.cumsum(area) / area.sum()

        def place(rng: np.random.Generator, away: float) -> np.ndarray:
            k = min(int(np.searchsorted(cumulative, rng.random())), len(area) - 1)
            u, v = rng.random(2)
            u, v = (1.0 - u, 1.0 - v) if u + v > 1.0 else (u, v)
            a, b, c = corners[k]
            return a + u * (b - a) + v * (c - a) + away * normals[k] / max(area[k], 1e-30)

        return place

    def azimuth(self, part: float) -> float | None:
        """Return a direction: in one that is a little longer than those beside it, things cannot slide on.

        What leans between two opposite places of a wall has its middle lowest where these are farthest apart: in the
        corners of a square, along the longer axis of an oval, in a spout. In a round wall all directions are the same.
        """
        wall, angles = self.space.wall, 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        foot = max(self.floor + _FOOT, float(wall.heights[0]))
        sections = [wall.section(height, self.space.axis) for height in (float(wall.heights[-1]), foot)]
        if sections[0] is None or sections[1] is None:
            return None
        # It leans towards +x: its foot is on the other side.
        length = sections[0].radii(angles) + sections[1].radii(angles + np.pi)
        if np.ptp(length) <= _OUT_OF_ROUND * length.mean():
            return 2.0 * np.pi * part
        longest = (length >= np.roll(length, 1)) & (length > np.roll(length, -1))
        some = angles[longest & (length >= (1.0 - _AS_FAR) * length.max())]
        return float(some[int(part * len(some))])

    def turned(self, azimuth: float) -> Self:
        """Return the room in a frame on its axis."""
        return replace(self, direction=azimuth)

    def _in_vessel(self, places: np.ndarray) -> np.ndarray:
        if self.direction is None:
            return places
        c, s = np.cos(self.direction), np.sin(self.direction)
        return places @ np.array([[c, s], [-s, c]]) + self.space.axis


def room_of(vessel: Vessel | MeshVessel) -> Room | None:
    """Return the inside of a vessel; None where it has no cavity, or several of them."""
    if isinstance(vessel, Vessel):
        return RevolvedRoom(np.array(vessel.outer), np.array(vessel.inner))
    return MeshRoom(vessel.solid) if len(vessel.cavities) == 1 else None
