"""Denoiser guides (auxiliary images, AOVs) that see through glass, free of noise.

A few rays through every pixel follow smooth glass to the first rough surface without random numbers: refracted at every
interface, and reflected at the first one, weighted by Fresnel and by absorption. A path tracer could record the same on
its way, with the noise of its lobe sampling; cleaning that would take two more passes of the denoiser, which cost more
than these rays.

The rays of a pixel are averaged: where its first rays differ, as at outlines and on fine patterns, more are traced. The
denoiser trusts guides, and would copy the aliasing of too few rays into the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...procedural.description.camera import Camera
from .._mitsuba import dr, mi, syntax
from ..frame import Eye
from ..interfaces.dielectric import transmission
from ..scene.emitters import emitted, ends_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, leave, pinhole, pixel_rays
from ..scene.spectrum import to_guide
from ..scene.surface_maps import mapped_normal, values_at
from ..scene.surfaces import registry_id, relative_index_d, seen_from_air, surface_media, transmittance_rgb
from .sampler import sample_4d, sobol_sampler

#: Rays of every pixel, and additional rays of a pixel that, like one of its neighbours, has first rays that differ by
#: more than `_MAX_RANGE` in a channel of the albedo or a component of the normal [1].
_FIRST_RAYS, _MORE_RAYS, _MAX_RANGE = 4, 12, 0.2
#: Seed of their positions in the pixel. They differ from pixel to pixel: what remains is noise and not a pattern.
_SEED = 0x6D15
#: Maximum number of interfaces of a ray [1]; it carries little light by then, and a guide only has to show shapes.
_MAX_INTERFACES = 16


@dataclass(frozen=True, eq=False)
class Guides:
    """Guides of the denoiser, and which pixels show glass or polished surfaces."""

    albedo: np.ndarray  #: (H, W, 3) float32, reflectance of the first rough surfaces; the sky's exposed radiance
    normal: np.ndarray  #: (H, W, 3) float32, their normals, world frame
    glass: np.ndarray  #: (H, W) bool, whether any ray hits glass first ...
    polished: np.ndarray  #: ... and whether any ray hits a polished opaque surface first
    background: np.ndarray  #: (H, W) bool, whether all rays see the surroundings directly: there is no noise
    instance: np.ndarray  #: (H, W) uint32, id of the object at the pixel's centre


def inner_parts(instance: np.ndarray) -> np.ndarray:
    """Return a number for the inside of each object and another one for its outline, (H, W) int64.

    A rim shines where the rest of a glass is dark. Light that a filter moves within an object must not leave its
    outline, the pixels beside another object.

    Parameters
    ----------
    instance : (H, W) int
        The object of each pixel.
    """
    square, number = np.ones((3, 3), np.uint8), instance.astype(np.float32)
    return 2 * instance.astype(np.int64) + (cv2.dilate(number, square) != cv2.erode(number, square))


@dataclass(frozen=True, eq=False)
class _GuideRays:
    """What rays through smooth glass reach, one entry a ray."""

    ray: mi.Ray3f  #: the last segment
    pi: mi.PreliminaryIntersection3f  #: its end
    weight: mi.Color3f  #: product of Fresnel transmittances and Beer-Lambert factors
    reflected: mi.Ray3f  #: the ray reflected at the first interface
    reflectance: mi.Float  #: Fresnel reflectance there; 0 where no interface was hit
    bounces: mi.UInt32  #: interfaces passed


@dataclass(frozen=True, eq=False)
class _GuideSample:
    """The guides of single rays."""

    albedo: mi.Color3f
    normal: mi.Normal3f
    glass: mi.Bool
    polished: mi.Bool
    background: mi.Bool


def trace_guides(loaded: LoadedScene, camera: Camera, eye: Eye = "left", chosen: np.ndarray | None = None) -> Guides:
    """Return the guides of one eye, and which pixels show glass or polished surfaces.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    chosen : (H, W) bool, optional
        The pixels whose guides are wanted; those of others mean nothing. All by default.

    Returns
    -------
    Guides
        The albedo is in [0, 1]; the sky's radiance is clamped to 1. Normals are weighted like the albedo, and so
        shorter than 1 behind glass.
    """
    view, shape = pinhole(camera, eye), (camera.height, camera.width)
    wanted = np.ones(shape, bool) if chosen is None else chosen
    every = np.flatnonzero(wanted).astype(np.uint32)
    first, spread = _pixel_guides(loaded, view, camera.exposure, every, slice(0, _FIRST_RAYS))
    values, ranges = np.zeros((len(first), wanted.size), first.dtype), np.zeros(wanted.size, spread.dtype)
    values[:, every], ranges[every] = first, spread
    unsure = cv2.dilate((ranges > _MAX_RANGE).astype(np.uint8).reshape(shape), np.ones((3, 3), np.uint8))
    # Pixels of the surroundings alone are not denoised (`denoise.denoised`); those beside objects may show one.
    objects = cv2.dilate((values[-1] < _FIRST_RAYS).astype(np.uint8).reshape(shape), np.ones((3, 3), np.uint8))
    more_rays = (unsure.ravel() > 0) & (objects.ravel() > 0) & wanted.ravel()
    pixel, counts = np.flatnonzero(more_rays).astype(np.uint32), np.full(wanted.size, float(_FIRST_RAYS))
    if len(pixel):
        more = slice(_FIRST_RAYS, _FIRST_RAYS + _MORE_RAYS)
        values[:, pixel] += _pixel_guides(loaded, view, camera.exposure, pixel, more)[0]
        counts[pixel] += _MORE_RAYS
    instance = np.zeros(wanted.size, np.uint32)
    instance[every] = _centre_instances(loaded, view, every)
    albedo, normal, glass, polished, background = np.split((values / counts).astype(np.float32).T, (3, 6, 7, 8), axis=1)
    return Guides(
        albedo=albedo.reshape(*shape, 3),
        normal=normal.reshape(*shape, 3),
        glass=glass.reshape(shape) > 0.0,
        polished=polished.reshape(shape) > 0.0,
        background=background.reshape(shape) == 1.0,
        instance=instance.reshape(shape),
    )


def _centre_instances(loaded: LoadedScene, view: Pinhole, pixel: np.ndarray) -> np.ndarray:
    """Return the ids of what the rays through the centres of pixels hit first, 0 for the surroundings."""
    ray, _ = pixel_rays(view, mi.UInt32(pixel), dr.opaque(mi.Point2f, 0.0))
    pi = loaded.mi_scene.ray_intersect_preliminary(ray, True)
    return np.array(dr.gather(mi.UInt32, loaded.surfaces.instance, registry_id(pi.shape), pi.is_valid()))


def _pixel_guides(
    loaded: LoadedScene, view: Pinhole, exposure: float, pixel: np.ndarray, rays: slice
) -> tuple[np.ndarray, np.ndarray]:
    """Trace rays of each pixel, `rays` of its sequence.

    Returns
    -------
    sums : (9, pixels) float64
        Sums over the rays of albedo, normal and the flags glass, polished and background.
    ranges : (pixels,) float32
        Largest range (maximum minus minimum) of these over the rays of a pixel.
    """
    count = rays.stop - rays.start
    lane = dr.arange(mi.UInt32, len(pixel) * count)
    size = dr.opaque(mi.UInt32, count)
    group = lane // size
    at = dr.gather(mi.UInt32, mi.UInt32(pixel), group)
    # The rays of a pixel are adjacent and are added in a fixed order.
    index = dr.opaque(mi.UInt32, rays.start) + lane - group * size
    sampler = sobol_sampler(at, index, _FIRST_RAYS + _MORE_RAYS, _SEED)
    u, v, *_ = sample_4d(sampler, mi.UInt32(0))
    ray, _ = pixel_rays(view, at, mi.Point2f(u, v) - 0.5)
    exposed = dr.opaque(mi.Float, exposure)
    end = _through_smooth_glass(loaded, ray, True)
    refracted = _shaded(loaded, end, exposed, True)
    is_reflected = end.reflectance > 0.0
    reflected = _shaded(loaded, _through_smooth_glass(loaded, end.reflected, is_reflected), exposed, is_reflected)
    flags = (
        dr.select(flag, mi.Float(1.0), 0.0) for flag in (refracted.glass, refracted.polished, refracted.background)
    )
    albedo = refracted.albedo + end.reflectance * reflected.albedo
    normal = refracted.normal + end.reflectance * reflected.normal
    columns = (*albedo, *normal, *flags)
    dr.eval(columns)
    sums = [dr.block_sum(column, count) for column in columns]
    ranges = [dr.block_reduce(dr.ReduceOp.Max, x, count) - dr.block_reduce(dr.ReduceOp.Min, x, count) for x in columns]
    largest = mi.Float(0.0)
    for values in ranges:
        largest = dr.maximum(largest, values)
    dr.eval(sums, largest)
    return np.stack([np.array(x, np.float64) for x in sums]), np.array(largest)


def _shaded(loaded: LoadedScene, end: _GuideRays, exposure: mi.Float, active: bool | mi.Bool) -> _GuideSample:
    """Return the guides of rays at the surfaces where they end."""
    table, ray, weight = loaded.surfaces, end.ray, end.weight
    # Shading happens here, once for all rays: the loop handles glass alone.
    si = end.pi.compute_surface_interaction(ray, mi.RayFlags.All, active)
    hit = active & si.is_valid()
    surface = surface_media(table, si, ray, hit)
    rough = surface.opaque | (dr.gather(mi.Float, table.alpha, surface.row, hit) > 0.0)
    light = exposure * to_guide(emitted(loaded.emitters, end.pi, si, ray, active))
    hit &= ~ends_paths(loaded.emitters, si, hit)  # a room's light is as free of noise as the sky's
    rough &= hit
    colour = dr.select(surface.opaque, to_guide(si.bsdf().eval_diffuse_reflectance(si, hit & surface.opaque)), 1.0)
    albedo = dr.select(active, weight * dr.minimum(light, 1.0), 0.0) + dr.select(hit & rough, weight * colour, 0.0)
    ns = surface.ns
    if table.maps is not None:  # what maps show is detail, not noise
        ns = mapped_normal(values_at(table.maps, si, surface.row), si, ns, -ray.d)
    # (`dr.mean` would compile the number of rays into the kernel.)
    normal = dr.select(hit & rough, dr.sum(weight) / 3.0 * ns, 0.0)
    direct = hit & (end.bounces == 0)
    glass = (active & (end.bounces > 0)) | (direct & ~surface.opaque)
    polished = dr.gather(mi.Bool, table.polished, surface.row, direct)
    # An area light is part of the surroundings, as the sky behind it.
    instance = dr.gather(mi.UInt32, table.instance, surface.row, hit)
    background = active & (end.bounces == 0) & (~hit | (instance == 0))
    return _GuideSample(albedo, normal, glass, polished, background)


@syntax
def _through_smooth_glass(loaded: LoadedScene, ray: mi.Ray3f, active: bool | mi.Bool) -> _GuideRays:
    """Follow rays through smooth glass to the first rough surface."""
    scene, table, offset = loaded.mi_scene, loaded.surfaces, dr.opaque(mi.Float, loaded.offset)
    ray, active, bounces, weight = mi.Ray3f(ray), mi.Bool(active), mi.UInt32(0), mi.Color3f(1.0)
    reflected, reflectance, pi = mi.Ray3f(ray), mi.Float(0.0), dr.zeros(mi.PreliminaryIntersection3f)

    while dr.hint(active, exclude=[table, scene, offset]):
        # (Coherent: rays of a pixel stay neighbours without random events.)
        pi = scene.ray_intersect_preliminary(ray, True, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
        hit = active & si.is_valid()
        surface = seen_from_air(surface_media(table, si, ray, hit), bounces == 0)
        weight *= transmittance_rgb(table.sigma_a_rgb, surface, active)
        alpha = dr.gather(mi.Float, table.alpha, surface.row, hit)
        active = hit & ~surface.opaque & (alpha == 0.0) & (bounces < _MAX_INTERFACES)

        if dr.hint(active, exclude=[table, scene, offset]):
            n = surface.n
            eta = relative_index_d(table.eta_d, surface)
            direction, transmitted = transmission(-ray.d, n, surface.ns, eta)
            reflected = dr.select(bounces == 0, leave(si, mi.reflect(-ray.d, n), offset), reflected)
            reflectance = dr.select(bounces == 0, 1.0 - transmitted, reflectance)
            weight *= transmitted
            ray = leave(si, direction, offset)
            bounces += 1

    return _GuideRays(ray, pi, weight, reflected, reflectance, bounces)
