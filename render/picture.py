"""Pictures: camera rays in passes, averaged in an order that no thread can change, until the noise is low enough."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..procedural.description import Picture
from ..procedural.surroundings.description import Camera
from .guides import trace_guides
from .integrator import Radiance, trace
from .kernel import Kernel
from .rays import Pinhole, pinhole, pixel_rays
from .sampler import Samples, four, samples
from .spectrum import draw_wavelengths

#: Paths traced at a time. Each holds 20 bytes of results, so a pass stays under 100 MB.
PATHS_PER_PASS = 1 << 22
#: Share of segments that may start in the wrong medium. Rays that slip through the hairline between two triangles do;
#: a reversed or missing interface gives a share of several per cent.
MAX_VIOLATIONS = 1e-4
#: So many segments may do so in a picture of any size: in a tiny one a single hairline is more than that share.
FEW_VIOLATIONS = 10
#: Groups that the samples of a batch are averaged in; their spread tells the noise. A variance from four groups is
#: off by 80 % in one pixel (chi-square with three degrees of freedom), by 0.2 % over the pixels of a small picture.
_GROUPS = 4
#: Keeps the relative error finite in black pixels, in exposed units; the usual choice for relMSE (Rousselle et al.
#: 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", section 5).
RELATIVE_FLOOR = 1e-2


@dataclass(frozen=True, eq=False)
class Noisy:
    """A picture before the denoiser, with its guides, and what it cost."""

    radiance: np.ndarray  #: (H, W, 3) float32, linear Rec.709
    variance: np.ndarray  #: (H, W, 3) float32, of each value, estimated; 0 for one sample
    albedo: np.ndarray  #: (H, W, 3) float32
    normal: np.ndarray  #: (H, W, 3) float32, world frame
    noise: float  #: relative error, estimated; see `_Sums.noise`
    spp: int  #: samples per pixel that were taken
    violations: float  #: share of segments whose medium was not the one that the next surface faced them with


class MediumError(RuntimeError):
    """The scene's interfaces contradict each other: a segment arrives in another medium than it started in."""


def trace_picture(kernel: Kernel, camera: Camera, eye: str, seed: int) -> Noisy:
    """Render one eye of a camera.

    Parameters
    ----------
    kernel : Kernel
        The loaded scene. Its description asks for a number of samples, or for a noise and the most samples.
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
    picture, pixels = kernel.description.picture, camera.width * camera.height
    view, sums = pinhole(camera, eye), _Sums(pixels)
    most = picture.spp if picture.noise is None else max(picture.spp, picture.max_spp)
    while sums.spp < most:
        _one_batch(kernel, view, sums, min(picture.spp, most - sums.spp), seed)
        check_media(sums.counts, eye)
        if picture.noise is not None and sums.noise(camera.exposure) <= picture.noise:
            break
    shape = (camera.height, camera.width, 3)
    radiance, variance = (x.astype(np.float32).T.reshape(shape) for x in (sums.means(), sums.variance()))
    albedo, normal = trace_guides(kernel, camera, eye)
    violations = float(sums.counts[0] / sums.counts[1])
    return Noisy(radiance, variance, albedo, normal, sums.noise(camera.exposure), sums.spp, violations)


class _Sums:
    """Running sums over groups of samples: of means, weighted by the group's size n, and of what the noise needs."""

    def __init__(self, pixels: int) -> None:
        self.spp, self.groups, self.squares = 0, 0, 0
        self.weighted = np.zeros((3, pixels))  # sum of n m
        self.spread, self.cross = np.zeros((3, pixels)), np.zeros((3, pixels))  # sums of (n m)^2 and of n^2 m
        self.counts = np.zeros(2)  # violations, segments

    def add(self, means: np.ndarray, size: int) -> None:
        """Add the means (3, pixels) of a group of samples."""
        self.weighted += size * means
        self.spread += (size * means) ** 2
        self.cross += size**2 * means
        self.spp, self.groups, self.squares = self.spp + size, self.groups + 1, self.squares + size**2

    def means(self) -> np.ndarray:
        """Return the means over all samples, (3, pixels)."""
        return self.weighted / self.spp

    def noise(self, exposure: float) -> float:
        """Return the relative error of the radiance: the root of the expected mean of (I - R)^2 / (R^2 + 0.01).

        The variance of the mean is estimated from the spread of the groups. Samples of different groups complete each
        other (they are one Sobol' sequence), so the true error is rather below than above. It is NaN for one sample.
        """
        if self.groups < 2:
            return float("nan")
        relative = exposure**2 * self.variance() / ((exposure * self.means()) ** 2 + RELATIVE_FLOOR)
        return float(np.sqrt(relative.mean()))

    def variance(self) -> np.ndarray:
        """Return the estimated variance of the means, (3, pixels); 0 for one sample, of which nothing is known."""
        if self.groups < 2:
            return np.zeros_like(self.weighted)
        mean = self.means()
        scatter = self.spread - 2.0 * mean * self.cross + mean**2 * self.squares
        return np.maximum(scatter, 0.0) / self.spp**2 * self.groups / (self.groups - 1)


def _one_batch(kernel: Kernel, view: Pinhole, sums: _Sums, batch: int, seed: int) -> None:
    """Trace a batch of samples of every pixel in passes that fit into memory, each of whole groups."""
    pixels, size = sums.weighted.shape[1], max(1, batch // _GROUPS)
    share = max(1, PATHS_PER_PASS // pixels // size) * size
    while batch > 0:
        group = min(size, batch)  # the last may be smaller
        count = min(share, batch // group * group)
        result = _one_pass(kernel, view, pixels, sums.spp, count, seed)
        sums.counts += [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]
        for means in _group_means(result, count, group):
            sums.add(means, group)
        batch -= count


def _one_pass(kernel: Kernel, view: Pinhole, pixels: int, done: int, count: int, seed: int) -> Radiance:
    picture: Picture = kernel.description.picture
    most = picture.spp if picture.noise is None else max(picture.spp, picture.max_spp)
    ray, weight, points = camera_paths(view, pixels, done, count, most, seed)
    result = trace(kernel, ray, weight, points, picture)
    # Once for all of it, not once a channel; and nothing of polarisation, which a picture does not show.
    dr.eval(result.radiance, result.violations, result.segments)
    return result


def camera_paths(
    view: Pinhole, pixels: int, done: int, count: int, most: int, seed: int
) -> tuple[mi.Ray3f, mi.UnpolarizedSpectrum, Samples]:
    """Return the starts of paths through every pixel, one after the other: what `integrator.trace` is given.

    Parameters
    ----------
    view : Pinhole
        The eye.
    pixels : int
        Number of its pixels.
    done, count : int
        Samples that each pixel has had, and those that it gets now.
    most : int
        Samples that it may get in all.
    seed : int
        Seed of the picture.
    """
    # Samples of a pixel lie side by side: they are then added in a fixed order, whatever the threads do.
    lane = dr.arange(mi.UInt32, pixels * count)
    each = dr.opaque(mi.UInt32, count)  # as a plain number it would be compiled into the kernel
    pixel = lane // each
    points = samples(pixel, lane - pixel * each + dr.opaque(mi.UInt32, done), most, seed)
    u, v, *_ = four(points, mi.UInt32(0))
    ray, _ = pixel_rays(view, pixel, mi.Point2f(u, v) - 0.5)
    ray.wavelengths, weight = draw_wavelengths(four(points, mi.UInt32(1))[0])
    return ray, weight, points


def _group_means(result: Radiance, count: int, group: int) -> np.ndarray:
    """Return the means of each group of samples, (count // group, 3, pixels)."""
    sums = [np.array(dr.block_sum(channel, group), np.float64) for channel in result.radiance]
    return np.stack(sums).reshape(3, -1, count // group).transpose(2, 0, 1) / group


def check_media(counts: np.ndarray, eye: str) -> None:
    """Raise MediumError if more of the segments change their medium under way than hairline cracks explain.

    Parameters
    ----------
    counts : (2,)
        Segments that do, and all.
    eye : {"left", "right"}
        Whose picture it is.
    """
    if counts[0] > max(FEW_VIOLATIONS, MAX_VIOLATIONS * counts[1]):
        raise MediumError(
            f"{eye} picture: {counts[0]:.0f} of {counts[1]:.0f} segments arrive in another medium than they started in "
            f"(at most {MAX_VIOLATIONS:g} of them may): an interface is missing or turned round"
        )
