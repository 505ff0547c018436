"""The irradiance cache of a scene: when it is used, how many paths fill it, and its check against path tracing."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream, stream_seed
from ...procedural.description.scene import TABLE_ID, Scene
from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..frame import LightCheck, SurfaceLight
from ..pictures.picture import PATH_TRACER, Tracer, camera_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .cache_points import cache_points_of
from .fill_cache import fill_cache
from .irradiance_cache import IrradianceCache
from .trace_cached import cached_tracer

#: Camera samples of a whole scene above which the cache is used by default. Below, filling it costs more time than it
#: saves (docs/performance.md).
CACHE_THRESHOLD = 1e8
#: Paths that fill the cache, as a fraction of the camera samples; and the fewest and most per cache point on average.
_PATH_FRACTION, _FEWEST_PATHS, _MOST_PATHS = 0.1, 16, 40
#: The check: number of pixels, of views that they are taken from at most, and samples of each pixel by both methods.
_CHECK_PIXELS, _CHECK_VIEWS, _CHECK_SAMPLES = 1024, 8, 128
#: Largest difference of the mean over these pixels [fraction of the mean], beyond this number of standard errors.
BOUND, _STANDARD_ERRORS = 0.01, 3.0


def uses_cache(scene: Scene) -> bool:
    """Return whether the scene is rendered with the irradiance cache (`picture.light`).

    Raises
    ------
    InputError
        If the scene asks for the cache and the active variant is not an RGB variant.
    """
    if scene.picture.light == "path":
        return False
    rgb = mi.is_rgb and not mi.is_polarized
    required = scene.picture.light == "shared" or scene.picture.keep_light
    if required and not rgb:
        raise InputError("picture.light", "path, or an RGB variant such as llvm_ad_rgb", f"shared in {mi.variant()}")
    return rgb and (required or _camera_samples(scene) >= CACHE_THRESHOLD)


def _camera_samples(scene: Scene) -> float:
    return float(sum(2 * camera.width * camera.height for camera in scene.cameras)) * scene.picture.spp


def make_tracer(loaded: LoadedScene) -> tuple[Tracer, LightCheck, IrradianceCache]:
    """Fill the irradiance cache of a scene, and compare pictures from it with path-traced ones.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.

    Returns
    -------
    tracer : Tracer
        The cached tracer; the path tracer where the check failed.
    check : LightCheck
        Result of the comparison.
    cache : IrradianceCache
        The filled cache.
    """
    scene = loaded.description
    cache = fill_scene_cache(loaded)
    tracer = cached_tracer(loaded, cache)
    difference, error = compare_with_paths(loaded, tracer)
    passed = abs(difference) <= BOUND + _STANDARD_ERRORS * error
    check = LightCheck(
        scene_id=scene.scene_id,
        mode="shared" if passed else "path",
        difference=difference,
        standard_error=error,
        bound=BOUND,
        pixels=_CHECK_PIXELS,
        nodes=cache.points.count,
        paths=int(cache.samples.sum()),
    )
    return (tracer if passed else PATH_TRACER), check, cache


def fill_scene_cache(loaded: LoadedScene) -> IrradianceCache:
    """Fill the irradiance cache of a scene with a number of paths in proportion to its camera samples."""
    scene, points = loaded.description, cache_points_of(loaded)
    paths = int(np.clip(_PATH_FRACTION * _camera_samples(scene) / points.count, _FEWEST_PATHS, _MOST_PATHS))
    return fill_cache(loaded, points, paths, stream_seed(scene.seed, scene.scene_id, "render/light"))


def compare_with_paths(loaded: LoadedScene, tracer: Tracer) -> tuple[float, float]:
    """Return the relative difference of a tracer's pictures from path-traced ones, and its standard error.

    Both are fractions of the mean luminance of random pixels of the left pictures. The standard error covers the
    samples of both methods and the choice of pixels, but not the noise of the cache, which all pixels share.
    """
    scene = loaded.description
    rng = stream(scene.seed, scene.scene_id, "render/light/check")
    views = rng.permutation(len(scene.cameras))[:_CHECK_VIEWS]
    pairs = [_luminances(loaded, tracer, int(view), rng, _CHECK_PIXELS // len(views)) for view in views]
    by_paths, by_tracer = (np.concatenate(values) for values in zip(*pairs, strict=True))
    level, difference = float(by_paths.mean()), by_tracer - by_paths
    if level <= 0.0:
        return 0.0, 0.0
    return float(difference.mean() / level), float(difference.std(ddof=1) / np.sqrt(len(by_paths)) / level)


def _luminances(
    loaded: LoadedScene, tracer: Tracer, view: int, rng: np.random.Generator, pixels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the luminance of random pixels by the path tracer and by a tracer."""
    camera, seeds = loaded.description.cameras[view], rng.integers(0, 1 << 32, 2)
    pixel = rng.integers(0, camera.width * camera.height, pixels).astype(np.uint32)
    values = []
    for seed, method in zip(seeds, (PATH_TRACER, tracer), strict=True):
        first, count = np.zeros_like(pixel), _CHECK_SAMPLES
        ray, weight, points = camera_paths(pinhole(camera), pixel, first, count, count, int(seed))
        radiance = method.trace(loaded, ray, weight, points, loaded.description.picture).radiance
        dr.eval(radiance)
        means = [np.array(dr.block_sum(channel, _CHECK_SAMPLES), np.float64) / _CHECK_SAMPLES for channel in radiance]
        values.append(luminance(np.stack(means, axis=1)))
    return values[0], values[1]


def surface_light(loaded: LoadedScene, cache: IrradianceCache) -> SurfaceLight:
    """Return the irradiance cache as a list of points, in the order of the cache points.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.
    cache : IrradianceCache
        Its irradiance cache.
    """
    points = cache.points
    x, y = (axis.coordinate(np.arange(axis.lines)) for axis in points.axes)
    grid = np.stack([np.tile(x, len(y)), np.repeat(y, len(x)), np.zeros(points.grid_count)], axis=1)
    up = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (points.grid_count, 1))
    instance = np.array(loaded.surfaces.instance)
    ids = [np.full(points.grid_count, TABLE_ID)]
    for body in loaded.opaque_bodies:
        sides = 1 if body.closed else 2
        ids.append(np.full(sides * len(body.positions), instance[body.row]))
    return SurfaceLight(
        id=np.concatenate(ids).astype(np.uint16),
        position=np.concatenate([grid.astype(np.float32), points.positions]),
        normal=np.concatenate([up, points.normals / np.linalg.norm(points.normals, axis=1, keepdims=True)]),
        irradiance=np.ascontiguousarray(cache.moments[:, :3], np.float32),
        paths=cache.samples.astype(np.uint32),
    )
