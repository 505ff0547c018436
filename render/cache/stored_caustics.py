"""Caustics read from the photon map: by the paths that fill the irradiance cache, and by those that check it.

Where a path meets an opaque surface, the diffuse lobe's light through glass is read. If BSDF sampling then leads
through glass to an emitter, only the glossy lobe's part of what it finds is added: nothing is counted twice.
"""

from __future__ import annotations

import numpy as np

from ...procedural.description.picture import Picture
from ...procedural.description.scene import TABLE_ID
from .._mitsuba import dr, mi
from ..pictures.integrator import Bounce, Radiance, StoredCaustics, trace
from ..pictures.picture import PATH_TRACER, Tracer
from ..pictures.sampler import SobolSampler
from ..scene.lighting import sun_glints
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import registry_id
from .cache_points import CachePoints, interpolation_weights, lookup_of
from .irradiance_cache import IrradianceCache, diffuse, material_columns, moments_at, normalised, shading_point
from .lobes import eval_glossy


def stored_caustics(loaded: LoadedScene, points: CachePoints, moments: np.ndarray) -> StoredCaustics:
    """Return how paths read a scene's photon map, and find its sun through glass.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.
    points : CachePoints
        The cache points.
    moments : (count, 12) float64
        The mean of what `photon_map.photon_moments` returns.
    """
    lookup, table = lookup_of(points), loaded.surfaces
    stored = mi.Float(normalised(moments).astype(np.float32).ravel())
    materials = material_columns(loaded)
    dr.make_opaque(stored)

    def shade(
        si: mi.SurfaceInteraction3f, barycentric: mi.Point2f, ray: mi.Ray3f, bounce: Bounce
    ) -> tuple[mi.Color3f, mi.Color3f]:
        row, eye = registry_id(si.shape), -ray.d
        instance = dr.gather(mi.UInt32, table.instance, row)
        point = shading_point(si, eye, materials)
        material, wi = point.material, point.wi
        index, weight = interpolation_weights(lookup, si, barycentric, eye, instance == TABLE_ID)
        radiance = diffuse(material, wi, eye, moments_at(stored, index, weight, point))
        glossy, _ = eval_glossy(material, wi, point.frame.to_local(bounce.direction))
        total = mi.Color3f(bounce.weight) * bounce.pdf
        fraction = dr.select(total > 0.0, dr.clip(glossy / total, 0.0, 1.0), 0.0)
        is_light = instance == 0
        return dr.select(is_light, 0.0, radiance), dr.select(is_light, 1.0, fraction)

    return StoredCaustics(shade, sun_glints(loaded.description))


def path_tracer_with_caustics(loaded: LoadedScene, cache: IrradianceCache) -> Tracer:
    """Return the path tracer that reads caustics from a scene's photon map, and finds all other light by paths.

    Paths from the camera hit the sun through glass once in 100,000 diffuse bounces: a path-traced picture of a few
    hundred samples has none of its caustics, and its noise does not show what is missing.
    """
    return PATH_TRACER if cache.caustics is None else path_tracer_with_photons(loaded, cache.points, cache.caustics)


def path_tracer_with_photons(loaded: LoadedScene, points: CachePoints, moments: np.ndarray) -> Tracer:
    """Return the path tracer that reads caustics from moments of photons, as `stored_caustics` takes them."""
    caustics = stored_caustics(loaded, points, moments)

    def trace_with_caustics(
        loaded: LoadedScene, ray: mi.Ray3f, weight: mi.UnpolarizedSpectrum, sampler: SobolSampler, picture: Picture
    ) -> Radiance:
        return trace(loaded, ray, weight, sampler, picture, caustics=caustics)

    return Tracer(trace_with_caustics, PATH_TRACER.weights)
