"""Scenes of one glass body above a board: slabs, prisms, balls, vessels, for closed forms to be compared with."""

from __future__ import annotations

import numpy as np

from glassware.core.mesh import Mesh
from glassware.procedural.description.camera import Camera
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import GlassBody, Scene
from glassware.procedural.description.surroundings import SkyEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes

BOARD = (4.0, 4.0, 0.02)


def medium(eta: float, sigma_a: tuple[float, float, float] = (0.0, 0.0, 0.0), name: str = "glass") -> Medium:
    return Medium(name=name, eta=eta, sigma_a=sigma_a)


def box(size: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    return bodies.box_mesh(size, "solid", centre)


def prism(triangle: np.ndarray, depth: float) -> Mesh:
    return bodies.prism_mesh(triangle, depth, "solid")


def ball(radius: float, subdivisions: int, centre: tuple[float, float, float]) -> Mesh:
    return bodies.ball_mesh(radius, subdivisions, "solid", centre)


def scene(mesh: Mesh, inside: Medium, *cameras: Camera) -> Scene:
    """One closed body of one medium, given in the world frame."""
    return surrounded((bodies.glass_body(mesh, inside),), cameras or (camera((0.0, 0.0, 1.0)),))


def surrounded(vessels: tuple[GlassBody, ...], cameras: tuple[Camera, ...]) -> Scene:
    """Bodies over a white board, top at z = 0, under a plain sky."""
    white = scenes.matte((0.8, 0.8, 0.8), "white").model_copy(update={"roughness": 0.9})
    sky = SkyEnvironment(
        sun_elevation=0.7,
        sun_radiance=5.0,
        sun_radius=0.1,
        turbidity=3.0,
        cloudiness=0.0,
        ground=(0.3, 0.3, 0.3),
        seed=1,
    )
    return scenes.scene(
        vessels, cameras, table=scenes.board(BOARD, white), environment=sky, picture=Picture(spp=4), seed=3
    )


def camera(
    eye: tuple[float, float, float],
    target: tuple[float, float, float] = (0.0, 0.0, 0.0),
    width: int = 64,
    height: int = 48,
    focal: float = 80.0,
) -> Camera:
    """A camera that looks at a point; straight down, its x axis is the world's."""
    roll = np.pi / 2 if eye[:2] == target[:2] else 0.0
    return scenes.camera(eye, target, width=width, height=height, focal=focal, baseline=0.05, roll=roll)


def rays(origin: np.ndarray, direction: np.ndarray):
    """Mitsuba rays from (n, 3) origins and directions."""
    import drjit as dr
    import mitsuba as mi

    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    columns = (np.ascontiguousarray(np.broadcast_to(a, direction.shape).T, np.float32) for a in (origin, direction))
    o, d = columns
    ray = mi.Ray3f(mi.Point3f(o), mi.Vector3f(d))
    dr.make_opaque(ray)
    return ray


def snell(theta: np.ndarray, eta: float) -> np.ndarray:
    """The refracted angle on entering a medium of relative index `eta`."""
    return np.arcsin(np.sin(theta) / eta)


def fresnel(theta: np.ndarray, eta: float) -> np.ndarray:
    """Unpolarised reflectance (Born and Wolf, Principles of Optics, 1.5.2, eq. 33) away from normal incidence."""
    inside = snell(theta, eta)
    rs = np.sin(theta - inside) / np.sin(theta + inside)
    rp = np.tan(theta - inside) / np.tan(theta + inside)
    return 0.5 * (rs**2 + rp**2)
