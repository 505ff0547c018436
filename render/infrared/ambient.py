"""Ambient light in the infrared pictures: the light of the colour pictures, and what daylight has beyond red.

Lamps of today (white LEDs) send out visible light alone: surfaces scatter it by their colours. Daylight goes on in the
near infrared, which the cameras see as well, and there surfaces have other reflectances. Both are rendered at once,
with reflectances that are the mean of both by power.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import cv2
import numpy as np

from ...procedural.description.camera import Camera
from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import SkyEnvironment
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.metering import irradiance
from ...procedural.surroundings.shipped_light import is_shipped_by_day
from ..frame import Eye
from ..pictures.picture import Tracer, denoise_image, trace_picture
from ..scene.loaded_scene import LoadedScene
from .reflectances import infrared_reflectances

#: Samples of a pixel of ambient light [1].
_SPP = 4
#: Illuminance of the table from which on light is taken for daylight [klx]: offices have 0.5 (EN 12464-1), studios 2,
#: and the shade of an open sky 10.
_DAYLIGHT = 5.0
#: Part of daylight's power between 400 and 1000 nm that is beyond 700 nm [1]: 290 of 720 W/m^2 (ASTM G173-03, global).
BEYOND_RED = 0.4


def is_daylight(scene: Scene) -> bool:
    """Return whether a scene's light is daylight.

    An open sky has it, and the maps of the package that were taken outdoors by day. Other surroundings are taken for
    lit by it where there is more light on the table than lamps give.
    """
    environment = scene.environment
    if isinstance(environment, SkyEnvironment) or is_shipped_by_day(environment):
        return True
    level = irradiance(bake_environment(environment), environment.strength, scene.lights)
    return float(luminance(level)) > _DAYLIGHT


def trace_ambient(
    loaded: LoadedScene, seen: tuple[Camera, Eye], coarser: int, seed: int, tracer: Tracer, daylight: bool
) -> np.ndarray:
    """Return the ambient light, (H, W) float32 in the unit of the pictures: the mean of their three channels.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    seen : Camera, {"left", "right"}
        The infrared cameras, and which of them.
    coarser : int
        How many of their pixels across and down one rendered pixel has.
    seed : int
        Of the samples.
    tracer : Tracer
        The tracer of the scene's pictures.
    daylight : bool
        Whether a part of the light is beyond red.
    """
    pair, eye = seen
    scene = loaded.description
    picture = scene.picture.model_copy(update={"spp": _SPP, "noise": None})
    quick = replace(loaded, description=scene.model_copy(update={"picture": picture}))
    with infrared_reflectances(loaded, BEYOND_RED) if daylight else nullcontext():
        image = trace_picture(quick, _coarse(pair, coarser), eye, seed, tracer)
        light = (denoise_image(image) if scene.picture.denoise else image.radiance).mean(axis=2)
    rows, columns = (side * coarser for side in light.shape)
    return cv2.resize(light, (columns, rows), interpolation=cv2.INTER_LINEAR)[: pair.height, : pair.width]


def _coarse(camera: Camera, coarser: int) -> Camera:
    """Return a camera whose pixels cover squares of another's; the last ones may reach beyond its picture."""
    cx, cy = camera.centre
    return camera.model_copy(
        update={
            "width": -(-camera.width // coarser),
            "height": -(-camera.height // coarser),
            "focal": camera.focal / coarser,
            "centre": ((cx + 0.5) / coarser - 0.5, (cy + 0.5) / coarser - 0.5),
        }
    )
