"""When the light of a scene is stored, how well, and the proof that it is right."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream, stream_seed
from ...procedural.description.scene import Scene
from ...procedural.surroundings.colour import luminance
from ..frame import LightCheck
from ..pictures.picture import PATH_TRACER, Tracer, camera_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .cache_points import cache_points_of
from .fill_cache import fill_cache
from .irradiance_cache import IrradianceCache
from .trace_cached import cached_tracer

#: Samples of all pictures of a scene from which on its light is stored, unless asked otherwise. Below, storing it costs
#: more than it saves (docs/performance.md).
WORTH_IT = 1e8
#: Paths that store the light, over the camera's; and the fewest and most of a node on the average.
_SHARE, _FEWEST, _MOST = 0.1, 16, 40
#: The check: pixels, spread over at most so many views, and samples of each by both ways.
_PIXELS, _VIEWS, _SAMPLES = 1024, 8, 128
#: Most that the mean over these pixels may differ [share of it], beyond `_DOUBT` standard errors.
BOUND, _DOUBT = 0.01, 3.0


def is_shared(scene: Scene) -> bool:
    """Return whether the scene's pictures are to read stored light.

    Raises
    ------
    InputError
        If that is asked for in a variant other than RGB.
    """
    if scene.picture.light == "path":
        return False
    rgb = mi.is_rgb and not mi.is_polarized
    asked = scene.picture.light == "shared" or scene.picture.keep_light
    if asked and not rgb:
        raise InputError("picture.light", "path, or an RGB variant such as llvm_ad_rgb", f"shared in {mi.variant()}")
    return rgb and (asked or _camera_samples(scene) >= WORTH_IT)


def _camera_samples(scene: Scene) -> float:
    return float(sum(2 * camera.width * camera.height for camera in scene.cameras)) * scene.picture.spp


def shared_light(kernel: LoadedScene) -> tuple[Tracer, LightCheck, IrradianceCache]:
    """Store a scene's light, and compare it with paths.

    Parameters
    ----------
    kernel : LoadedScene
        The scene, loaded for the cache.

    Returns
    -------
    tracer : Tracer
        What `trace_picture` is to be given: paths where the check failed.
    check : LightCheck
        What the comparison found.
    stored : IrradianceCache
        The light.
    """
    scene = kernel.description
    stored = stored_light(kernel)
    tracer = cached_tracer(kernel, stored)
    difference, error = compared(kernel, tracer)
    fine = abs(difference) <= BOUND + _DOUBT * error
    check = LightCheck(
        scene_id=scene.scene_id,
        mode="shared" if fine else "path",
        difference=difference,
        standard_error=error,
        bound=BOUND,
        pixels=_PIXELS,
        nodes=stored.points.count,
        paths=int(stored.samples.sum()),
    )
    return (tracer if fine else PATH_TRACER), check, stored


def stored_light(kernel: LoadedScene) -> IrradianceCache:
    """Return the light at all nodes of the scene, by as many paths as its pictures make worth while."""
    scene, nodes = kernel.description, cache_points_of(kernel)
    paths = int(np.clip(_SHARE * _camera_samples(scene) / nodes.count, _FEWEST, _MOST))
    return fill_cache(kernel, nodes, paths, stream_seed(scene.seed, scene.scene_id, "render/light"))


def compared(kernel: LoadedScene, tracer: Tracer) -> tuple[float, float]:
    """Return how much brighter pictures from stored light are than path-traced ones, and the standard error.

    Both are shares of the mean light of random pixels of the left pictures. The error is that of both ways' samples
    and of the choice of pixels; the noise of the stored light, which all pixels share, is not in it.
    """
    scene = kernel.description
    rng = stream(scene.seed, scene.scene_id, "render/light/check")
    views = rng.permutation(len(scene.cameras))[:_VIEWS]
    pairs = [_pairs(kernel, tracer, int(view), rng, _PIXELS // len(views)) for view in views]
    paths, stored = (np.concatenate(values) for values in zip(*pairs, strict=True))
    level, difference = float(paths.mean()), stored - paths
    if level <= 0.0:
        return 0.0, 0.0
    return float(difference.mean() / level), float(difference.std(ddof=1) / np.sqrt(len(paths)) / level)


def _pairs(
    kernel: LoadedScene, tracer: Tracer, view: int, rng: np.random.Generator, pixels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the luminance of random pixels by paths and from stored light."""
    camera, seeds = kernel.description.cameras[view], rng.integers(0, 1 << 32, 2)
    pixel = rng.integers(0, camera.width * camera.height, pixels).astype(np.uint32)
    values = []
    for seed, way in zip(seeds, (PATH_TRACER, tracer), strict=True):
        ray, weight, points = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), _SAMPLES, _SAMPLES, int(seed))
        radiance = way.trace(kernel, ray, weight, points, kernel.description.picture).radiance
        dr.eval(radiance)
        means = [np.array(dr.block_sum(channel, _SAMPLES), np.float64) / _SAMPLES for channel in radiance]
        values.append(luminance(np.stack(means, axis=1)))
    return values[0], values[1]
