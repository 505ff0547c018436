"""Check of the irradiance cache against path tracing, by object and by region.

A mean over the whole picture hides a caustic that is missing on one prop. So pixels are drawn from each region alone:
each vessel, the more and the less lit half of each prop, and of the table its caustics, its shadows and the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...core.randomness import stream
from ...procedural.description.scene import TABLE_ID, GlassBody, Scene
from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..frame import RegionCheck
from ..labels.geometry import trace_geometry
from ..pictures.picture import Tracer, camera_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole, pixel_rays
from ..scene.surfaces import registry_id
from .cache_points import interpolation_weights, lookup_of
from .irradiance_cache import IrradianceCache, interpolated

#: Largest difference of a region's mean [fraction], and the number of standard errors that count as noise.
BOUND, STANDARD_ERRORS = 0.02, 3.0
#: Pixels of a region in the first comparison, and in further ones of regions that were beyond the bound; the last one
#: decides. (Fireflies make the mean of few pixels differ, and their standard error too small.)
_PIXELS = (128, 512, 2048)
#: Samples of each pixel by both methods, and views that pixels are taken from at most.
_SAMPLES, _VIEWS = 64, 4
#: Samples of a pixel that its sequence has room for [1].
MAX_SAMPLES = 1 << 14
#: Standard deviation of the window in which light is averaged to tell parts of an object [px].
_WINDOW = 3.0
#: Regions of fewer pixels in these views are left out: nobody sees them.
_MIN_PIXELS = 24
#: Irradiance over the table's median from which its points are caustics, and below which they are shadows [1].
_CAUSTIC, _SHADOW = 1.4, 0.5


@dataclass(frozen=True, eq=False)
class Region:
    """Pixels of the left pictures that show one part of one object."""

    id: int  #: of the object
    part: str  #: "all", "lit", "shaded", "caustic", "shadow" or "open"
    view: np.ndarray  #: (n,)
    pixel: np.ndarray  #: (n,)


def check_regions(
    loaded: LoadedScene, tracer: Tracer, reference: Tracer, regions: list[Region], which: int = 0
) -> list[RegionCheck]:
    """Compare a tracer with another in each region.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    tracer : Tracer
        The tracer that reads the cache.
    reference : Tracer
        The path tracer (`stored_caustics.path_tracer_with_caustics`).
    regions : list of Region
        The regions.
    which : int
        Number of the check: another one draws other samples.
    """
    checks: dict[int, RegionCheck] = {}
    doubtful = list(range(len(regions)))
    for number, pixels in enumerate(_PIXELS):
        chosen = [regions[k] for k in doubtful]
        found = _compare(loaded, (reference, tracer), chosen, pixels, f"{which}/{number}")
        checks |= dict(zip(doubtful, found, strict=True))
        doubtful = [k for k in doubtful if abs(checks[k].difference) > BOUND]
    return [checks[k] for k in range(len(regions))]


def is_within(check: RegionCheck) -> bool:
    """Return whether a region's light is that of path tracing, within the bound or the noise."""
    return abs(check.difference) <= max(BOUND, STANDARD_ERRORS * check.standard_error)


def regions_of(loaded: LoadedScene, cache: IrradianceCache) -> list[Region]:
    """Return the regions of a scene that its views show."""
    scene = loaded.description
    rng = stream(scene.seed, scene.scene_id, "render/light/check/views")
    views = np.sort(rng.permutation(len(scene.cameras))[:_VIEWS])
    ids = [trace_geometry(loaded, scene.cameras[view]).id.ravel() for view in views]
    view = np.concatenate([np.full(len(one), number) for number, one in zip(views, ids, strict=True)])
    pixel = np.concatenate([np.arange(len(one)) for one in ids])
    light, seen = _smoothed(_irradiance(loaded, cache, views), ids, scene, views), np.concatenate(ids)
    regions = []
    for item_id, parts in _parts(scene, seen, light):
        for part, chosen in parts:
            if len(chosen) >= _MIN_PIXELS:
                regions.append(Region(item_id, part, view[chosen], pixel[chosen]))
    return regions


def _parts(scene: Scene, seen: np.ndarray, light: np.ndarray) -> list[tuple[int, list[tuple[str, np.ndarray]]]]:
    """Return the parts of each object: their names and indices into `seen`, the id of each pixel."""
    table = np.flatnonzero(seen == TABLE_ID)
    level = light[table] / max(float(np.median(light[table])), 1e-30) if len(table) else light[table]
    caustic, shadow = level > _CAUSTIC, level < _SHADOW
    result = [(TABLE_ID, [("caustic", table[caustic]), ("shadow", table[shadow]), ("open", table[~caustic & ~shadow])])]
    for item in scene.objects:
        pixels = np.flatnonzero(seen == item.id)
        if isinstance(item, GlassBody):
            result.append((item.id, [("all", pixels)]))
        elif len(pixels):
            lit = light[pixels] > np.median(light[pixels])
            result.append((item.id, [("lit", pixels[lit]), ("shaded", pixels[~lit])]))
    return result


def _smoothed(light: np.ndarray, ids: list[np.ndarray], scene: Scene, views: np.ndarray) -> np.ndarray:
    """Return the light of pixels averaged over a window, object by object.

    Parts that are chosen by their light must not be chosen by its noise: the brighter half of an evenly lit plate would
    be the one whose noise is positive.
    """
    result, first = light.copy(), 0
    for view, seen in zip(views, ids, strict=True):
        shape = scene.cameras[view].height, scene.cameras[view].width
        image, id_image = light[first : first + seen.size].reshape(shape), seen.reshape(shape)
        for one in np.unique(seen):
            inside = id_image == one
            result[first : first + seen.size][inside.ravel()] = _window_mean(image, inside)[inside]
        first += seen.size
    return result


def _window_mean(image: np.ndarray, inside: np.ndarray) -> np.ndarray:
    weight = inside.astype(np.float64)
    total, count = (cv2.GaussianBlur(x, (0, 0), _WINDOW) for x in (image * weight, weight))
    return np.divide(total, count, out=np.zeros_like(total), where=count > 0.0)


def _irradiance(loaded: LoadedScene, cache: IrradianceCache, views: np.ndarray) -> np.ndarray:
    """Return the luminance of the stored irradiance at the first surface of each pixel; meaningless for glass."""
    lookup, moments = lookup_of(cache.points), mi.Float(np.ascontiguousarray(cache.moments, np.float32).ravel())
    dr.make_opaque(moments)
    values = []
    for view in views:
        camera = loaded.description.cameras[view]
        pixel = dr.arange(mi.UInt32, camera.width * camera.height)
        ray, _ = pixel_rays(pinhole(camera), pixel, mi.Point2f(0.0))
        pi = loaded.mi_scene.ray_intersect_preliminary(ray, True)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.All)
        row = registry_id(si.shape)
        opaque = si.is_valid() & dr.gather(mi.Bool, loaded.surfaces.opaque, row, si.is_valid())
        instance = dr.gather(mi.UInt32, loaded.surfaces.instance, row, si.is_valid())
        opaque &= instance > 0
        index, weight = interpolation_weights(lookup, si, pi.prim_uv, -ray.d, instance == TABLE_ID)
        index = [dr.select(opaque, i, 0) for i in index]
        E = mi.luminance(interpolated(moments, index, weight).E)
        values.append(np.array(dr.select(opaque, E, 0.0), np.float64))
    return np.concatenate(values)


def _compare(
    loaded: LoadedScene, tracers: tuple[Tracer, Tracer], regions: list[Region], pixels: int, name: str
) -> list[RegionCheck]:
    """Return by how much the second tracer differs from the first in each region, from random pixels of it."""
    if not regions:
        return []
    scene = loaded.description
    rng = stream(scene.seed, scene.scene_id, f"render/light/check/{name}")
    chosen = [rng.integers(0, len(region.pixel), pixels) for region in regions]
    view = np.concatenate([region.view[k] for region, k in zip(regions, chosen, strict=True)])
    pixel = np.concatenate([region.pixel[k] for region, k in zip(regions, chosen, strict=True)])
    by_paths, by_tracer = (
        _luminances(loaded, method, view, pixel, int(rng.integers(0, 1 << 32))) for method in tracers
    )
    checks = []
    for number, region in enumerate(regions):
        part = slice(number * pixels, (number + 1) * pixels)
        level, difference = float(by_paths[part].mean()), by_tracer[part] - by_paths[part]
        scale = level if level > 0.0 else 1.0
        error = float(difference.std(ddof=1) / np.sqrt(pixels) / scale)
        checks.append(RegionCheck(region.id, region.part, pixels, float(difference.mean() / scale), error))
    return checks


def _luminances(loaded: LoadedScene, method: Tracer, view: np.ndarray, pixel: np.ndarray, seed: int) -> np.ndarray:
    """Return the luminance of pixels of the left pictures by a tracer."""
    result = np.zeros(len(pixel))
    for number in np.unique(view):
        here = np.flatnonzero(view == number)
        # The position in the list is the pixel of the sampler: a pixel that is drawn twice gets other samples.
        ray, weight, sampler = camera_paths(
            pinhole(loaded.description.cameras[number]),
            pixel[here].astype(np.uint32),
            (np.arange(len(here), dtype=np.uint32) * _SAMPLES) % (1 << 20),
            _SAMPLES,
            MAX_SAMPLES,
            (seed + int(number)) % (1 << 32),
        )
        radiance = method.trace(loaded, ray, weight, sampler, loaded.description.picture).radiance
        dr.eval(radiance)
        means = [np.array(dr.block_sum(channel, _SAMPLES), np.float64) / _SAMPLES for channel in radiance]
        result[here] = luminance(np.stack(means, axis=1))
    return result
