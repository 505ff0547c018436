"""Objects side by side for a contact sheet: one scene, with a camera for each of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...core.pose import look_at
from ..description.material import OpaqueMaterial, ProceduralTexture
from ..description.picture import Picture
from ..description.scene import GlassBody, Prop, Scene, glass_solid
from ..description.surroundings import AreaLight, ConstantEnvironment
from .scenes import board, camera, matte, metered, scene

#: Distance between the middles of neighbours [m]: above twice the longest side of a prop, so that none shades another.
SPACING = 1.4
#: Direction from an object to its camera: from the front and above, slightly from the side.
_TO_CAMERA = np.array([0.45, -0.8, 0.5])
#: Distance of the camera over the radius of the object's bounding ball, for a field of view of 53 degrees [1].
_DISTANCE = 2.9
#: A large lamp above the left of the camera [m, m], and its radiance over that of the even sky [1].
_LAMP, _LAMP_RADIANCE = 6.0, 6.0
#: What the board has beyond the outermost objects [m]: behind a tall one, its edge would be in the picture.
_BORDER = 3.0
#: Of the board below glass: squares of some centimetres, whose lines refraction bends.
_CHECKERED = OpaqueMaterial(
    name="checkered",
    base_colour=ProceduralTexture(kind="checker", colours=((0.42, 0.36, 0.29), (0.2, 0.17, 0.14)), seed=1),
    repeats=4.0,
    roughness=0.6,
)


def display(objects: Sequence[Prop | GlassBody], width: int = 240, height: int = 200, spp: int = 16) -> Scene:
    """Return a scene of objects upright on a board, in their order, each before a camera of its own.

    They are under an even sky with a lamp. The board is grey; for glass, which shows what is behind it, checkered.

    Parameters
    ----------
    objects : sequence of Prop or GlassBody
        At their origins, with ids and names of their own.
    width, height : int
        Of each picture [px].
    spp : int
        Samples per pixel.
    """
    across = math.ceil(math.sqrt(len(objects)))
    placed, cameras = [], []
    for number, item in enumerate(objects):
        x, y = SPACING * (number % across - 0.5 * (across - 1)), SPACING * (number // across - 0.5 * (across - 1))
        mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
        pose = np.eye(4)
        # A tenth of a millimetre above the board, as in drawn scenes.
        pose[:3, 3] = [x, y, 1e-4 - float(mesh.bounds[0, 2])]
        placed.append(item.model_copy(update={"world_T_object": pose}))
        radius = 0.5 * float(np.linalg.norm(item.size))
        target = pose[:3, 3]
        eye = target + _DISTANCE * radius * _TO_CAMERA / np.linalg.norm(_TO_CAMERA)
        cameras.append(camera(tuple(eye), tuple(target), width=width, height=height, baseline=0.1 * radius))
    side = SPACING * across + _BORDER
    glass = all(isinstance(item, GlassBody) for item in placed)
    return metered(
        scene(
            [item for item in placed if isinstance(item, GlassBody)],
            cameras,
            props=[item for item in placed if isinstance(item, Prop)],
            table=board((side, side, 0.03), _CHECKERED if glass else matte((0.35, 0.35, 0.35))),
            environment=ConstantEnvironment(radiance=(0.6, 0.6, 0.6)),
            lights=[_lamp(side)],
            picture=Picture(spp=spp, light="path", layers=0, refraction=False),
        )
    )


def _lamp(side: float) -> AreaLight:
    pose = look_at(np.array([-side, -side, _LAMP]), np.zeros(3))
    return AreaLight(world_T_light=pose, size=(2.0, 2.0), radiance=(_LAMP_RADIANCE, _LAMP_RADIANCE, _LAMP_RADIANCE))
