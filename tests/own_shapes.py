"""Solids as people bring them, made here: beakers, mugs, pots, in metres, standing on z = 0."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

#: Of the beaker: outer radius, height, thickness of wall and floor [m].
RADIUS, HEIGHT, WALL = 0.035, 0.09, 0.002


def beaker(sections: int = 96, wall: float = WALL, rows: int = 8) -> trimesh.Trimesh:
    """Return a cylindrical beaker, a solid of revolution."""
    up, down = np.linspace(0.0, HEIGHT, rows), np.linspace(HEIGHT, wall, rows)
    inner = RADIUS - wall
    profile = [(0.0, 0.0), *((RADIUS, z) for z in up), *((inner, z) for z in down), (0.0, wall)]
    return trimesh.creation.revolve(np.array(profile), sections=sections)


def capacity(sections: int = 96, wall: float = WALL) -> float:
    """Return the volume inside a beaker, which is a prism of so many sides [m^3]."""
    area = 0.5 * sections * np.sin(2.0 * np.pi / sections) * (RADIUS - wall) ** 2
    return float(area * (HEIGHT - wall))


def handle(radius: float = 0.004, reach: float = 0.02) -> trimesh.Trimesh:
    """Return a ring that stands upright in the beaker's wall, a solid of its own."""
    ring = trimesh.creation.torus(major_radius=reach, minor_radius=radius, major_sections=32, minor_sections=16)
    ring.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, [1.0, 0.0, 0.0]))
    return ring.apply_translation([RADIUS + 0.3 * reach, 0.0, 0.5 * HEIGHT])


def with_bodies(*bodies: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return bodies as one mesh, as they are."""
    joined = trimesh.util.concatenate(list(bodies))
    assert isinstance(joined, trimesh.Trimesh)
    return joined


def sheet() -> trimesh.Trimesh:
    """Return the outside of a beaker without a thickness."""
    profile = [(0.0, 0.0), *((RADIUS, z) for z in np.linspace(0.0, HEIGHT, 8))]
    return trimesh.creation.revolve(np.array(profile), sections=64)


def saved(mesh: trimesh.Trimesh, path: Path, scale: float = 1.0) -> Path:
    """Write a mesh in another unit, and return its path."""
    mesh.copy().apply_scale(scale).export(path)
    return path
