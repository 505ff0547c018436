"""Bundles of rays, sent through the product's own ray loops."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from glassware.render.interfaces.dielectric import InterfaceHit, scatter
from glassware.render.labels.refraction import Refracted, refract
from glassware.render.pictures.integrator import trace
from glassware.render.pictures.sampler import sobol_sampler
from glassware.render.scene.loaded_scene import LoadedScene


@dataclass(frozen=True, eq=False)
class Paths:
    """What `traced` brought back, one entry a path."""

    radiance: np.ndarray  #: (n, 3) float64
    segments: np.ndarray  #: (n,) int


@dataclass(frozen=True, eq=False)
class Turned:
    """Directions and fates behind one interface, one entry a ray."""

    direction: np.ndarray  #: (n, 3) float64
    transmitted: np.ndarray  #: (n,) bool
    weight: np.ndarray  #: (n,) float64: factor on radiance


def vectors(rows: np.ndarray) -> mi.Vector3f:
    """Return (n, 3) numbers as Dr.Jit vectors."""
    return mi.Vector3f(np.ascontiguousarray(np.atleast_2d(rows).T, dtype=np.float32))


def bundle(origins: np.ndarray, directions: np.ndarray) -> mi.Ray3f:
    """Return rays from (n, 3) or (3,) origins along (n, 3) directions, which are made unit in float64."""
    directions = np.atleast_2d(np.asarray(directions, np.float64))
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    origins = np.broadcast_to(np.asarray(origins, np.float64), directions.shape)
    rays = mi.Ray3f(mi.Point3f(vectors(origins)), vectors(directions))
    dr.make_opaque(rays)  # how NumPy's memory is read is no part of the kernels that follow
    return rays


def rows(value: mi.Vector3f) -> np.ndarray:
    """Return Dr.Jit vectors as (n, 3) float64."""
    return np.atleast_2d(np.array(value, np.float64).T)


def refracted_rays(kernel: LoadedScene, origins: np.ndarray, directions: np.ndarray) -> Refracted:
    """Follow rays by the product's refracted trace."""
    end = refract(kernel, bundle(origins, directions))
    dr.eval(end)
    return end


def traced(
    kernel: LoadedScene, origins: np.ndarray, directions: np.ndarray, seed: int = 1, nm: np.ndarray | None = None
) -> Paths:
    """Follow one path a ray by the product's path tracer.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene.
    origins, directions : (n, 3) float
        The rays.
    seed : int
        Seed of the random numbers.
    nm : (n,) float, optional
        Wavelength of each path, all its channels [nm]; for spectral variants only.
    """
    ray = bundle(origins, directions)
    count = dr.width(ray.d)
    if nm is not None:
        ray.wavelengths = type(ray.wavelengths)(mi.Float(np.asarray(nm, np.float32)))
    # Each ray is a pixel of its own: its numbers are independent of all others'.
    points = sobol_sampler(dr.arange(mi.UInt32, count), dr.zeros(mi.UInt32, count), 1, seed)
    result = trace(kernel, ray, mi.UnpolarizedSpectrum(1.0), points, kernel.description.picture)
    dr.eval(result)
    return Paths(rows(result.radiance), np.array(result.segments).astype(int))


def scattered(wi: np.ndarray, eta: float, alpha: float, coin: np.ndarray, seed: int = 1) -> Turned:
    """Scatter rays at a flat interface with normal +z.

    Parameters
    ----------
    wi : (n, 3) float
        Unit directions back along the rays, ``z > 0``.
    eta : float
        Index behind the interface over index before it.
    alpha : float
        GGX roughness.
    coin : (n,) float
        Fresnel's coin of each, for smooth interfaces.
    seed : int
        Seed of the walks, for rough ones.
    """
    towards = vectors(wi)
    width = max(len(np.atleast_2d(wi)), len(np.atleast_1d(coin)))
    seeds, _ = mi.sample_tea_32(dr.arange(mi.UInt32, width), dr.opaque(mi.UInt32, seed))
    up = mi.Normal3f(0.0, 0.0, 1.0)
    # Plain numbers would be compiled into the kernel, as the alignment of NumPy's memory is: each case would have a
    # kernel of its own. What is computed has neither.
    index, rough = dr.opaque(mi.Float, eta, width), dr.opaque(mi.Float, alpha, width)
    coins = mi.Float(np.asarray(coin, np.float32)) + dr.opaque(mi.Float, 0.0)
    dr.eval(towards, coins)
    event = scatter(InterfaceHit(towards, up, up, index, rough, coins, seeds))
    dr.eval(event)
    count = dr.width(event.direction)
    transmitted = np.broadcast_to(np.array(event.transmitted), count)
    return Turned(rows(event.direction), transmitted, np.broadcast_to(np.array(event.weight, np.float64), count))
