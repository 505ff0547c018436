"""Horizontal sections of the wall around a cavity: how large they are, and which of them are circles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .find import Hollow

#: Sections of a cavity [1]: 0.4 mm apart in a glass of 10 cm.
SECTIONS = 256
#: Largest distance of a circle's section from the circle of the same area [1 of its radius]: a ring of 12 edges is off
#: by 2.3 % at its corners. And of the middles of sections that belong to one solid of revolution.
ROUND, COAXIAL = 0.025, 0.01
#: Highest section [1 of the cavity's depth]: faces above it may belong to the rim.
WALL_TOP = 0.99


@dataclass(frozen=True, eq=False)
class Section:
    """A closed line around a point, which each ray from there meets once.

    Parameters
    ----------
    angles : (n,) float64
        Of the first ends of its segments, rising, within one turn [rad].
    first, ends : (n, 2) float64
        Ends of the segments, relative to the point [m].
    """

    angles: np.ndarray
    first: np.ndarray
    ends: np.ndarray

    def radii(self, angles: np.ndarray) -> np.ndarray:
        """Return the distances of the line from the point in directions (k,) [m]."""
        turned = (angles - self.angles[0]) % (2.0 * np.pi)
        place = np.searchsorted(self.angles - self.angles[0], turned, side="right") - 1
        a, along = self.first[place], self.ends[place] - self.first[place]
        u = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        cross = _cross(u, along)
        return _cross(a, along) / np.where(cross == 0.0, np.finfo(float).tiny, cross)


@dataclass(frozen=True, eq=False)
class Wall:
    """The wall around a cavity.

    Parameters
    ----------
    heights : (n,) float64
        Of its sections, rising [m].
    radii : (n,) float64
        Of circles of the same areas [m].
    centres : (n, 2) float64
        Middles of the sections [m].
    round : (n,) bool
        Which of the sections are circles within `ROUND`.
    corners : (m, 3, 3) float64
        Its triangles [m].
    """

    heights: np.ndarray
    radii: np.ndarray
    centres: np.ndarray
    round: np.ndarray
    corners: np.ndarray

    def is_round(self, low: float, high: float) -> bool:
        """Return whether the wall is one of revolution between two heights [m]."""
        first, last = np.searchsorted(self.heights, [low, high])
        near = slice(max(first - 1, 0), last + 1)
        if not self.round[near].all():
            return False
        return bool((np.ptp(self.centres[near], axis=0) <= COAXIAL * self.radii[near].min()).all())

    def section(self, height: float, centre: np.ndarray) -> Section | None:
        """Return the section at a height [m]; None where it is no line that each ray from the centre meets once."""
        first, ends, _ = _segments(self.corners, np.array([height]))
        first, ends = first - centre, ends - centre
        turn = _turns(first, ends)
        if not len(turn) or abs(turn.sum()) < 1.9 * np.pi or abs(turn.sum()) > 2.1 * np.pi:
            return None
        if turn.sum() < 0.0:
            first, ends, turn = ends, first, -turn
        kept = turn > 0.0  # segments of no length turn by nothing
        if (turn < -1e-9).any() or not kept.any():
            return None
        first, ends = first[kept], ends[kept]
        angles = np.arctan2(first[:, 1], first[:, 0])
        order = np.argsort(angles)
        return Section(angles[order], first[order], ends[order])


def wall_of(corners: np.ndarray, hollow: Hollow) -> Wall:
    """Return the wall around a cavity.

    Parameters
    ----------
    corners : (m, 3, 3) float64
        The faces that a liquid in it touches up to `WALL_TOP` of its depth [m].
    hollow : Hollow
        The cavity.
    """
    top = hollow.floor + WALL_TOP * (hollow.brim - hollow.floor)
    heights = hollow.floor + (np.arange(SECTIONS) + 0.5) / SECTIONS * (top - hollow.floor)
    first, ends, level = _segments(corners, heights)
    area2, centres = _areas(first, ends, level)
    radii = np.sqrt(np.abs(area2) / (2.0 * np.pi))
    first, ends = first - centres[level], ends - centres[level]
    distance = np.hypot(*ends.T) / np.maximum(radii, np.finfo(float).tiny)[level]
    middle = np.hypot(*(0.5 * (first + ends)).T) / np.maximum(radii, np.finfo(float).tiny)[level]
    away = np.zeros(SECTIONS)
    np.maximum.at(away, level, np.maximum(np.abs(distance - 1.0), np.abs(middle - 1.0)))
    once = np.abs(np.abs(np.bincount(level, _turns(first, ends), SECTIONS)) - 2.0 * np.pi) < 0.1
    return Wall(heights, radii, centres, (away <= ROUND) & once & (radii > 0.0), corners)


def least_radii(wall: Wall, axis: np.ndarray) -> np.ndarray:
    """Return how near the wall comes to a vertical axis (2,) at each of its heights, (n,) [m]."""
    first, ends, level = _segments(wall.corners, wall.heights)
    start, along = first - axis, ends - first
    t = -np.einsum("ij,ij->i", start, along) / np.maximum((along**2).sum(1), np.finfo(float).tiny)
    distance = np.hypot(*(start + np.clip(t, 0.0, 1.0)[:, None] * along).T)
    found = np.full(len(wall.heights), np.inf)
    np.minimum.at(found, level, distance)
    return found


def _segments(corners: np.ndarray, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return both ends (k, 2) of the lines in which planes cut triangles, and the plane's number, (k,).

    Lines run so that the faces' normals point to the same side of all of them.
    """
    z = corners[..., 2]
    low, high = (np.searchsorted(heights, end, side="right") for end in (z.min(1), z.max(1)))
    counts = high - low
    face = np.repeat(np.arange(len(corners)), counts)
    level = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts) + low[face]
    height = heights[level]
    below = z[face] < height[:, None]
    alone_low = below.sum(1) == 1
    alone = np.where(alone_low, below.argmax(1), (~below).argmax(1))
    p, q, r = (corners[face, (alone + k) % 3] for k in range(3))
    one, other = _at_height(p, q, height), _at_height(p, r, height)
    flip = alone_low[:, None]
    return np.where(flip, one, other), np.where(flip, other, one), level


def _at_height(a: np.ndarray, b: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return where edges reach heights, (k, 2), the same for both faces of an edge."""
    low = (a[:, 2] <= b[:, 2])[:, None]
    foot, head = np.where(low, a, b), np.where(low, b, a)
    rise = head[:, 2] - foot[:, 2]
    along = (height - foot[:, 2]) / np.where(rise == 0.0, 1.0, rise)
    return foot[:, :2] + along[:, None] * (head - foot)[:, :2]


def _areas(first: np.ndarray, ends: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return twice the area of each section, and its centroid."""
    cross = _cross(first, ends)
    area2 = np.bincount(level, cross, SECTIONS)
    size = np.where(area2 == 0.0, 1.0, area2)
    sums = [np.bincount(level, cross * (first + ends)[:, k], SECTIONS) / (3.0 * size) for k in range(2)]
    return area2, np.stack(sums, axis=1)


def _turns(first: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return by how much each segment turns about the origin [rad]."""
    return np.arctan2(_cross(first, ends), np.einsum("ij,ij->i", first, ends))


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
