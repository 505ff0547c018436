"""Rendering loop: camera rays in passes, accumulated on the film in a fixed order, until the noise is low enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...procedural.description.camera import Camera
from ...procedural.description.picture import Picture
from ...procedural.surroundings.colour import LUMINANCE
from .._mitsuba import dr, mi
from ..frame import Eye, PictureNoise
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, pinhole, pixel_rays
from ..scene.spectrum import draw_wavelengths
from .denoise import blend, denoise, with_mean_of
from .film import Film
from .fireflies import spread_fireflies
from .guides import Guides, inner_parts, trace_guides
from .integrator import Radiance, trace
from .sample_weights import (
    SampleWeights,
    displayed_noise,
    first_counts,
    group_counts,
    remaining_counts,
)
from .sampler import SobolSampler, sample_4d, sobol_sampler

#: Paths of one pass [1]. Each holds 20 bytes of results, 32 with a sensor's, so a pass stays under 140 MB.
PATHS_PER_PASS = 1 << 22
#: Largest fraction of segments that may start in the wrong medium [1]. Rays through the hairline crack between two
#: triangles do; a reversed or missing interface gives a fraction of several per cent.
MAX_VIOLATIONS = 1e-4
#: Number of such segments that is accepted in a picture of any size [1]: in a tiny one a single crack exceeds the
#: fraction.
FEW_VIOLATIONS = 10
#: Groups that the samples of a batch are averaged in, in a pixel of average weight [1]; their variance gives the noise.
#: A variance from sixteen groups is off by 37 % in one pixel (chi-square with fifteen degrees of freedom), by 0.1 %
#: over the pixels of a small picture.
_GROUPS = 16
#: Adaptive sampling of the path tracer (docs/performance.md).
PATH_TRACER_WEIGHTS = SampleWeights(glass=4.0, polished=1.0)
#: Samples per pixel below which all pixels get the same number [1].
MIN_ADAPTIVE_SPP = 4


@dataclass(frozen=True, eq=False)
class NoisyImage:
    """A rendered picture before the denoiser, with the denoiser's guides and sampling statistics."""

    radiance: np.ndarray  #: (H, W, 3) float32, linear Rec.709
    variance: np.ndarray  #: (H, W, 3) float32, estimated variance of each value; 0 for one sample
    guides: Guides
    sampling: PictureNoise  #: mean samples per pixel, and the relative error (`Film.noise`)
    exposure: float  #: factor from radiance to displayed light, of which 1 is white
    violations: float  #: paths with a segment that ends in another medium than it started in, over all segments
    #: What the scene's sensor makes of the same light, (H, W, 3) float32, and its variance; None without a sensor.
    raw: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def of_sensor(self) -> NoisyImage | None:
        """The same of the sensor's raw response in place of linear Rec.709; None without a sensor."""
        return None if self.raw is None else replace(self, radiance=self.raw[0], variance=self.raw[1], raw=None)


@dataclass(frozen=True, eq=False)
class Tracer:
    """An integrator: how the radiance of camera rays is estimated, and how adaptive sampling spends samples on it."""

    #: Takes the scene, rays, their weight, the sampler and `Picture`; as `integrator.trace`.
    trace: Callable[[LoadedScene, mi.Ray3f, mi.UnpolarizedSpectrum, SobolSampler, Picture], Radiance]
    weights: SampleWeights


#: The path tracer, the reference for all other tracers.
PATH_TRACER = Tracer(trace, PATH_TRACER_WEIGHTS)


class LightError(RuntimeError):
    """A pixel has no radiance, or one that cannot be."""


class MediumError(RuntimeError):
    """The scene's interfaces are inconsistent: segments end in another medium than they started in."""


def trace_picture(loaded: LoadedScene, camera: Camera, eye: Eye, seed: int, tracer: Tracer = PATH_TRACER) -> NoisyImage:
    """Render one eye of a camera.

    Parameters
    ----------
    loaded : LoadedScene
        The scene. Its description gives a number of samples, or a target noise and a maximum number of samples.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of this picture, different for every eye of every view.
    tracer : Tracer
        The path tracer, or one that reads the irradiance cache (`cache.trace_cached.cached_tracer`).

    Raises
    ------
    MediumError
        If more segments change their medium than hairline cracks explain.
    LightError
        If a pixel's radiance or its variance is no finite number.
    """
    picture, pixels = loaded.description.picture, camera.width * camera.height
    guides = trace_guides(loaded, camera, eye)
    source = Source(loaded, pinhole(camera, eye), camera.exposure, seed, tracer)
    film, counts, spp = Film(pixels, channels_of(loaded)), np.zeros(2, np.int64), 0
    max_spp = _max_spp(picture)
    while spp < max_spp:
        batch_spp = min(picture.spp, max_spp - spp)
        counts += _add_batch(source, film, guides, batch_spp)
        spp += batch_spp
        check_media(counts, eye)
        if picture.noise is not None and _is_below(film.noise(camera.exposure), picture.noise):
            break
    pictures = film_pictures(film, (camera.height, camera.width))
    for radiance, variance in pictures:
        check_finite(radiance, variance, guides.instance, eye)
    sampling = PictureNoise(spp=spp, noise=film.noise(camera.exposure))
    raw = pictures[1] if len(pictures) > 1 else None
    return NoisyImage(*pictures[0], guides, sampling, camera.exposure, float(counts[0] / counts[1]), raw)


def denoise_image(image: NoisyImage, fireflies: Literal["keep", "remove"] = "keep") -> np.ndarray:
    """Return the picture without noise, (H, W, 3) float32 linear Rec.709 radiance.

    Pixels that see the surroundings directly have no noise and are not changed. Fireflies that cannot be spread over
    the pixels around them (`spread_fireflies`) are kept in place, or removed with their light.
    """
    guides = image.guides
    radiance, variance, glints = spread_fireflies(image.radiance, image.variance, guides, image.exposure)
    clean = denoise(radiance, np.clip(guides.albedo, 0.0, 1.0), guides.normal)
    clean = with_mean_of(radiance, blend(radiance, variance, clean), guides.glass, inner_parts(guides.instance))
    if fireflies == "keep":
        clean = clean + glints
    return np.where(guides.background[..., None], image.radiance, clean)


def final_pictures(
    eyes: Sequence[NoisyImage], picture: Picture
) -> tuple[list[np.ndarray], tuple[np.ndarray, np.ndarray] | None]:
    """Return the pictures of two eyes, denoised where the settings say so, and those of their sensors, or None."""

    def final(image: NoisyImage) -> np.ndarray:
        return denoise_image(image, picture.fireflies) if picture.denoise else image.radiance

    raw = [final(one.of_sensor) for one in eyes if one.of_sensor is not None]
    return [final(one) for one in eyes], (raw[0], raw[1]) if raw else None


def channels_of(loaded: LoadedScene) -> int:
    """Return the channels of a film: linear Rec.709, and where the scene has a sensor its raw colours."""
    return 3 if loaded.sensor is None else 6


def film_pictures(film: Film, shape: tuple[int, int]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return means and variances of each three channels of a film as pictures of `shape`, (H, W, 3) float32."""
    with np.errstate(invalid="ignore", over="ignore"):  # pixels without samples, and what is refused as not finite
        both = [x.astype(np.float32).reshape(-1, 3, *shape) for x in (film.means, film.variance)]
    moved = (np.ascontiguousarray(np.moveaxis(x, 1, -1)) for x in both)
    return list(zip(*moved, strict=True))


def _is_below(noise: float | None, target: float) -> bool:
    return noise is not None and noise <= target


def _max_spp(picture: Picture) -> int:
    """Return the maximum number of samples per pixel, as a mean over the picture."""
    return picture.spp if picture.noise is None else picture.max_spp


def _is_adaptive(picture: Picture, batch_spp: int) -> bool:
    return picture.adaptive and batch_spp >= MIN_ADAPTIVE_SPP


@dataclass(frozen=True, eq=False)
class Source:
    """Where the samples of one picture come from."""

    loaded: LoadedScene
    view: Pinhole
    exposure: float  #: factor from radiance to displayed light, of which 1 is white
    seed: int
    tracer: Tracer


def _add_batch(source: Source, film: Film, guides: Guides, batch_spp: int) -> np.ndarray:
    """Add a batch of samples to the film, `batch_spp` a pixel on average; return the violations and the segments."""
    group_size, every = max(1, batch_spp // _GROUPS), np.ones(guides.glass.size, np.int64)
    if _is_adaptive(source.loaded.description.picture, batch_spp):
        weights = source.tracer.weights
        counts = group_counts(guides.glass, guides.polished, weights, batch_spp / group_size)
        first = first_counts(counts)
        found = _add_weighted(source, film, first, group_size)
        noise = _glass_noise(film, guides, counts * group_size, source.exposure)
        wanted = group_counts(guides.glass, guides.polished, weights, batch_spp / group_size, noise)
        rest = remaining_counts(wanted, first, int((counts - first).sum()))
        return found + _add_weighted(source, film, rest, group_size)
    return add_even(source, film, every, batch_spp)


def add_even(source: Source, film: Film, chosen: np.ndarray, spp: int) -> np.ndarray:
    """Add as many samples to each chosen pixel; return the violations and the segments."""
    group_size, every = max(1, spp // _GROUPS), chosen.astype(np.int64)
    found = _add_groups(source, film, spp // group_size * every, group_size)
    return found + _add_groups(source, film, every, spp % group_size)


def _add_weighted(source: Source, film: Film, counts: np.ndarray, group_size: int) -> np.ndarray:
    """Add a number of groups to each pixel; return the violations and the segments."""
    # In pixels with many groups, larger groups estimate the variance as well and are fewer to add.
    factor = source.tracer.weights.max_factor
    large = np.where(counts >= 2 * factor, counts // factor, 0)
    found = _add_groups(source, film, large, factor * group_size)
    return found + _add_groups(source, film, counts - factor * large, group_size)


def _glass_noise(film: Film, guides: Guides, samples: np.ndarray, exposure: float) -> np.ndarray:
    """Return the displayed noise around each pixel of glass, (H, W), that a number of `samples` would leave."""
    shape, channels = guides.glass.shape, LUMINANCE[:, None]
    variance = (channels * np.sqrt(film.variance[:3])).sum(axis=0) ** 2 * film.samples / samples
    means = (channels * film.means[:3]).sum(axis=0)
    return displayed_noise(means.reshape(shape), variance.reshape(shape), guides.glass, exposure)


def _add_groups(source: Source, film: Film, counts: np.ndarray, group_size: int) -> np.ndarray:
    """Trace groups of samples in passes that fit into memory; return the violations and the segments."""
    found, sums = np.zeros(2, np.int64), []
    if group_size == 0 or not counts.any():
        return found
    pixel = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
    # A pixel's groups are consecutive, so the index of a sample is its position plus an offset of the pixel. (Modulo
    # 2^32, which is exact.)
    start = (film.samples - group_size * (np.cumsum(counts) - counts)).astype(np.uint32)
    index = np.repeat(start, counts) + np.uint32(group_size) * np.arange(len(pixel), dtype=np.uint32)
    groups_per_pass = max(1, PATHS_PER_PASS // group_size)
    for first in range(0, len(pixel), groups_per_pass):
        part = slice(first, first + groups_per_pass)
        result = _trace_pass(source, pixel[part], index[part], group_size)
        found += [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]
        colours = (*result.radiance, *(() if result.raw is None else result.raw))
        sums.append([np.array(dr.block_sum(channel, group_size)) for channel in colours])
    film.add(counts, group_size, np.concatenate(sums, axis=1))
    return found


def _trace_pass(source: Source, pixel: np.ndarray, index: np.ndarray, group_size: int) -> Radiance:
    """Trace groups of `group_size` samples, given the pixel and the first sample of each."""
    picture: Picture = source.loaded.description.picture
    max_samples = _max_spp(picture) * (source.tracer.weights.max_factor if _is_adaptive(picture, picture.spp) else 1)
    ray, weight, sampler = camera_paths(source.view, pixel, index, group_size, max_samples, source.seed)
    result = source.tracer.trace(source.loaded, ray, weight, sampler, picture)
    # One evaluation, not one a channel; polarisation is not needed for a picture.
    dr.eval(result.radiance, result.raw, result.violations, result.segments)
    return result


def camera_paths(
    view: Pinhole, pixel: np.ndarray, index: np.ndarray, group_size: int, max_samples: int, seed: int
) -> tuple[mi.Ray3f, mi.UnpolarizedSpectrum, SobolSampler]:
    """Return camera rays in groups, the weight of their wavelengths, and their sampler: arguments of `trace`.

    Parameters
    ----------
    view : Pinhole
        The eye.
    pixel, index : (groups,) uint32
        Pixel and first sample of each group.
    group_size : int
        Samples of each group. They are adjacent, to be summed in a fixed order that no thread changes.
    max_samples : int
        Maximum number of samples of a pixel over all passes.
    seed : int
        Seed of the picture.
    """
    lane = dr.arange(mi.UInt32, len(pixel) * group_size)
    size = dr.opaque(mi.UInt32, group_size)  # a plain number would be compiled into the kernel
    group = lane // size
    at, first = (dr.gather(mi.UInt32, mi.UInt32(values), group) for values in (pixel, index))
    sampler = sobol_sampler(at, first + lane - group * size, max_samples, seed)
    u, v, *_ = sample_4d(sampler, mi.UInt32(0))
    ray, _ = pixel_rays(view, at, mi.Point2f(u, v) - 0.5)
    ray.wavelengths, weight = draw_wavelengths(sample_4d(sampler, mi.UInt32(1))[0])
    return ray, weight, sampler


def check_finite(radiance: np.ndarray, variance: np.ndarray, instance: np.ndarray, eye: Eye) -> None:
    """Raise LightError if a pixel's radiance or its variance, (H, W, 3), is no finite number.

    A few such pixels would become black areas: the firefly filter and the denoiser spread them.
    """
    wrong = np.argwhere(~(np.isfinite(radiance) & np.isfinite(variance)).all(axis=2))
    if len(wrong):
        row, column = wrong[0]
        raise LightError(
            f"{eye} picture: {len(wrong)} pixels without a finite radiance, the first in row {row}, column {column}, "
            f"which shows the instance {instance[row, column]}: {radiance[row, column].tolist()}"
        )


def check_media(counts: np.ndarray, eye: Eye) -> None:
    """Raise MediumError if more paths change their medium between two surfaces than hairline cracks explain.

    Parameters
    ----------
    counts : (2,)
        Number of such paths, and of all segments.
    eye : {"left", "right"}
        The picture's eye.
    """
    if counts[0] > max(FEW_VIOLATIONS, MAX_VIOLATIONS * counts[1]):
        raise MediumError(
            f"{eye} picture: {counts[0]:.0f} paths of {counts[1]:.0f} segments have one that ends in another medium "
            f"than it started in (at most a fraction of {MAX_VIOLATIONS:g} may): an interface is missing, its normal "
            "is reversed, or a camera is inside a body"
        )
