"""Convex pieces of a plane section: cuts through the deepest notch until none is deeper than a tolerance."""

from __future__ import annotations

import numpy as np

#: Cuts of a piece of a piece, and so on [1]; a section of a vessel needs 6 or 7. Beyond it a piece is taken as it is.
MOST_CUTS = 16
#: Half the side of the square that stands for a half plane [m]: far beyond every section.
_FAR = 10.0
#: Pieces thinner than this are rounding of a cut [m].
_SLIVER = 1e-7


def convex_pieces(outline: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Return convex polygons that cover a polygon, and nothing that is farther than a tolerance from it.

    Parameters
    ----------
    outline : (n, 2) float
        Counter-clockwise simple polygon [m].
    tolerance : float
        Deepest notch that a piece's hull may close [m].

    Returns
    -------
    list of (k, 2) float64
        Counter-clockwise; together they contain the polygon.
    """
    found: list[np.ndarray] = []
    waiting = [(np.asarray(outline, dtype=np.float64), 0)]
    while waiting:
        polygon, cuts = waiting.pop()
        depth, notch, bridge = _deepest_notch(polygon)
        if depth <= tolerance or cuts == MOST_CUTS:
            found.append(hull(polygon))
            continue
        waiting += [(part, cuts + 1) for part in _cut(polygon, notch, bridge)]
    return found


def hull(points: np.ndarray) -> np.ndarray:
    """Return the convex hull of points of a plane, (k, 2), counter-clockwise."""
    from scipy.spatial import ConvexHull  # here, as it takes a third of a second to load

    return points[ConvexHull(points).vertices]


def coarser(polygon: np.ndarray, tolerance: float) -> np.ndarray:
    """Return a convex polygon with fewer corners around another, nowhere farther from it than a tolerance [m].

    Its shortest edges go first: their neighbours are prolonged until they meet.
    """
    points = polygon
    while len(points) > 4:
        before, start, end, after = (np.roll(points, shift, axis=0) for shift in (1, 0, -1, -2))
        along, back, edge = start - before, end - after, end - start
        turn = along[:, 0] * back[:, 1] - along[:, 1] * back[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (edge[:, 0] * back[:, 1] - edge[:, 1] * back[:, 0]) / turn
            corner = start + reach[:, None] * along
            away = np.abs((corner - start)[:, 0] * edge[:, 1] - (corner - start)[:, 1] * edge[:, 0])
            away /= np.hypot(*edge.T)
        meets = (reach > 0.0) & np.isfinite(away) & (corner[:, 0] >= polygon[:, 0].min())
        meets &= ((corner - end) * -back).sum(1) <= 0.0
        away = np.where(meets, away, np.inf)
        first = int(away.argmin())
        if away[first] > tolerance:
            break
        kept = points.copy()
        kept[first] = corner[first]
        points = np.delete(kept, (first + 1) % len(points), axis=0)
    return points


def area(polygon: np.ndarray) -> float:
    """Return the signed area of a polygon (n, 2); counter-clockwise ones count positive [m^2]."""
    after = np.roll(polygon, -1, axis=0)
    return 0.5 * float((polygon[:, 0] * after[:, 1] - after[:, 0] * polygon[:, 1]).sum())


def _deepest_notch(polygon: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the depth of the deepest notch [m], its deepest point, and the direction of the hull's edge over it."""
    from scipy.spatial import ConvexHull

    count, corners = len(polygon), np.sort(ConvexHull(polygon).vertices)
    best, point, direction = 0.0, polygon[0], np.array([1.0, 0.0])
    for start, end in zip(corners, np.roll(corners, -1), strict=True):
        inner = np.arange(start + 1, end if end > start else end + count) % count
        along = polygon[end] - polygon[start]
        length = float(np.hypot(*along))
        if not len(inner) or length == 0.0:
            continue
        offset = polygon[inner] - polygon[start]
        depth = np.abs(offset[:, 0] * along[1] - offset[:, 1] * along[0]) / length
        if depth.max() > best:
            best, point, direction = float(depth.max()), polygon[inner[depth.argmax()]], along / length
    return best, point, direction


def _cut(polygon: np.ndarray, point: np.ndarray, normal: np.ndarray) -> list[np.ndarray]:
    """Return the parts of a polygon on both sides of the line through a point, across a direction."""
    from manifold3d import CrossSection

    whole, across = CrossSection([polygon]), np.array([-normal[1], normal[0]])
    parts = []
    for side in (-1.0, 1.0):
        far = side * _FAR * normal
        half = np.array([point - _FAR * across, point + _FAR * across, point + _FAR * across + far])
        half = np.concatenate([half, [point - _FAR * across + far]])
        square = CrossSection([half if area(half) > 0.0 else half[::-1]])
        for part in (whole ^ square).decompose():
            outline = np.array(part.to_polygons()[0], dtype=np.float64)
            if len(outline) >= 3 and np.ptp(outline, axis=0).min() > _SLIVER and area(outline) > _SLIVER**2:
                parts.append(outline)
    return parts
