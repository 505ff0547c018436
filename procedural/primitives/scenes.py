"""What a scene by hand needs besides its bodies: a board, a camera that looks at a point, and the scene itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.arguments import point, whole_number
from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.pose import look_at
from ..description.camera import LONGEST_SIDE, Camera
from ..description.material import OpaqueMaterial, UniformTexture
from ..description.picture import Picture
from ..description.scene import GlassBody, Prop, Scene
from ..description.surroundings import AreaLight, ConstantEnvironment, Environment, Table
from ..surroundings.environments import bake_environment
from ..surroundings.metering import exposure, irradiance
from .bodies import Point, box_mesh

#: Distance between the eyes of a camera by hand [m]: that of a pair of human eyes.
BASELINE = 0.065


def matte(reflectance: tuple[float, float, float] = (0.5, 0.5, 0.5), name: str = "matte") -> OpaqueMaterial:
    """Return a rough opaque material of one linear Rec.709 reflectance."""
    return OpaqueMaterial(name=name, base_colour=UniformTexture(colour=reflectance), roughness=1.0)


def board(size: Point = (1.2, 0.8, 0.03), material: OpaqueMaterial | None = None) -> Table:
    """Return a table: a sharp-edged box [m] whose top is at z = 0."""
    mesh = box_mesh(size, "table", (0.0, 0.0, -0.5 * size[2]))
    mesh = Mesh("table", mesh.vertices, mesh.faces, uv=mesh.vertices[:, :2])
    return Table(mesh=mesh, material=material or matte(), size=size)


def block(mesh: Mesh, material: OpaqueMaterial, *, id: int, category: str = "block") -> Prop:
    """Return an opaque prop named as its mesh, which is given in the world frame [m]."""
    centre = mesh.bounds.mean(0)
    pose = np.eye(4)
    pose[:3, 3] = centre
    centred = Mesh(mesh.name, mesh.vertices - centre, mesh.faces, mesh.normals, mesh.uv)
    x, y, z = np.ptp(centred.bounds, axis=0).tolist()
    return Prop(
        id=id,
        name=mesh.name,
        category=category,
        mesh=centred,
        material=material,
        size=(x, y, z),
        world_T_object=pose,
    )


def camera(
    eye: Point,
    target: Point = (0.0, 0.0, 0.0),
    *,
    width: int = 640,
    height: int = 480,
    focal: float | tuple[float, float] | None = None,
    baseline: float = BASELINE,
    exposure: float = 1.0,
    grid_index: int | None = 0,
    roll: float = 0.0,
) -> Camera:
    """Return a stereo camera whose left eye looks at a point, +z up in the picture.

    Parameters
    ----------
    eye, target : (float, float, float)
        World frame [m].
    width, height : int
        Of the picture [px].
    focal : float or (float, float), optional
        Focal length, or those along x and y [px]; by default the picture's width, a horizontal field of view of 53
        degrees.
    baseline : float
        Distance of the two eyes [m].
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.
    grid_index : int, optional
        Place in the grid of 57 views; None off it.
    roll : float
        Turn about the optical axis, clockwise as the camera sees it [rad].

    Raises
    ------
    InputError
        Where eye or target is no point, they are the same point, or width or height is no whole number above 0.
    """
    place, aim = point("camera, eye", eye), point("camera, target", target)
    if np.allclose(place, aim, rtol=0.0, atol=1e-9):
        raise InputError("camera, target", "a point away from the eye", aim.tolist())
    width, height = (
        whole_number(f"camera, {name}", side, 1, LONGEST_SIDE) for name, side in (("width", width), ("height", height))
    )
    focal = float(width) if focal is None else focal
    fx, fy = focal if isinstance(focal, tuple) else (focal, focal)
    return Camera(
        width=width,
        height=height,
        focal=fx,
        focal_y=None if fy == fx else fy,
        centre=((width - 1) / 2, (height - 1) / 2),
        world_T_camera=look_at(place, aim, roll),
        baseline=baseline,
        exposure=exposure,
        grid_index=grid_index,
    )


def scene(
    bodies: Sequence[GlassBody],
    cameras: Sequence[Camera],
    *,
    props: Sequence[Prop] = (),
    table: Table | None = None,
    environment: Environment | None = None,
    lights: Sequence[AreaLight] = (),
    picture: Picture | None = None,
    seed: int = 0,
) -> Scene:
    """Return a scene by hand.

    Parameters
    ----------
    bodies : sequence of GlassBody
        Vessels and other transparent bodies, in the world frame by their poses.
    cameras : sequence of Camera
        At least one.
    props : sequence of Prop
        Opaque bodies.
    table : Table, optional
        A grey board by default.
    environment : Environment, optional
        By default the radiance 1 from every direction.
    lights : sequence of AreaLight
        Rectangles that shine.
    picture : Picture, optional
        How pictures are computed.
    seed : int
        Of the noise in the pictures.

    Raises
    ------
    InputError
        Where there is no camera. `check_scene` looks at the rest.
    """
    if not cameras:
        raise InputError("scene, cameras", "at least one", "none")
    return Scene(
        seed=seed,
        scene_id=0,
        table=table or board(),
        vessels=tuple(bodies),
        props=tuple(props),
        environment=environment or ConstantEnvironment(),
        lights=tuple(lights),
        cameras=tuple(cameras),
        picture=picture or Picture(),
    )


def metered(description: Scene) -> Scene:
    """Return the scene with the exposure of every camera set by an incident-light meter on the table."""
    pixels = bake_environment(description.environment)
    level = exposure(irradiance(pixels, description.environment.strength, description.lights))
    cameras = tuple(item.model_copy(update={"exposure": level}) for item in description.cameras)
    return description.model_copy(update={"cameras": cameras})
