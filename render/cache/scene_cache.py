"""The irradiance cache of a scene: when it is used, how many paths fill it, and its check against path tracing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream_seed
from ...procedural.description.scene import TABLE_ID, Scene
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.file_light import is_outdoors
from .._mitsuba import mi
from ..frame import LightCheck, RegionCheck, Remedy, SurfaceLight
from ..pictures.picture import Tracer
from ..scene.loaded_scene import LoadedScene
from .cache_points import CachePoints, cache_points_of
from .fill_cache import fill_cache
from .irradiance_cache import IrradianceCache
from .light_check import BOUND, check_regions, is_within, regions_of
from .light_sources import targets_of
from .stored_caustics import path_tracer_with_caustics
from .trace_cached import cached_tracer

#: Camera samples of a whole scene above which the cache is used by default. Below, filling it costs more time than it
#: saves (docs/performance.md).
CACHE_THRESHOLD = 1e7
#: The same under an open sky, where path tracing misses the caustics of the sun: about one picture of 320x240 pixels.
OUTDOOR_THRESHOLD = 1e6
#: Paths that fill the cache, as a fraction of the camera samples; and the fewest and most per cache point on average.
_PATH_FRACTION, _FEWEST_PATHS, _MOST_PATHS = 0.1, 6, 40
#: Photons per fine cell of the grid, of the area that the glass takes light from; and the fewest and most of a scene.
#: Somewhat less than half of them land: light as strong as without glass has a noise of a quarter in one cell before
#: the filter, caustics less.
_PHOTONS_PER_CELL, _FEWEST_PHOTONS, _MOST_PHOTONS = 32, 1 << 17, 1 << 23
#: Comparisons of a scene at most [1]: noise hides a region's fault from the first one in a few scenes.
_ATTEMPTS = 3


def uses_cache(scene: Scene) -> bool:
    """Return whether the scene is rendered with the irradiance cache (`picture.light`).

    Scenes with props that shine are path traced: the cache, its photons and its check know lamps and the sky alone. So
    are scenes in which glass casts no shadows or has a film of air on liquids.

    Raises
    ------
    InputError
        If the scene asks for the cache and the active variant is not an RGB variant, or a prop shines.
    """
    if scene.picture.light == "path" or not scene.picture.glass_shadows or scene.picture.air_gap:
        return False
    rgb = mi.is_rgb and not mi.is_polarized
    required = scene.picture.light == "shared" or scene.picture.keep_light
    shining = next((prop.name for prop in scene.props if any(piece.material.emission for piece in prop.pieces)), None)
    if shining is not None:
        if required:
            raise InputError("picture.light", f"path or auto, as {shining} shines by itself", "shared")
        return False
    if required and not rgb:
        raise InputError("picture.light", "path, or an RGB variant such as llvm_ad_rgb", f"shared in {mi.variant()}")
    return rgb and (required or _camera_samples(scene) >= _threshold(scene))


def _threshold(scene: Scene) -> float:
    environment = scene.environment
    outdoors = bool(scene.vessels) and is_outdoors(environment, bake_environment(environment))
    return OUTDOOR_THRESHOLD if outdoors else CACHE_THRESHOLD


def _camera_samples(scene: Scene) -> float:
    return float(sum(2 * camera.width * camera.height for camera in scene.cameras)) * scene.picture.spp


def make_tracer(loaded: LoadedScene) -> tuple[Tracer, LightCheck, IrradianceCache]:
    """Fill the irradiance cache of a scene, and compare pictures from it with path-traced ones.

    The table and props with a region beyond the bound are path traced, and the comparison is repeated. If a region is
    beyond it then, as that of a vessel, the whole scene is path traced. Caustics are read from the photon map in any
    case.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.

    Returns
    -------
    tracer : Tracer
        The cached tracer; the path tracer, which reads caustics, where the check failed.
    check : LightCheck
        Result of the comparison.
    cache : IrradianceCache
        The filled cache.
    """
    scene = loaded.description
    cache = fill_scene_cache(loaded)
    regions = regions_of(loaded, cache)
    reference = path_tracer_with_caustics(loaded, cache)
    may_be_traced = {TABLE_ID} | {prop.id for prop in scene.props}
    failed, traced, attempt = (), (), 0
    while True:
        tracer = cached_tracer(loaded, cache, traced)
        checks = check_regions(loaded, tracer, reference, regions, which=attempt)
        beyond = tuple(check for check in checks if not is_within(check) and check.id not in traced)
        failed, attempt = failed + beyond, attempt + 1
        more = {check.id for check in beyond} & may_be_traced
        if not more or attempt == _ATTEMPTS:
            break
        traced = tuple(sorted({*traced, *more}))
    passed = not beyond
    failed = tuple(replace(region, remedy=_remedy(region, passed, traced)) for region in failed)
    check = LightCheck(
        scene_id=scene.scene_id,
        mode="shared" if passed else "path",
        difference=float(np.mean([check.difference for check in checks])) if checks else 0.0,
        standard_error=float(np.sqrt(sum(check.standard_error**2 for check in checks)) / max(len(checks), 1)),
        bound=BOUND,
        pixels=sum(check.pixels for check in checks),
        nodes=cache.points.count,
        paths=int(cache.samples.sum()),
        photons=cache.photons,
        regions=tuple(checks),
        failed=failed,
        traced=traced if passed else (),
    )
    return (tracer if passed else reference), check, cache


def _remedy(region: RegionCheck, passed: bool, traced: tuple[int, ...]) -> Remedy:
    if not passed:
        return "scene path traced"
    return "object path traced" if region.id in traced else "other objects path traced"


def fill_scene_cache(loaded: LoadedScene) -> IrradianceCache:
    """Fill the irradiance cache of a scene: paths in proportion to its camera samples, photons to its glass."""
    scene, points = loaded.description, cache_points_of(loaded)
    paths = int(np.clip(_PATH_FRACTION * _camera_samples(scene) / points.count, _FEWEST_PATHS, _MOST_PATHS))
    seed = stream_seed(scene.seed, scene.scene_id, "render/light")
    return fill_cache(loaded, points, paths, seed, photon_count(scene, points))


def photon_count(scene: Scene, points: CachePoints) -> int:
    """Return the number of photons of a scene."""
    cells = targets_of(scene).area / points.fine**2
    return int(np.clip(_PHOTONS_PER_CELL * cells, _FEWEST_PHOTONS, _MOST_PHOTONS))


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
