"""Scenes of one body and nothing else, loaded."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import OpenEXR

from glassware.core.assets import asset
from glassware.core.mesh import Mesh, joined
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.description.scene import Interface, Picture, Prop, Scene, Vessel
from glassware.procedural.description.surroundings import Camera, PictureEnvironment, SkyEnvironment, Table
from glassware.procedural.optics.medium import AIR, Medium
from glassware.render.scene.kernel import Kernel, load

from .bodies import box

#: The screens, by their instance id.
SCREEN_ID = 9
_CLAY = OpaqueMaterial(name="clay", base_colour=UniformTexture(colour=(0.5, 0.5, 0.5)), roughness=1.0)
#: A table is part of every scene. This one is too small to be met: 1e-5 m, half a metre aside.
_TABLE = np.array([[0.3, 0.3, -0.3], [0.30001, 0.3, -0.3], [0.3, 0.30001, -0.3]])
#: Stands in a description until `loaded_scene` puts a map in its place; it is never baked.
_SKY = SkyEnvironment(
    sun_elevation=1.0, sun_radiance=1.0, sun_radius=0.1, turbidity=3.0, cloudiness=0.0, ground=(0.5, 0.5, 0.5), seed=1
)
#: Radiance 1 in every direction: a white furnace.
FURNACE = np.ones((8, 16, 3))


#: What an interface is a part of.
Part = Literal["outside", "wet_wall", "liquid_surface"]


def interface(
    mesh: Mesh, back: Medium, front: Medium = AIR, roughness: float = 0.0, part: Part = "outside"
) -> Interface:
    """Return an interface."""
    return Interface(part=part, mesh=mesh, front=front, back=back, roughness=roughness)


def screen(lower: Sequence[float], upper: Sequence[float]) -> Prop:
    """Return an opaque box between two corners [m]."""
    return Prop(
        id=SCREEN_ID,
        name="screen",
        category="box",
        mesh=box(lower, upper, "screen"),
        material=_CLAY,
        size=(upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]),
        world_T_object=np.eye(4),
    )


def loaded(
    *interfaces: Interface, props: Sequence[Prop] = (), environment: np.ndarray = FURNACE, **picture: object
) -> Kernel:
    """Load a scene of one object with these interfaces, in the world frame; the variant must be active.

    Parameters
    ----------
    *interfaces : Interface
        Its surfaces.
    props : sequence of Prop
        Opaque bodies.
    environment : (h, 2 * h, 3) float
        Radiance by direction.
    **picture
        Fields of `Picture`.
    """
    vessel = Vessel(
        id=2,
        name="body",
        category="body",
        glass=interfaces[0].back,
        roughness=interfaces[0].roughness,
        wall=1e-3,
        outer=((0.0, 0.0),),
        inner=((0.0, 0.0),),
        interfaces=interfaces,
        size=tuple(np.ptp(joined([item.mesh for item in interfaces], "all").bounds, axis=0)),
        world_T_object=np.eye(4),
    )
    return loaded_scene(
        Scene(
            seed=1,
            scene_id=0,
            table=_speck(),
            vessels=(vessel,),
            props=tuple(props),
            environment=_SKY,
            lights=(),
            cameras=(_camera(),),
            picture=Picture.model_validate(picture),
        ),
        environment,
    )


def loaded_scene(description: Scene, environment: np.ndarray = FURNACE) -> Kernel:
    """Load a scene under a map of radiance, (h, 2 * h, 3), in place of its own surroundings."""
    planes = {name: np.ascontiguousarray(environment[..., i], dtype=np.float32) for i, name in enumerate("RGB")}
    with tempfile.TemporaryDirectory(prefix="glassware-proof-") as folder:
        path = Path(folder) / "map.exr"
        OpenEXR.File({}, planes).write(str(path))
        return load(description.model_copy(update={"environment": PictureEnvironment(asset=asset(path))}))


def alone(description: Scene) -> Scene:
    """Return a scene with its vessels and nothing else: the table far too small to be met, no props, no lamps."""
    return description.model_copy(update={"table": _speck(), "props": (), "lights": ()})


def _speck() -> Table:
    return Table(
        mesh=Mesh("table", _TABLE, np.array([[0, 1, 2]]), uv=np.zeros((3, 2))), material=_CLAY, size=(1e-5, 1e-5, 1e-5)
    )


def _camera() -> Camera:
    return Camera(
        width=2,
        height=2,
        focal=1.0,
        centre=(0.5, 0.5),
        world_T_camera=np.eye(4),
        baseline=0.1,
        exposure=1.0,
        grid_index=0,
    )
