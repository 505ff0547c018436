"""Solids other than solids of revolution: rounded boxes, extrusions, superellipsoids, stones."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from .normals import creased

#: Steps across a quarter of a rounded edge: 7.5 degrees each, as `revolution.ARC_STEP`.
EDGE_STEPS = 6
#: Steps across each of the six faces of a sphere-like solid: 90 degrees in 32 steps of under 3 degrees.
ROUND_STEPS = 32
#: Plane waves in the surface of a stone, and the range of their frequencies [rad of phase per unit of direction]. Their
#: longest wave makes one lobe; 48 are enough that no single wave is seen, and 7 is still smooth over `ROUND_STEPS`.
STONE_WAVES, STONE_FREQUENCIES = 48, (1.0, 7.0)


def rounded_box(name: str, size: tuple[float, float, float], radius: float) -> tuple[Mesh, float]:
    """Return a box with rounded edges and corners, and the length of a texture unit, its longest side [m].

    Parameters
    ----------
    name : str
        Name of the mesh.
    size : (x, y, z)
        Extent [m].
    radius : float
        Radius of the edges [m], at most half of the shortest side.
    """
    half = np.array(size) / 2 - radius
    quarter = np.tan(np.linspace(0.0, np.pi / 4, EDGE_STEPS + 1))
    quarter[-1] = 1.0  # exact, so that neighbouring faces meet
    slope = np.concatenate([-quarter[::-1], quarter])
    side = np.repeat([-1.0, 1.0], EDGE_STEPS + 1)
    vertices, normals, uv, faces = [], [], [], []
    for axis, sign in _cube_faces():
        grid, index = _face_grid(axis, sign, slope)
        centre, _ = _face_grid(axis, sign, side)
        direction = grid / _length(grid)
        vertices.append(centre * half + radius * direction)
        normals.append(direction)
        uv.append(_unrolled(slope, side, half, radius, axis, sign) / max(size))
        faces.append(index + len(grid) * len(faces))
    return Mesh(name, *map(np.concatenate, (vertices, faces, normals, uv))), max(size)


def superellipsoid(name: str, size: tuple[float, float, float], power: float) -> tuple[Mesh, float]:
    """Return the solid |x/a|^p + |y/b|^p + |z/c|^p <= 1, and the length of a texture unit [m].

    Barr, "Superquadrics and angle-preserving transformations" (1981), with both exponents 2/p. p = 2 is an
    ellipsoid, larger p are boxier.

    Parameters
    ----------
    name : str
        Name of the mesh.
    size : (2a, 2b, 2c)
        Extent [m].
    power : float
        p, at least 2 (smaller ones have points).
    """
    direction, faces, uv = face_grids(ROUND_STEPS)
    radius = np.sum(np.abs(direction) ** power, axis=1, keepdims=True) ** (-1.0 / power)
    unit_shape = direction * radius
    gradient = np.sign(unit_shape) * np.abs(unit_shape) ** (power - 1.0) / np.array(size)
    mesh = Mesh(name, unit_shape * np.array(size) / 2, faces, gradient / _length(gradient), uv)
    return mesh, np.pi / 4 * max(size)


def stone(
    name: str, size: tuple[float, float, float], roughness: float, rng: np.random.Generator
) -> tuple[Mesh, float]:
    """Return an ellipsoid with bumps, scaled to an extent, and the length of a texture unit [m].

    The radius varies as a sum of plane waves over the sphere of directions. Their amplitudes are 1/frequency, because
    worn stones have few and shallow fine features.

    Parameters
    ----------
    name : str
        Name of the mesh.
    size : (x, y, z)
        Extent [m].
    roughness : float
        Standard deviation of the radius, relative; below 0.15 the radius stays well above 0.
    rng : numpy.random.Generator
        Source of the waves.
    """
    direction, faces, uv = face_grids(ROUND_STEPS)
    low, high = np.log(STONE_FREQUENCIES)
    frequency = np.exp(rng.uniform(low, high, STONE_WAVES))
    heading = rng.normal(size=(STONE_WAVES, 3))
    waves = direction @ (frequency[:, None] * heading / _length(heading)).T + rng.uniform(0, 2 * np.pi, STONE_WAVES)
    bumps = np.cos(waves) @ (1.0 / frequency)
    bumps *= roughness / np.sqrt(0.5 * np.sum(frequency**-2.0))
    # The exponential keeps the radius positive for any sum of the waves.
    vertices = direction * np.exp(bumps)[:, None]
    low, high = vertices.min(0), vertices.max(0)
    vertices = (vertices - (low + high) / 2) * (np.array(size) / (high - low))
    # Welding compares positions, so they are rounded to the float32 of the mesh.
    vertices, faces, normals, uv = creased(vertices.astype(np.float32).astype(float), faces, uv, np.pi)
    return Mesh(name, vertices, faces, normals, uv), np.pi / 4 * max(size)


def extrusion(name: str, outline: np.ndarray, height: float) -> tuple[Mesh, float]:
    """Return an upright prism over an outline, and the length of a texture unit, its longest side [m].

    Parameters
    ----------
    name : str
        Name of the mesh.
    outline : (n, 2) float
        Counter-clockwise outline [m], star-shaped about the centre of its bounding box.
    height : float
        Height [m].
    """
    low, high = outline.min(0), outline.max(0)
    outline = outline - (low + high) / 2
    longest = max(height, *(high - low))
    count = len(outline)
    ring = np.concatenate([outline, outline[:1]])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    vertices, uv, faces = [], [], []
    for z in (-height / 2, height / 2):
        vertices.append(np.column_stack([ring, np.full(count + 1, z)]))
        uv.append(np.column_stack([along, np.full(count + 1, z)]) / longest)
    for z in (-height / 2, height / 2):
        cap = np.concatenate([ring[:-1], [[0.0, 0.0]]])
        vertices.append(np.column_stack([cap, np.full(count + 1, z)]))
        uv.append(cap * [np.sign(z), 1.0] / longest)
    first, after = np.arange(count), (np.arange(count) + 1) % count
    top, floor, roof = count + 1, 2 * count + 2, 3 * count + 3
    faces += [
        np.column_stack([first, first + 1, first + 1 + top]),
        np.column_stack([first, first + 1 + top, first + top]),
    ]
    faces += [np.column_stack([floor + after, floor + first, np.full(count, floor + count)])]
    faces += [np.column_stack([roof + first, roof + after, np.full(count, roof + count)])]
    points = np.concatenate(vertices).astype(np.float32).astype(float)
    return Mesh(name, *creased(points, np.concatenate(faces), np.concatenate(uv))), longest


def _cube_faces() -> list[tuple[int, float]]:
    return [(axis, sign) for axis in range(3) for sign in (1.0, -1.0)]


def _face_grid(axis: int, sign: float, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a grid with given steps over one face of the cube [-1, 1]^3: points (n^2, 3), and faces."""
    count = len(steps)
    first, second = _face_axes(axis, sign)
    grid = np.empty((count, count, 3))
    grid[..., axis] = sign
    grid[..., first] = steps[None, :]
    grid[..., second] = steps[:, None]
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).reshape(-1)
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + count + 1], 1),
            np.stack([corner, corner + count + 1, corner + count], 1),
        ]
    )
    return grid.reshape(-1, 3), faces


def _face_axes(axis: int, sign: float) -> tuple[int, int]:
    """Return two axes whose cross product points out of the face."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    return (first, second) if sign > 0 else (second, first)


def _unrolled(
    slope: np.ndarray, side: np.ndarray, half: np.ndarray, radius: float, axis: int, sign: float
) -> np.ndarray:
    """Return the lengths along the surface from a face's middle, (n^2, 2) [m]."""
    first, second = (side * half[i] + radius * np.arctan(slope) for i in _face_axes(axis, sign))
    return np.stack(np.meshgrid(first, second), -1).reshape(-1, 2)


def face_grids(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit directions on a grid over each face of a cube, faces, and coordinates 0 to 1 across each cube's face.

    The cube's faces come as +x, -x, +y, -y, +z, -z; `steps` is even and counts the cells along an edge.
    """
    slope = np.tan(np.linspace(-np.pi / 4, np.pi / 4, steps + 1))
    slope[[0, steps // 2, -1]] = -1.0, 0.0, 1.0
    grids = [_face_grid(axis, sign, slope) for axis, sign in _cube_faces()]
    points = np.concatenate([grid for grid, _ in grids])
    faces = np.concatenate([index + number * len(grids[0][0]) for number, (_, index) in enumerate(grids)])
    across = np.linspace(0.0, 1.0, steps + 1)
    uv = np.tile(np.stack(np.meshgrid(across, across), -1).reshape(-1, 2), (6, 1))
    return points / _length(points), faces, uv


def _length(vectors: np.ndarray) -> np.ndarray:
    # Written out, because the order of the sum must be the same for all faces that a point is part of.
    return np.sqrt(vectors[:, 0] ** 2 + vectors[:, 1] ** 2 + vectors[:, 2] ** 2)[:, None]
