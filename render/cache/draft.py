"""A first look at a scene before its light is stored: small, noisy, and without caustics."""

from __future__ import annotations

import numpy as np

from ...core.randomness import stream_seed
from ...procedural.description.camera import Camera
from .._mitsuba import dr
from ..frame import Draft
from ..pictures.picture import camera_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .cache_points import cache_points_of
from .irradiance_cache import MOMENTS
from .light_check import MAX_SAMPLES
from .stored_caustics import path_tracer_with_photons

#: Most pixels of a draft [px], and the samples of each [1]: a second of work on two cores.
_PIXELS, _SAMPLES = 160 * 120, 16


def draft_picture(loaded: LoadedScene) -> Draft:
    """Return a small path-traced picture of the first view's left eye.

    Its kernel is that of the light's check, with a photon map in which no photon has landed: it is compiled once for
    both.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.
    """
    scene = loaded.description
    camera = smaller(scene.cameras[0], _PIXELS)
    points = cache_points_of(loaded)
    tracer = path_tracer_with_photons(loaded, points, np.zeros((points.count, MOMENTS)))
    pixel = np.arange(camera.width * camera.height, dtype=np.uint32)
    seed = stream_seed(scene.seed, scene.scene_id, "render/draft")
    ray, weight, sampler = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), _SAMPLES, MAX_SAMPLES, seed)
    radiance = tracer.trace(loaded, ray, weight, sampler, scene.picture).radiance
    dr.eval(radiance)
    means = [np.array(dr.block_sum(channel, _SAMPLES), np.float32) / _SAMPLES for channel in radiance]
    linear = np.stack(means, axis=1).reshape(camera.height, camera.width, 3)
    return Draft(linear, camera.exposure, camera.tone)


def smaller(camera: Camera, pixels: int) -> Camera:
    """Return a camera of the same field of view with at most a number of pixels; one that is that small as it is."""
    scale = min(1.0, float(np.sqrt(pixels / (camera.width * camera.height))))
    return resized(camera, max(1, int(camera.width * scale)), max(1, int(camera.height * scale)))


def resized(camera: Camera, width: int, height: int) -> Camera:
    """Return a camera of the same field of view with other sides [px]."""
    along = width / camera.width, height / camera.height
    cx, cy = ((centre + 0.5) * factor - 0.5 for centre, factor in zip(camera.centre, along, strict=True))
    sizes = {"width": width, "height": height, "focal": camera.fx * along[0], "focal_y": camera.fy * along[1]}
    return camera.model_copy(update={**sizes, "centre": (cx, cy)})
