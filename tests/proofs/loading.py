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
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import GlassBody, Interface, Prop, Scene
from glassware.procedural.description.surroundings import ConstantEnvironment, PictureEnvironment, Table
from glassware.procedural.optics.medium import AIR, Medium
from glassware.procedural.primitives import scenes
from glassware.render.scene.loaded_scene import LoadedScene, load

from .bodies import box

#: The screens, by their instance id.
SCREEN_ID = 9
#: A table is part of every scene. This one is too small to be met: 1e-5 m, half a metre aside.
_TABLE = np.array([[0.3, 0.3, -0.3], [0.30001, 0.3, -0.3], [0.3, 0.30001, -0.3]])


#: What an interface is a part of.
Part = Literal["outside", "wet_wall", "liquid_surface"]


def interface(
    mesh: Mesh, back: Medium, front: Medium = AIR, roughness: float = 0.0, part: Part = "outside"
) -> Interface:
    """Return an interface."""
    return Interface(part=part, mesh=mesh, front=front, back=back, roughness=roughness)


def screen(lower: Sequence[float], upper: Sequence[float]) -> Prop:
    """Return an opaque box between two corners [m]."""
    return scenes.block(box(lower, upper, "screen"), scenes.matte(), id=SCREEN_ID, category="box")


def loaded(
    *interfaces: Interface, props: Sequence[Prop] = (), environment: np.ndarray | None = None, **picture: object
) -> LoadedScene:
    """Load a scene of one object with these interfaces, in the world frame; the variant must be active.

    Parameters
    ----------
    *interfaces : Interface
        Its surfaces.
    props : sequence of Prop
        Opaque bodies.
    environment : (h, 2 * h, 3) float, optional
        Radiance by direction; by default 1 from everywhere, a white furnace.
    **picture
        Fields of `Picture`.
    """
    body = GlassBody(
        id=2,
        name="body",
        category="body",
        glass=interfaces[0].back,
        roughness=interfaces[0].roughness,
        interfaces=interfaces,
        size=tuple(np.ptp(joined([item.mesh for item in interfaces], "all").bounds, axis=0)),
        world_T_object=np.eye(4),
    )
    camera = scenes.camera((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), width=2, height=2, focal=1.0)
    scene = scenes.scene(
        (body,), (camera,), props=props, table=_speck(), picture=Picture.model_validate(picture), seed=1
    )
    return loaded_scene(scene, environment)


def loaded_scene(description: Scene, environment: np.ndarray | None = None) -> LoadedScene:
    """Load a scene under a map of radiance, (h, 2 * h, 3), or in a white furnace, in place of its surroundings."""
    if environment is None:
        return load(description.model_copy(update={"environment": ConstantEnvironment()}))
    planes = {name: np.ascontiguousarray(environment[..., i], dtype=np.float32) for i, name in enumerate("RGB")}
    with tempfile.TemporaryDirectory(prefix="glassware-proof-") as folder:
        path = Path(folder) / "map.exr"
        OpenEXR.File({}, planes).write(str(path))
        return load(description.model_copy(update={"environment": PictureEnvironment(asset=asset(path))}))


def alone(description: Scene) -> Scene:
    """Return a scene with its vessels and nothing else: the table far too small to be met, no props, no lamps."""
    return description.model_copy(update={"table": _speck(), "props": (), "lights": ()})


def _speck() -> Table:
    mesh = Mesh("table", _TABLE, np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    return Table(mesh=mesh, material=scenes.matte(), size=(1e-5, 1e-5, 1e-5))
