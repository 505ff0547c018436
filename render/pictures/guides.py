"""Guides for the denoiser that see through glass, free of noise.

A few rays through every pixel follow smooth glass to the first rough surface without tossing a coin: straight on
through every interface, and mirrored at the first one, weighted by Fresnel's shares and by absorption. Path tracing
could record the same on its way, with the noise of its coin tosses; that would have to be cleaned by two more passes of
the denoiser, which cost more than these rays.

What lies within a pixel is averaged: where its first rays disagree, as at outlines and on fine patterns, more follow.
The denoiser trusts guides, and would draw the moire of too few rays into the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...procedural.description.surroundings import Camera
from .._mitsuba import dr, mi, syntax
from ..frame import Eye
from ..interfaces.dielectric import through
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, leave, pinhole, pixel_rays
from ..scene.spectrum import grey_guide
from ..scene.surfaces import met, registry_id
from .sampler import four, samples

#: Rays of every pixel, and those that follow in a pixel, or beside one, whose first differ by more than `_DISAGREE` in
#: a colour of the albedo or a component of the normal.
_FIRST, _MORE, _DISAGREE = 4, 16, 0.2
#: Seed of their places in the pixel. They differ from pixel to pixel: what is left is noise and no pattern.
_SEED = 0x6D15
#: Interfaces after which a ray gives up; it carries little light by then, and the guide only has to show shapes.
_MAX_INTERFACES = 16


@dataclass(frozen=True, eq=False)
class Guides:
    """What the denoiser is guided by, and what pixels show first."""

    albedo: np.ndarray  #: (H, W, 3) float32, reflectance of the first rough surfaces; the sky's exposed radiance
    normal: np.ndarray  #: (H, W, 3) float32, their normals, world frame
    glass: np.ndarray  #: (H, W) bool, whether any ray meets glass first ...
    polished: np.ndarray  #: ... and whether any meets a polished opaque surface first


def trace_guides(kernel: LoadedScene, camera: Camera, eye: Eye = "left") -> Guides:
    """Return the guides of one eye, and where it sees glass and polish.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.

    Returns
    -------
    Guides
        The albedo lies in [0, 1]; the sky's radiance is cut at 1. Normals are weighted like the albedo, and so shorter
        than 1 behind glass.
    """
    view, shape = pinhole(camera, eye), (camera.height, camera.width)
    every = np.arange(camera.width * camera.height, dtype=np.uint32)
    values, differ = _guides(kernel, view, camera.exposure, every, 0, _FIRST)
    unsure = cv2.dilate((differ > _DISAGREE).astype(np.uint8).reshape(shape), np.ones((3, 3), np.uint8))
    chosen, counts = every[unsure.ravel() > 0], np.full(len(every), float(_FIRST))
    if len(chosen):
        values[:, chosen] += _guides(kernel, view, camera.exposure, chosen, _FIRST, _MORE)[0]
        counts[chosen] += _MORE
    albedo, normal, glass, polished = np.split((values / counts).astype(np.float32).T, (3, 6, 7), axis=1)
    first = (x.reshape(shape) > 0.0 for x in (glass, polished))
    return Guides(albedo.reshape(*shape, 3), normal.reshape(*shape, 3), *first)


def _guides(
    kernel: LoadedScene, view: Pinhole, exposure: float, pixel: np.ndarray, first: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Follow `count` rays through each pixel, from number `first` of its sequence on.

    Returns the sums of albedo, normal and whether glass or polish is first, (8, pixels), and how far apart the rays of
    a pixel are in any of these, (pixels,).
    """
    lane = dr.arange(mi.UInt32, len(pixel) * count)
    each = dr.opaque(mi.UInt32, count)
    group = lane // each
    at = dr.gather(mi.UInt32, mi.UInt32(pixel), group)
    # The rays of a pixel lie side by side and are added in a fixed order.
    points = samples(at, dr.opaque(mi.UInt32, first) + lane - group * each, _FIRST + _MORE, _SEED)
    u, v, *_ = four(points, mi.UInt32(0))
    ray, _ = pixel_rays(view, at, mi.Point2f(u, v) - 0.5)
    strength = dr.opaque(mi.Float, exposure)
    albedo, normal, mirrored, share, glass, polished = _followed(kernel, ray, strength)
    albedo_m, normal_m, *_ = _followed(kernel, mirrored, strength, share > 0.0)
    seen = (dr.select(flag, mi.Float(1.0), 0.0) for flag in (glass, polished))
    columns = (*(albedo + share * albedo_m), *(normal + share * normal_m), *seen)
    dr.eval(columns)
    sums = [dr.block_sum(column, count) for column in columns]
    ranges = [dr.block_reduce(dr.ReduceOp.Max, x, count) - dr.block_reduce(dr.ReduceOp.Min, x, count) for x in columns]
    differ = mi.Float(0.0)
    for one in ranges:
        differ = dr.maximum(differ, one)
    dr.eval(sums, differ)
    return np.stack([np.array(x, np.float64) for x in sums]), np.array(differ)


def _followed(
    kernel: LoadedScene, ray: mi.Ray3f, exposure: mi.Float, wanted: bool | mi.Bool = True
) -> tuple[mi.Color3f, mi.Normal3f, mi.Ray3f, mi.Float, mi.Bool, mi.Bool]:
    """Follow rays to the first rough surface.

    Returns its guides, the ray mirrored on the way with its share, and whether the first surface is glass, or polished.
    """
    scene, table = kernel.mi_scene, kernel.surfaces
    ray, pi, weight, mirrored, share, bounces = _through_smooth_glass(kernel, ray, wanted)
    # What is met is shaded here, once for all: the loop knows glass alone.
    si = pi.compute_surface_interaction(ray, mi.RayFlags.All, wanted)
    hit, row = wanted & si.is_valid(), registry_id(si.shape)
    opaque, _, _, _, ns = met(table, si, ray, hit)
    rough = opaque | (dr.gather(mi.Float, table.alpha, row, hit) > 0.0)
    emitter = si.emitter(scene, wanted)
    light = exposure * grey_guide(emitter.eval(si, wanted))
    colour = dr.select(opaque, grey_guide(si.bsdf().eval_diffuse_reflectance(si, hit & opaque)), 1.0)
    albedo = dr.select(wanted, weight * dr.minimum(light, 1.0), 0.0) + dr.select(hit & rough, weight * colour, 0.0)
    # (`dr.mean` would write the number of rays into the kernel.)
    normal = dr.select(hit & rough, dr.sum(weight) / 3.0 * ns, 0.0)
    direct = hit & (bounces == 0)
    glass = (wanted & (bounces > 0)) | (direct & ~opaque)
    return albedo, normal, mirrored, share, glass, dr.gather(mi.Bool, table.polished, row, direct)


@syntax
def _through_smooth_glass(
    kernel: LoadedScene, ray: mi.Ray3f, wanted: bool | mi.Bool
) -> tuple[mi.Ray3f, mi.PreliminaryIntersection3f, mi.Color3f, mi.Ray3f, mi.Float, mi.UInt32]:
    """Return the last segments of rays, what these meet, their weights, the mirrored rays, and how many they passed."""
    scene, table, offset = kernel.mi_scene, kernel.surfaces, dr.opaque(mi.Float, kernel.offset)
    ray, active, bounces, weight = mi.Ray3f(ray), mi.Bool(wanted), mi.UInt32(0), mi.Color3f(1.0)
    mirrored, share, pi = mi.Ray3f(ray), mi.Float(0.0), dr.zeros(mi.PreliminaryIntersection3f)

    while dr.hint(active, exclude=[table, scene, offset]):
        # (The rays of a pixel toss no coins and stay neighbours.)
        pi = scene.ray_intersect_preliminary(ray, True, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
        hit = active & si.is_valid()
        opaque, facing, beyond, n, ns = met(table, si, ray, hit)
        weight *= dr.exp(-dr.gather(mi.Color3f, table.sigma_a, facing, active) * dr.select(hit, si.t, 0.0))
        alpha = dr.gather(mi.Float, table.alpha, registry_id(si.shape), hit)
        active = hit & ~opaque & (alpha == 0.0) & (bounces < _MAX_INTERFACES)

        if dr.hint(active, exclude=[table, scene, offset]):
            eta = dr.gather(mi.Float, table.eta, beyond) / dr.gather(mi.Float, table.eta, facing)
            direction, passed = through(-ray.d, n, ns, eta)
            mirrored = dr.select(bounces == 0, leave(si, mi.reflect(-ray.d, n), offset), mirrored)
            share = dr.select(bounces == 0, 1.0 - passed, share)
            weight *= passed
            ray = leave(si, direction, offset)
            bounces += 1

    return ray, pi, weight, mirrored, share, bounces
