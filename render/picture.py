"""Pictures: camera rays in passes, averaged in an order that no thread can change, then denoised."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..procedural.surroundings.description import Camera
from .integrator import Radiance, trace
from .kernel import Kernel
from .rays import Pinhole, pinhole, pixel_rays
from .sampler import four, samples
from .spectrum import draw_wavelengths

#: Paths traced at a time. Each holds about 60 bytes of results, so a pass stays under 300 MB.
PATHS_PER_PASS = 1 << 22
#: Share of segments that may start in the wrong medium. Rays that slip through the hairline between two triangles do;
#: a reversed or missing interface gives a share of several per cent.
MAX_VIOLATIONS = 1e-4


@dataclass(frozen=True, eq=False)
class Noisy:
    """A picture before the denoiser, with its guides, and how its segments kept to their media."""

    radiance: np.ndarray  #: (H, W, 3) float32, linear Rec.709
    albedo: np.ndarray  #: (H, W, 3) float32
    normal: np.ndarray  #: (H, W, 3) float32, world frame
    violations: float  #: share of segments whose medium was not the one that the next surface faced them with


class MediumError(RuntimeError):
    """The scene's interfaces contradict each other: a segment arrives in another medium than it started in."""


def trace_picture(kernel: Kernel, camera: Camera, eye: str, seed: int) -> Noisy:
    """Render one eye of a camera.

    Parameters
    ----------
    kernel : Kernel
        The loaded scene; its description says how many samples.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of this picture, different for every eye of every view.

    Raises
    ------
    MediumError
        If more than hairline cracks let light change its medium.
    """
    spp = kernel.description.picture.spp
    view, pixels = pinhole(camera, eye), camera.width * camera.height
    share = max(1, min(spp, PATHS_PER_PASS // pixels))
    sums, counts, done = np.zeros((9, pixels)), np.zeros(2), 0
    while done < spp:
        count = min(share, spp - done)
        result = _one_pass(kernel, view, pixels, done, count, seed)
        sums += _pixel_means(result, count) * count
        counts += [np.array(result.violations).sum(dtype=np.int64), np.array(result.segments).sum(dtype=np.int64)]
        done += count
    _check_media(counts, eye)
    means = (sums / spp).astype(np.float32).reshape(3, 3, camera.height, camera.width)
    radiance, albedo, normal = np.ascontiguousarray(means.transpose(0, 2, 3, 1))
    return Noisy(radiance, albedo, normal, float(counts[0] / counts[1]))


def _one_pass(kernel: Kernel, view: Pinhole, pixels: int, done: int, count: int, seed: int) -> Radiance:
    picture = kernel.description.picture
    # Samples of a pixel lie side by side: block_sum then adds them in a fixed order, whatever the threads do.
    lane = dr.arange(mi.UInt32, pixels * count)
    pixel = lane // dr.opaque(mi.UInt32, count)
    points = samples(pixel, lane - pixel * count + dr.opaque(mi.UInt32, done), picture.spp, seed)
    u, v, *_ = four(points, mi.UInt32(0))
    ray, _ = pixel_rays(view, pixel, mi.Point2f(u, v) - 0.5)
    ray.wavelengths, weight = draw_wavelengths(four(points, mi.UInt32(1))[0])
    result = trace(kernel, ray, weight, points, picture)
    dr.eval(result)  # once for all of it, not once a channel
    return result


def _pixel_means(result: Radiance, samples: int) -> np.ndarray:
    channels = [*result.radiance, *result.albedo, *result.normal]
    return np.stack([np.array(dr.block_sum(channel, samples), np.float64) for channel in channels]) / samples


def _check_media(counts: np.ndarray, eye: str) -> None:
    if counts[0] > MAX_VIOLATIONS * counts[1]:
        raise MediumError(
            f"{eye} picture: {counts[0]:.0f} of {counts[1]:.0f} segments arrive in another medium than they started in "
            f"(at most {MAX_VIOLATIONS:g} of them may): an interface is missing or turned round"
        )
