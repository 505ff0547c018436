"""Where rays meet meshes, and which points closed meshes hold, by formulas of their own."""

from __future__ import annotations

import numpy as np

from glassware.core.mesh import Mesh


def hits(mesh: Mesh, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances at which a ray meets a mesh, and whether it comes from the front (Moeller and Trumbore 1997)."""
    a, b, c = np.moveaxis(mesh.vertices.astype(np.float64)[mesh.faces], 1, 0)
    normal = np.cross(b - a, c - a)
    slope = normal @ direction
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = ((a - origin) * normal).sum(1) / slope
        across = np.cross(origin - a, direction)
        u = -((c - a) * across).sum(1) / slope
        v = ((b - a) * across).sum(1) / slope
    hit = (slope != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)
    return distance[hit], slope[hit] < 0.0


def winding(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Winding number of a closed mesh about points: its solid angle over 4 pi (Van Oosterom and Strackee 1983)."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    found = []
    for point in points:
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        volume = (a * np.cross(b, c)).sum(1)
        corner = la * lb * lc + (a * b).sum(1) * lc + (a * c).sum(1) * lb + (b * c).sum(1) * la
        found.append(np.arctan2(volume, corner).sum() / (2.0 * np.pi))
    return np.round(found, 6)
