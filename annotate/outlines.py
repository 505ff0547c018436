"""The lines of a vessel: the edge of its mouth, and where its liquids end at the wall."""

from __future__ import annotations

import numpy as np

from ..core.mesh import Mesh
from ..procedural.cavities.cut import welded
from ..procedural.description.scene import MeshVessel, SceneObject, Vessel

#: Most points of a line [1]: on a circle the chords of 64 stay within 0.12 % of its radius.
MOST_POINTS = 64
#: A mouth of a vessel from a file is cut below the brim by this fraction of the cavity's depth [1]: rims are rounded,
#: and at the brim itself the edge is open at a spout.
_BELOW_BRIM = 0.02


def openings(item: SceneObject) -> tuple[np.ndarray, ...]:
    """Return the mouths of an object as closed polygons in its frame, each (n, 3) float64 [m]; none where it has none.

    The mouth of a vessel is the circle on the crown of its rim. That of a vessel from a file is the outline of each
    cavity just below its brim.
    """
    if isinstance(item, Vessel):
        radius, height = item.inner[-1]
        turn = 2.0 * np.pi * np.arange(MOST_POINTS) / MOST_POINTS
        return (np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(MOST_POINTS, height)], axis=1),)
    if isinstance(item, MeshVessel):
        heights = [hollow.brim - _BELOW_BRIM * (hollow.brim - hollow.floor) for hollow in item.cavities]
        found = (line for height in heights for line in holes_at(item.solid, height))
        return tuple(_thinned(line) for line in found)
    return ()


def fill_lines(item: SceneObject) -> tuple[np.ndarray, ...]:
    """Return where liquids end at the wall, as closed polygons in the object's frame, each (n, 3) float64 [m].

    They are the edges of the liquids' surfaces: the contact lines, where the meniscus meets the wall.
    """
    parts = getattr(item, "interfaces", ())
    lines = (line for part in parts if part.part == "liquid_surface" for line in boundary(part.mesh))
    return tuple(_thinned(line) for line in lines)


def boundary(mesh: Mesh) -> list[np.ndarray]:
    """Return the closed lines along the edges that only one face of a mesh has, each (n, 3) float64 [m]."""
    places, index = welded(mesh)
    faces = index[mesh.faces].astype(np.int64)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys, back = start * len(places) + end, end * len(places) + start
    free = ~np.isin(keys, back) & (start != end)
    return [places[ring] for ring in _rings(np.stack([start[free], end[free]], axis=1))]


def holes_at(solid: Mesh, height: float) -> list[np.ndarray]:
    """Return the outlines of the holes in the horizontal section of a closed solid, each (n, 3) float64 [m].

    Faces that a plane crosses give segments with the solid to their left, so outlines of the solid run
    counter-clockwise, and those of holes in it clockwise.
    """
    places, index = welded(solid)
    faces, above = index[solid.faces].astype(np.int64), places[:, 2] > height
    crossed = faces[np.isin(above[faces].sum(axis=1), (1, 2))]
    lone = above[crossed].sum(axis=1) == 1
    # The corner that is alone on its side comes first: the other two are then crossed from it.
    first = np.where(lone[:, None] == above[crossed], 1, 0).argmax(axis=1)
    a, b, c = (crossed[np.arange(len(crossed)), (first + step) % 3] for step in range(3))
    edges = [np.sort(np.stack([a, other], axis=1), axis=1) for other in (b, c)]
    keys = np.stack([edge[:, 0] * len(places) + edge[:, 1] for edge in edges], axis=1)
    # Looking from outside, faces turn counter-clockwise: above the plane their lone corner has the solid on one side.
    keys = np.where(lone[:, None], keys, keys[:, ::-1])
    names, numbers = np.unique(keys, return_inverse=True)
    low, high = places[names // len(places)], places[names % len(places)]
    points = low + (high - low) * ((height - low[:, 2]) / (high[:, 2] - low[:, 2]))[:, None]
    rings = [points[ring] for ring in _rings(numbers.reshape(-1, 2))]
    return [ring for ring in rings if _area(ring) < 0.0]


def _rings(segments: np.ndarray) -> list[np.ndarray]:
    """Return the closed lines of directed segments, (m, 2), as numbers of their points, each point once."""
    after, rings = dict(segments.tolist()), []
    while after:
        start, point = next(iter(after.items()))
        ring = [start]
        del after[start]
        while point != start and point in after:
            ring.append(point)
            point = after.pop(point)
        if point == start:
            rings.append(np.array(ring))
    return rings


def _area(ring: np.ndarray) -> float:
    """Return the area of a polygon seen from above, (n, 3) [m^2]; negative where it runs clockwise."""
    x, y = ring[:, 0], ring[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _thinned(line: np.ndarray) -> np.ndarray:
    """Return at most `MOST_POINTS` points of a closed line, evenly spaced in its order."""
    if len(line) <= MOST_POINTS:
        return line
    return line[np.linspace(0, len(line), MOST_POINTS, endpoint=False).astype(int)]
