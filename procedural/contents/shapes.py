"""Shapes of bodies in vessels: ice cubes, balls, straws, rods and spoons. All are closed, normals out."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh

#: Vertices along an edge of an ice cube's faces, and round a straw, a rod or a section of a spoon [1].
_CUBE_STEPS, _ROUND = 14, 48
#: Least half width of a spoon at its two ends [m]: they are cut off flat there.
_TIP = 2e-4
#: Refinements of an icosahedron for a ball [1]: 1280 triangles, 0.3 % of the radius off; of a bubble 320, 1.3 %.
BALL_STEPS, BUBBLE_STEPS = 3, 2


def rounded_box(size: tuple[float, float, float], rounding: float, bumps: np.ndarray, name: str) -> Mesh:
    """Return a box with rounded edges, about the origin, whose faces bulge a little.

    Parameters
    ----------
    size : (float, float, float)
        Extent [m].
    rounding : float
        Radius of the edges [m].
    bumps : (k, 5) float
        Waves on the surface: wave vector [1/m], phase [rad], and height [m].
    name : str
        Name of the mesh.
    """
    points, faces = _cube_grid(_CUBE_STEPS)
    half = 0.5 * np.asarray(size)
    # More points near the edges, which are round.
    places = half * np.sin(0.5 * np.pi * points)
    core = np.clip(places, -(half - rounding), half - rounding)
    away = places - core
    length = np.linalg.norm(away, axis=1, keepdims=True)
    direction = np.where(length > 1e-12, away / np.maximum(length, 1e-12), 0.0)
    surface = core + rounding * direction
    outwards = direction
    height = (np.sin(surface @ bumps[:, :3].T + bumps[:, 3]) * bumps[:, 4]).sum(1)
    surface = surface + height[:, None] * outwards
    return Mesh(name, surface, faces, _smooth_normals(surface, faces))


def _cube_grid(steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface of the cube [-1, 1]^3 as a grid: points, each once, and triangles that look outwards."""
    line = np.linspace(-1.0, 1.0, steps + 1)
    u, v = np.meshgrid(line, line, indexing="ij")
    quads = np.arange((steps + 1) ** 2).reshape(steps + 1, steps + 1)
    a, b, c, d = (quads[i : steps + i, j : steps + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    square = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    points, faces = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((u.size, 3))
            face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = side, u.ravel(), v.ravel()
            faces.append((square if side > 0.0 else square[:, ::-1]) + len(points) * u.size)
            points.append(face)
    places, index = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return places, index.reshape(-1)[np.concatenate(faces)]


def _smooth_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    each = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, faces[:, k], each)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def unit_ball(steps: int = BALL_STEPS) -> tuple[np.ndarray, np.ndarray]:
    """Return points on the unit sphere and the triangles between them."""
    import trimesh  # here, as it takes half a second to load

    solid = trimesh.creation.icosphere(subdivisions=steps)
    points = np.asarray(solid.vertices)
    return points / np.linalg.norm(points, axis=1, keepdims=True), np.asarray(solid.faces)


def balls(centres: np.ndarray, radii: np.ndarray, name: str, steps: int = BALL_STEPS) -> Mesh:
    """Return one mesh of many balls: centres (n, 3) and radii (n,) [m]."""
    unit, faces = unit_ball(steps)
    points = centres[:, None] + radii[:, None, None] * unit
    index = faces + len(unit) * np.arange(len(centres))[:, None, None]
    return Mesh(name, points.reshape(-1, 3), index.reshape(-1, 3), np.tile(unit, (len(centres), 1)))


def tube(outer: float, wall: float, length: float, name: str) -> Mesh:
    """Return a tube about the z axis from 0 up [m], open at both ends, with texture coordinates (turn, length)."""
    profile = np.array([[outer, 0.0], [outer, length], [outer - wall, length], [outer - wall, 0.0]])
    normals = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    parts = [_band(profile[k], profile[(k + 1) % 4], normals[k]) for k in range(4)]
    return _joined_bands(parts, name)


def rod(radius: float, length: float, name: str) -> Mesh:
    """Return a round rod about the z axis from 0 up [m], with ends rounded as by a flame."""
    angle = np.linspace(0.0, 0.5 * np.pi, 9)[1:]  # the very tips are flat
    low = np.stack([radius * np.sin(angle), radius * (1.0 - np.cos(angle))], 1)
    steps = np.linspace(radius, length - radius, max(3, int(length / 0.01)))[1:-1]
    side = np.stack([np.full(len(steps), radius), steps], 1)
    high = np.stack([low[::-1, 0], length - low[::-1, 1]], 1)
    profile = np.concatenate([low, side, high])
    return _loft(np.stack([profile[:, 0], profile[:, 0]], 1), np.zeros(len(profile)), profile[:, 1], name)


def spoon(length: float, bowl: tuple[float, float, float], handle: tuple[float, float], name: str) -> Mesh:
    """Return a spoon whose bowl is down: along the z axis from 0 up, its width along y [m].

    Parameters
    ----------
    length : float
        Whole length.
    bowl : (float, float, float)
        Length, width and depth of the bowl.
    handle : (float, float)
        Smallest and largest width of the handle.
    name : str
        Name of the mesh.
    """
    low = bowl[0] * (0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 33)))
    z = np.concatenate([low, np.linspace(bowl[0], length, 40)[1:]])
    t = np.clip(z / bowl[0], 0.0, 1.0)
    # An egg's outline, wider towards the tip, that runs into the neck.
    egg = 0.5 * bowl[1] * np.sqrt(np.maximum(1.0 - (2.0 * t - 1.0) ** 2, 0.0)) * (1.08 - 0.16 * t)
    up = np.clip((z - 0.8 * bowl[0]) / (length - 0.8 * bowl[0]), 0.0, 1.0)
    shaft = 0.5 * (handle[0] + (handle[1] - handle[0]) * up**2)
    width = np.where(z < 0.8 * bowl[0], egg, np.maximum(egg, shaft))
    rest = np.clip((length - z) / (0.5 * handle[1]), 0.0, 1.0)
    width = np.maximum(width * np.sqrt(rest * (2.0 - rest)), _TIP)
    sheet = 0.0006 + 0.0008 * np.clip((z - 0.6 * bowl[0]) / (0.5 * bowl[0]), 0.0, 1.0) * (1.0 - 0.5 * up)
    sag = bowl[2] * np.maximum(1.0 - (2.0 * t - 1.0) ** 2, 0.0)
    return _loft(np.stack([sheet, width], 1), sag, z, name)


def _loft(half: np.ndarray, sag: np.ndarray, z: np.ndarray, name: str) -> Mesh:
    """Return ellipses with half axes (n, 2) along x and y at heights, hollowed along x by a sag; both ends closed."""
    angle = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
    x = half[:, :1] * np.cos(angle) + sag[:, None] * (np.sin(angle) ** 2 - 1.0)
    y = half[:, 1:] * np.sin(angle)
    rings = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)], -1)
    low, high = rings[0].mean(0), rings[-1].mean(0)
    points = np.concatenate([rings.reshape(-1, 3), [low, high]])
    k = np.arange(_ROUND)
    n = (k + 1) % _ROUND
    faces = []
    for row in range(len(z) - 1):
        a, b = row * _ROUND, (row + 1) * _ROUND
        faces += [np.stack([a + k, a + n, b + n], 1), np.stack([a + k, b + n, b + k], 1)]
    last = (len(z) - 1) * _ROUND
    faces += [np.stack([np.full(_ROUND, len(points) - 2), n, k], 1)]
    faces += [np.stack([np.full(_ROUND, len(points) - 1), last + k, last + n], 1)]
    index = np.concatenate(faces)
    corners = points[index]
    index = index[
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-14
    ]
    return Mesh(name, points, index, _smooth_normals(points, index))


def _band(
    start: np.ndarray, end: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return a cone's side between two points (r, z): positions, normals, texture coordinates and triangles."""
    angle = 2.0 * np.pi * np.arange(_ROUND + 1) / _ROUND
    angle[-1] = 0.0  # the same bits at the seam
    count = max(2, int(np.ceil(np.linalg.norm(end - start) / 0.01)) + 1)
    t = np.linspace(0.0, 1.0, count)
    r, z = start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])
    ring = np.stack([np.cos(angle), np.sin(angle)], 1)
    points = np.concatenate([np.column_stack([a * ring, np.full(len(ring), b)]) for a, b in zip(r, z, strict=True)])
    normals = np.tile(np.column_stack([normal[0] * ring, np.full(len(ring), normal[1])]), (count, 1))
    turn = np.tile(np.arange(_ROUND + 1) / _ROUND, count)
    uv = np.stack([turn * 2.0 * np.pi * max(start[0], end[0]), np.repeat(z, len(ring))], 1)
    k, width = np.arange(_ROUND), _ROUND + 1
    faces = []
    for row in range(count - 1):
        a, b = row * width, (row + 1) * width
        faces += [np.stack([a + k, a + k + 1, b + k + 1], 1), np.stack([a + k, b + k + 1, b + k], 1)]
    return points, normals, uv, np.concatenate(faces)


def _joined_bands(parts: list, name: str) -> Mesh:
    offsets = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    faces = np.concatenate([part[3] + offset for part, offset in zip(parts, offsets, strict=True)])
    points, normals, uv = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return Mesh(name, points, faces, normals, uv)
