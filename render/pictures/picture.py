"""Pictures: camera rays in passes, averaged in an order that no thread can change, until the noise is low enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import Picture
from ...procedural.description.surroundings import Camera
from .._mitsuba import dr, mi
from ..frame import Eye, PictureNoise
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, pinhole, pixel_rays
from ..scene.spectrum import draw_wavelengths
from .film import Tally
from .guides import Guides, trace_guides
from .integrator import Radiance, trace
from .sample_weights import SampleWeights, group_counts
from .sampler import Samples, four, samples

#: Paths traced at a time. Each holds 20 bytes of results, so a pass stays under 100 MB.
PATHS_PER_PASS = 1 << 22
#: Share of segments that may start in the wrong medium. Rays that slip through the hairline between two triangles do;
#: a reversed or missing interface gives a share of several per cent.
MAX_VIOLATIONS = 1e-4
#: So many segments may do so in a picture of any size: in a tiny one a single hairline is more than that share.
FEW_VIOLATIONS = 10
#: Groups that the samples of a batch are averaged in, in a pixel that gets an average share; their spread tells the
#: noise. A variance from sixteen groups is off by 37 % in one pixel (chi-square with fifteen degrees of freedom), by
#: 0.1 % over the pixels of a small picture.
_GROUPS = 16
#: Where samples pay if paths are traced (docs/performance.md).
PATH_TRACER_WEIGHTS = SampleWeights(glass=4.0, polished=1.0)
#: Samples a pixel below which all pixels get as many.
LEAST_ADAPTIVE = 4


@dataclass(frozen=True, eq=False)
class NoisyImage:
    """A picture before the denoiser, with its guides, and what it cost."""

    radiance: np.ndarray  #: (H, W, 3) float32, linear Rec.709
    variance: np.ndarray  #: (H, W, 3) float32, of each value, estimated; 0 for one sample
    albedo: np.ndarray  #: (H, W, 3) float32
    normal: np.ndarray  #: (H, W, 3) float32, world frame
    sampling: PictureNoise  #: samples per pixel on average, and the relative error (`Tally.noise`)
    violations: float  #: share of segments whose medium was not the one that the next surface faced them with


@dataclass(frozen=True, eq=False)
class Tracer:
    """How the light that camera rays bring is found, and where samples pay then."""

    #: Given a kernel, rays, their weight, sample points and `Picture`; as `integrator.trace`.
    trace: Callable[[LoadedScene, mi.Ray3f, mi.UnpolarizedSpectrum, Samples, Picture], Radiance]
    weights: SampleWeights  #: where samples pay then


#: The path tracer, which is what all else is compared with.
PATH_TRACER = Tracer(trace, PATH_TRACER_WEIGHTS)


class MediumError(RuntimeError):
    """The scene's interfaces contradict each other: a segment arrives in another medium than it started in."""


def trace_picture(kernel: LoadedScene, camera: Camera, eye: Eye, seed: int, tracer: Tracer = PATH_TRACER) -> NoisyImage:
    """Render one eye of a camera.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene. Its description asks for a number of samples, or for a noise and the most samples.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of this picture, different for every eye of every view.
    tracer : Tracer
        How light is found: by paths, or as stored (`light.scene_light.shared_light`).

    Raises
    ------
    MediumError
        If more than hairline cracks let light change its medium.
    """
    picture, pixels = kernel.description.picture, camera.width * camera.height
    guides = trace_guides(kernel, camera, eye)
    source = _Source(kernel, pinhole(camera, eye), seed, tracer)
    tally, counts, spp = Tally(pixels), np.zeros(2, np.int64), 0
    most = _most(picture)
    while spp < most:
        batch = min(picture.spp, most - spp)
        counts += _one_batch(source, tally, guides, batch)
        spp += batch
        check_media(counts, eye)
        if picture.noise is not None and _is_below(tally.noise(camera.exposure), picture.noise):
            break
    shape = (camera.height, camera.width, 3)
    radiance, variance = (x.astype(np.float32).T.reshape(shape) for x in (tally.means, tally.variance))
    sampling = PictureNoise(spp=spp, noise=tally.noise(camera.exposure))
    return NoisyImage(radiance, variance, guides.albedo, guides.normal, sampling, float(counts[0] / counts[1]))


def _is_below(noise: float | None, target: float) -> bool:
    return noise is not None and noise <= target


def _most(picture: Picture) -> int:
    """Return the most samples of a pixel, on the average over the picture."""
    return picture.spp if picture.noise is None else picture.max_spp


def _is_adaptive(picture: Picture, batch: int) -> bool:
    return picture.adaptive and batch >= LEAST_ADAPTIVE


@dataclass(frozen=True, eq=False)
class _Source:
    """What the samples of one picture come from."""

    kernel: LoadedScene
    view: Pinhole
    seed: int
    tracer: Tracer


def _one_batch(source: _Source, tally: Tally, guides: Guides, batch: int) -> np.ndarray:
    """Take a batch of samples a pixel on the average; return the violations and the segments."""
    size, every = max(1, batch // _GROUPS), np.ones(guides.glass.size, np.int64)
    if _is_adaptive(source.kernel.description.picture, batch):
        worth = source.tracer.weights
        counts, larger = group_counts(guides.glass, guides.polished, worth, batch / size), worth.most
        # Where there are many, larger groups tell the noise as well and are fewer numbers to add.
        large = np.where(counts >= 2 * larger, counts // larger, 0)
        some = _some_groups(source, tally, large, larger * size)
        return some + _some_groups(source, tally, counts - larger * large, size)
    whole = _some_groups(source, tally, batch // size * every, size)
    return whole + _some_groups(source, tally, every, batch % size)


def _some_groups(source: _Source, tally: Tally, counts: np.ndarray, size: int) -> np.ndarray:
    """Trace groups of samples in passes that fit into memory; return the violations and the segments."""
    found, sums = np.zeros(2, np.int64), []
    if size == 0 or not counts.any():
        return found
    pixel = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
    # A pixel's groups follow each other, so their numbers do up to a number of its own. (Modulo 2^32, which is exact.)
    own = (tally.samples - size * (np.cumsum(counts) - counts)).astype(np.uint32)
    index = np.repeat(own, counts) + np.uint32(size) * np.arange(len(pixel), dtype=np.uint32)
    share = max(1, PATHS_PER_PASS // size)
    for first in range(0, len(pixel), share):
        some = slice(first, first + share)
        result = _one_pass(source, pixel[some], index[some], size)
        found += [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]
        sums.append([np.array(dr.block_sum(channel, size)) for channel in result.radiance])
    tally.add(counts, size, np.concatenate(sums, axis=1))
    return found


def _one_pass(source: _Source, pixel: np.ndarray, index: np.ndarray, size: int) -> Radiance:
    """Trace groups of `size` samples, given the pixel and the first sample of each."""
    picture: Picture = source.kernel.description.picture
    longest = _most(picture) * (source.tracer.weights.most if _is_adaptive(picture, picture.spp) else 1)
    ray, weight, points = camera_paths(source.view, pixel, index, size, longest, source.seed)
    result = source.tracer.trace(source.kernel, ray, weight, points, picture)
    # Once for all of it, not once a channel; and nothing of polarisation, which a picture does not show.
    dr.eval(result.radiance, result.violations, result.segments)
    return result


def camera_paths(
    view: Pinhole, pixel: np.ndarray, index: np.ndarray, size: int, most: int, seed: int
) -> tuple[mi.Ray3f, mi.UnpolarizedSpectrum, Samples]:
    """Return the starts of paths in groups, what `integrator.trace` is given.

    Parameters
    ----------
    view : Pinhole
        The eye.
    pixel, index : (groups,) uint32
        Pixel and first sample of each group.
    size : int
        Samples of each group. They lie side by side, to be added in a fixed order, whatever the threads do.
    most : int
        Samples that a pixel may get in all.
    seed : int
        Seed of the picture.
    """
    lane = dr.arange(mi.UInt32, len(pixel) * size)
    each = dr.opaque(mi.UInt32, size)  # as a plain number it would be compiled into the kernel
    group = lane // each
    at, first = (dr.gather(mi.UInt32, mi.UInt32(values), group) for values in (pixel, index))
    points = samples(at, first + lane - group * each, most, seed)
    u, v, *_ = four(points, mi.UInt32(0))
    ray, _ = pixel_rays(view, at, mi.Point2f(u, v) - 0.5)
    ray.wavelengths, weight = draw_wavelengths(four(points, mi.UInt32(1))[0])
    return ray, weight, points


def check_media(counts: np.ndarray, eye: Eye) -> None:
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
