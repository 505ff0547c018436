"""Closed solids with texture coordinates in metres: lofts, tubes, sheets, slabs with holes, solids of revolution."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...core.mesh import Mesh
from ..props.mesh_files import box_mapped
from ..props.normals import CREASE, creased
from ..props.revolution import Piece, revolve


def finished(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray | None = None, crease: float = CREASE) -> Mesh:
    """Return a mesh with shading normals; without texture coordinates, they are projected from six sides [m].

    Positions are rounded to the mesh's float32 first, and triangles with two corners at one place are left out.
    """
    vertices = vertices.astype(np.float32).astype(np.float64) + 0.0
    corners = vertices[faces]
    faces = faces[~np.any([np.all(corners[:, i] == corners[:, (i + 1) % 3], axis=1) for i in range(3)], axis=0)]
    vertices, faces, normals, uv = creased(vertices, faces, uv, crease)
    mesh = Mesh("part", vertices, faces, normals, uv)
    return mesh if uv is not None else projected(mesh)


def projected(mesh: Mesh) -> Mesh:
    """Return a mesh with texture coordinates projected from six sides, by the dominant axis of each face [m]."""
    mapped = box_mapped(mesh)
    assert mapped.uv is not None
    return Mesh(mesh.name, mapped.vertices, mapped.faces, mapped.normals, mapped.uv * np.ptp(mesh.bounds, axis=0).max())


def loft(rings: np.ndarray, crease: float = CREASE) -> Mesh:
    """Return the solid through closed rings of points, with flat ends.

    Parameters
    ----------
    rings : (n, m, 3) float
        n rings of m points each [m], counter-clockwise seen from the last ring.
    crease : float
        Largest angle between faces that are shaded as one surface [rad].

    Returns
    -------
    Mesh
        u runs around each ring and v along the first points of the rings [m].
    """
    count, sides, _ = rings.shape
    closed = np.concatenate([rings, rings[:, :1]], axis=1)
    around = np.cumsum(np.linalg.norm(np.diff(closed, axis=1), axis=2), axis=1)
    along = np.cumsum([0.0, *np.linalg.norm(np.diff(rings.mean(1), axis=0), axis=1)])
    # One scale all along: the longest ring's, so that seams fit.
    u = np.concatenate([[0.0], around[np.argmax(around[:, -1])]])
    uv = np.stack(np.broadcast_arrays(u[None], along[:, None]), -1)
    first = (np.arange(count - 1)[:, None] * (sides + 1) + np.arange(sides)).reshape(-1)
    faces = [
        np.stack([first, first + 1, first + sides + 2], 1),
        np.stack([first, first + sides + 2, first + sides + 1], 1),
    ]
    vertices, coordinates, base = [closed.reshape(-1, 3)], [uv.reshape(-1, 2)], closed.size // 3
    for ring, turned in ((rings[0], True), (rings[-1], False)):
        middle = ring.mean(0)
        plane = _flattened(ring - middle)
        vertices += [ring, middle[None]]
        coordinates += [plane, np.zeros((1, 2))]
        index = np.arange(sides)
        fan = np.stack([index, (index + 1) % sides, np.full(sides, sides)], 1) + base
        faces.append(fan[:, ::-1] if turned else fan)
        base += sides + 1
    return finished(np.concatenate(vertices), np.concatenate(faces), np.concatenate(coordinates), crease)


def tube(path: np.ndarray, section: np.ndarray | float, up: Sequence[float] = (0.0, 0.0, 1.0), sides: int = 10) -> Mesh:
    """Return a solid that follows a path.

    Parameters
    ----------
    path : (n, 3) float
        Points of its middle line [m].
    section : float, (n,), (m, 2) or (n, m, 2) float
        Radius, or outline counter-clockwise in the plane of (side, up) [m]; one for all points, or one for each.
    up : (x, y, z)
        What the outline's second axis is near to at the first point; further on it turns no more than it has to.
    sides : int
        Points of a round section.
    """
    outline = np.asarray(section, float)
    if outline.ndim < 2:
        turn = 2 * np.pi * np.arange(sides) / sides
        circle = np.stack([np.cos(turn), np.sin(turn)], 1)
        outline = np.broadcast_to(outline, len(path))[:, None, None] * circle
    outline = np.broadcast_to(outline, (len(path), *outline.shape[-2:]))
    side, upward = _frames(path, np.asarray(up, float))
    return loft(path[:, None] + outline[..., :1] * side[:, None] + outline[..., 1:] * upward[:, None])


def sheet(
    top: np.ndarray, bottom: np.ndarray, present: np.ndarray | None = None, crease: float = np.radians(50.0)
) -> Mesh:
    """Return the solid between two surfaces over one grid.

    Parameters
    ----------
    top, bottom : (n, m, 3) float
        Points of the grid on both surfaces [m]; seen from above, the first axis runs along x and the second along y.
    present : (n - 1, m - 1) bool, optional
        Cells that are there; by default all.
    crease : float
        Largest angle between faces that are shaded as one surface [rad].
    """
    rows, columns, _ = top.shape
    present = np.ones((rows - 1, columns - 1), bool) if present is None else present
    i, j = np.nonzero(present)
    a = i * columns + j
    b, c, d = a + columns, a + columns + 1, a + 1
    upper = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    edges = np.concatenate([np.stack(edge, 1) for edge in ((a, b), (b, c), (c, d), (d, a))])
    forth, back = edges[:, 0] * top.size + edges[:, 1], edges[:, 1] * top.size + edges[:, 0]
    p, q = edges[~np.isin(forth, back)].T  # the border
    low = rows * columns
    walls = np.concatenate([np.stack([p, p + low, q + low], 1), np.stack([p, q + low, q], 1)])
    return finished(
        np.concatenate([top.reshape(-1, 3), bottom.reshape(-1, 3)]),
        np.concatenate([upper, upper[:, ::-1] + low, walls]),
        crease=crease,
    )


def slab(contours: Sequence[np.ndarray], height: float, bevel: float = 0.0) -> Mesh:
    """Return an upright prism over an outline with holes, centred at z = 0, with bevelled edges.

    Parameters
    ----------
    contours : sequence of (k, 2) float
        The outline counter-clockwise, holes clockwise [m].
    height : float
        Height [m].
    bevel : float
        Width of the bevel at the edges [m]; narrower where the outline has no room for it.
    """
    ends = np.cumsum([0, *(len(contour) for contour in contours)])
    bevel, cap = _bevelled_cap(contours, bevel)
    levels = [(-height / 2, bevel), (-height / 2 + bevel, 0.0), (height / 2 - bevel, 0.0), (height / 2, bevel)]
    levels = levels if bevel else levels[::3]
    rings = [[np.column_stack([_inset(c, by), np.full(len(c), z)]) for c in contours] for z, by in levels]
    vertices, count = np.concatenate([ring for level in rings for ring in level]), int(ends[-1])
    faces = [cap[:, ::-1], cap + (len(levels) - 1) * count]
    for start, end in itertools.pairwise(ends):
        here = np.arange(start, end)
        after = np.roll(here, -1)
        for level in range(len(levels) - 1):
            a, b = here + level * count, after + level * count
            faces += [np.stack([a, b, b + count], 1), np.stack([a, b + count, a + count], 1)]
    return finished(vertices, np.concatenate(faces), crease=np.radians(30.0))


def _bevelled_cap(contours: Sequence[np.ndarray], bevel: float) -> tuple[float, np.ndarray]:
    """Return the widest bevel, this one or a half or a quarter of it, whose inset outline does not cross itself.

    And the triangles of that outline, which all face up, (t, 3) int.
    """
    import manifold3d

    for width in (bevel, bevel / 2, bevel / 4, 0.0):
        parts = [_inset(contour, width) for contour in contours]
        cap, flat = np.asarray(manifold3d.triangulate(parts), np.int64), np.concatenate(parts)
        a, b, c = (flat[cap[:, k]] for k in range(3))
        twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        # Triangles without area join points on one line.
        if twice.min() > -1e-6 * twice.max():
            return width, cap
    raise ValueError("expected an outline that does not cross itself, found one that does")


def turned(pieces: list[Piece]) -> Mesh:
    """Return a solid of revolution where its profile says [m]; u runs around it and v along the profile [m].

    `revolution.revolve` has it centred and its texture coordinates over the greatest circumference.
    """
    mesh, unit = revolve("part", pieces)
    assert mesh.uv is not None
    low, high = (choose(float(choose(piece.points[:, 1])) for piece in pieces) for choose in (min, max))
    return Mesh(
        "part",
        mesh.vertices + np.array([0.0, 0.0, (low + high) / 2], np.float32),
        mesh.faces,
        mesh.normals,
        mesh.uv * unit,
    )


def faces_of_pieces(mesh: Mesh, pieces: list[Piece]) -> np.ndarray:
    """Return which piece of its profile each face of a `turned` mesh belongs to, (m,) int."""
    columns = len(mesh.vertices) // sum(len(piece.points) for piece in pieces)
    ends = np.cumsum([len(piece.points) * columns for piece in pieces])
    return np.searchsorted(ends, mesh.faces[:, 0], side="right")


def moved(mesh: Mesh, shift: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0), turn: np.ndarray | None = None) -> Mesh:
    """Return a mesh turned by a rotation (3, 3) and then shifted [m]."""
    turn = np.eye(3) if turn is None else turn
    normals = None if mesh.normals is None else mesh.normals @ turn.T
    return Mesh(mesh.name, mesh.vertices @ turn.T + np.asarray(shift), mesh.faces, normals, mesh.uv)


def rotation(axis: int, angle: float) -> np.ndarray:
    """Return the rotation about a coordinate axis by an angle [rad], (3, 3)."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[a, a] = turn[b, b] = np.cos(angle)
    turn[b, a], turn[a, b] = np.sin(angle), -np.sin(angle)
    return turn


def rounded_rectangle(width: float, depth: float, radius: float, steps: int = 8) -> np.ndarray:
    """Return the outline of a rectangle with round corners about the origin, counter-clockwise, (4 (steps + 1), 2)."""
    quarter = np.linspace(0.0, np.pi / 2, steps + 1)
    corners = []
    for number, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = quarter + number * np.pi / 2
        centre = np.array([x * (width / 2 - radius), y * (depth / 2 - radius)])
        corners.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], 1))
    return np.concatenate(corners)


def circle(radius: float, steps: int = 32, centre: Sequence[float] = (0.0, 0.0)) -> np.ndarray:
    """Return a circle counter-clockwise, (steps, 2) [m]; reversed it is a hole."""
    turn = 2 * np.pi * np.arange(steps) / steps
    return np.asarray(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], 1)


def _inset(contour: np.ndarray, by: float) -> np.ndarray:
    """Return a contour moved to its left, into the material [m]."""
    if by == 0.0:
        return contour
    before, after = contour - np.roll(contour, 1, axis=0), np.roll(contour, -1, axis=0) - contour
    left = [np.stack([-e[:, 1], e[:, 0]], 1) / np.linalg.norm(e, axis=1, keepdims=True) for e in (before, after)]
    mean = left[0] + left[1]
    return contour + by * mean * 2.0 / np.maximum((mean * mean).sum(1, keepdims=True), 1.0)


def _flattened(ring: np.ndarray) -> np.ndarray:
    """Return a ring about the origin in coordinates of its own plane, (m, 2) [m]."""
    _, _, axes = np.linalg.svd(ring, full_matrices=False)
    return ring @ axes[:2].T


def _frames(path: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the side and up directions along a path, each (n, 3), turned as little as possible."""
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    upward = np.empty_like(path)
    for number, along in enumerate(tangent):
        up = up - along * (up @ along)
        up = up / np.linalg.norm(up)
        upward[number] = up
    # The outline is counter-clockwise seen from the path's end: side x up is the tangent.
    return np.cross(upward, tangent), upward
