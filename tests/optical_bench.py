"""Scenes of one glass body above a board: slabs, prisms, balls, vessels, for closed forms to be compared with."""

from __future__ import annotations

import numpy as np
import trimesh

from glassware.core.mesh import Mesh
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.description.scene import Interface, Picture, Scene, Vessel
from glassware.procedural.description.surroundings import Camera, SkyEnvironment, Table
from glassware.procedural.optics.medium import AIR, Medium

BOARD = (4.0, 4.0, 0.02)


def medium(eta: float, sigma_a: tuple[float, float, float] = (0.0, 0.0, 0.0), name: str = "glass") -> Medium:
    return Medium(name=name, eta=eta, sigma_a=sigma_a)


def box(size: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    solid = trimesh.creation.box(extents=size)
    return Mesh("solid", solid.vertices + np.array(centre), solid.faces)


def prism(triangle: np.ndarray, depth: float) -> Mesh:
    """A prism: a triangle in the x z plane, (3, 2), pulled along y."""
    front = np.insert(triangle, 1, -depth / 2, axis=1)
    back = np.insert(triangle, 1, depth / 2, axis=1)
    solid = trimesh.convex.convex_hull(np.concatenate([front, back]))
    return Mesh("solid", solid.vertices, solid.faces)


def ball(radius: float, subdivisions: int, centre: tuple[float, float, float]) -> Mesh:
    """A ball with its true normals, so that only the positions between vertices are approximate."""
    solid = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    unit = np.asarray(solid.vertices) / np.linalg.norm(solid.vertices, axis=1, keepdims=True)
    return Mesh("solid", radius * unit + np.array(centre), solid.faces, unit)


def scene(mesh: Mesh, inside: Medium, *cameras: Camera) -> Scene:
    """One closed body of one medium, given in the world frame."""
    skin = Interface(part="outside", mesh=mesh, front=AIR, back=inside)
    vessel = Vessel(
        id=2,
        name="body",
        category="tumbler",
        glass=inside,
        roughness=0.0,
        wall=0.001,
        outer=((0.0, 0.0), (1.0, 0.0)),
        inner=((0.0, 0.0), (1.0, 0.0)),
        interfaces=(skin,),
        size=tuple((mesh.bounds[1] - mesh.bounds[0]).tolist()),
        world_T_object=np.eye(4),
    )
    return surrounded((vessel,), cameras or (camera((0.0, 0.0, 1.0)),))


def surrounded(vessels: tuple[Vessel, ...], cameras: tuple[Camera, ...]) -> Scene:
    """Vessels over a white board, top at z = 0, under a plain sky."""
    white = OpaqueMaterial(name="white", base_colour=UniformTexture(colour=(0.8, 0.8, 0.8)), roughness=0.9)
    board = box(BOARD, (0.0, 0.0, -BOARD[2] / 2))
    sky = SkyEnvironment(
        sun_elevation=0.7,
        sun_radiance=5.0,
        sun_radius=0.1,
        turbidity=3.0,
        cloudiness=0.0,
        ground=(0.3, 0.3, 0.3),
        seed=1,
    )
    return Scene(
        seed=3,
        scene_id=0,
        table=Table(mesh=Mesh("table", board.vertices, board.faces), material=white, size=BOARD),
        vessels=vessels,
        props=(),
        environment=sky,
        lights=(),
        cameras=cameras,
        picture=Picture(spp=4),
    )


def camera(
    eye: tuple[float, float, float],
    target: tuple[float, float, float] = (0.0, 0.0, 0.0),
    width: int = 64,
    height: int = 48,
    focal: float = 80.0,
) -> Camera:
    """A camera that looks at a point; straight down, its x axis is the world's."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(right) < 1e-9 else right / np.linalg.norm(right)
    world_T_camera = np.eye(4)
    world_T_camera[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    world_T_camera[:3, 3] = eye
    return Camera(
        width=width,
        height=height,
        focal=focal,
        centre=((width - 1) / 2, (height - 1) / 2),
        world_T_camera=world_T_camera,
        baseline=0.05,
        exposure=1.0,
        grid_index=0,
    )


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
