"""Mass, centre of mass and inertia of closed surfaces: filled with a material, or a shell of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from ...core.mesh import Mesh
from ...core.model import Model, Vector3


class MassProperties(Model):
    """What a rigid body is to forces; object frame."""

    mass: float = Field(gt=0.0, description="Mass [kg]")
    centre_of_mass: Vector3 = Field(description="Centre of gravity, object frame [m]")
    inertia: tuple[Vector3, Vector3, Vector3] = Field(
        description="Moments of inertia about the centre of mass, along the axes of the object frame [kg m^2]"
    )


def solid_mass(mesh: Mesh, density: float) -> MassProperties:
    """Return the mass properties of a closed surface that is filled with a material of a density [kg/m^3].

    Sums over the tetrahedra between its triangles and the middle of its box; of one with edges a, b, c from there and
    s = a + b + c the integral of x x^T is det(a, b, c) (a a^T + b b^T + c c^T + s s^T) / 120 (Blow & Binstock 2004,
    "How to find the inertia tensor (or other mass properties) of a 3D solid body represented by a triangle mesh").
    """
    corners, origin = _corners(mesh)
    weights = np.linalg.det(corners)
    if weights.sum() < 0.0:  # faces that look inwards
        weights = -weights
    sums = corners.sum(1)
    second = _weighted(weights / 120.0, corners, sums)
    return _properties(density * weights.sum() / 6.0, density * (weights @ sums) / 24.0, density * second, origin)


def shell_mass(mesh: Mesh, density: float, thickness: float) -> MassProperties:
    """Return the mass properties of a thin shell on a surface, which may be open.

    Of a triangle with corners a, b, c and s = a + b + c the integral of x x^T is
    area (a a^T + b b^T + c c^T + s s^T) / 12.
    """
    corners, origin = _corners(mesh)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weights = 0.5 * density * thickness * np.linalg.norm(cross, axis=1)
    sums = corners.sum(1)
    return _properties(weights.sum(), (weights @ sums) / 3.0, _weighted(weights / 12.0, corners, sums), origin)


def combined(parts: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several bodies that move as one (Steiner's theorem)."""
    mass = sum(part.mass for part in parts)
    centre = np.sum([part.mass * np.array(part.centre_of_mass) for part in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        offset = np.array(part.centre_of_mass) - centre
        inertia += np.array(part.inertia) + part.mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return _record(mass, centre, inertia)


def moved_mass(properties: MassProperties, pose: np.ndarray) -> MassProperties:
    """Return the mass properties of a body in another frame, ``a_T_b`` (4, 4), along the axes of that frame."""
    turn, centre = pose[:3, :3], np.array(properties.centre_of_mass)
    return _record(properties.mass, turn @ centre + pose[:3, 3], turn @ np.array(properties.inertia) @ turn.T)


def _corners(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (m, 3, 3) about the middle of the surface's box, and that middle."""
    origin = mesh.bounds.mean(0)
    return mesh.vertices.astype(np.float64)[mesh.faces] - origin, origin


def _weighted(weights: np.ndarray, corners: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Return the sum over triangles of weight (a a^T + b b^T + c c^T + s s^T), (3, 3)."""
    rows = np.concatenate([corners.transpose(1, 0, 2).reshape(-1, 3), sums])
    return rows.T @ (np.tile(weights, 4)[:, None] * rows)


def _properties(mass: float, first: np.ndarray, second: np.ndarray, origin: np.ndarray) -> MassProperties:
    """Return the record of the moments of order zero, one and two about an origin."""
    centre = first / mass
    about = second - mass * np.outer(centre, centre)
    return _record(mass, centre + origin, np.trace(about) * np.eye(3) - about)


def _record(mass: float, centre: np.ndarray, inertia: np.ndarray) -> MassProperties:
    rows = 0.5 * (inertia + inertia.T)
    return MassProperties.model_validate(
        {"mass": float(mass), "centre_of_mass": centre.tolist(), "inertia": rows.tolist()}
    )
