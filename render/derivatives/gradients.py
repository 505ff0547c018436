"""Derivatives of the path-traced picture by absorption, roughness and light, for gradient descent.

They are estimated from the same paths as the picture. Absorption and light move no path, so each path's derivative is
exact; roughness moves directions, and its derivative is the path's radiance times the score of its walks
(`walk_score`), right in the mean and noisier. Silhouettes, shadows and edges of facets need no special care: no
derivative here is of a place. What moves surfaces or bends rays (pose, shape, index) has derivatives in
`refraction.refract`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InputError
from ...procedural.description.surroundings import Camera
from .._mitsuba import dr, mi
from ..frame import Eye
from ..pictures.integrator import Radiance, trace
from ..pictures.picture import camera_paths, check_media
from ..pictures.sampler import Samples
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .replay import replay
from .tape import Slots, slots, tape

#: Most numbers on the tape of one pass: 256 MB.
_TAPE = 1 << 26


@dataclass(frozen=True, eq=False)
class Gradients:
    """Derivatives of one number, such as a loss. Also the shape in which parameters are counted."""

    sigma_a: np.ndarray  #: (media, 3) float64, by absorption for red, green, blue, in the order of `surfaces.media` [m]
    alpha: np.ndarray  #: (rows,) float64, by roughness, in the rows of `kernel.surfaces`; 0 where smooth or opaque
    environment: float  #: by the factor on the environment's radiance, which is 1
    lights: np.ndarray  #: (lights,) float64, by the factor on each area light's radiance, in the scene's order


@dataclass(frozen=True, eq=False)
class PictureDerivatives:
    """The picture and its derivative images, linear Rec.709, float64."""

    radiance: np.ndarray  #: (H, W, 3)
    sigma_a: np.ndarray  #: (media, H, W, 3), each colour by the medium's absorption of the same colour [m]
    alpha: np.ndarray  #: (rows, H, W, 3), by the roughness of each row of `kernel.surfaces`
    environment: np.ndarray  #: (H, W, 3), the part of the radiance that comes from the environment
    lights: np.ndarray  #: (lights, H, W, 3), the part that comes from each area light


def picture_and_gradients(
    kernel: LoadedScene, camera: Camera, eye: Eye, seed: int, adjoint: np.ndarray, spp: int | None = None
) -> tuple[np.ndarray, Gradients]:
    """Return a picture, and the gradients of a loss by the scene's parameters (reverse mode).

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene, in an RGB variant.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of the picture, as for `picture.trace_picture`.
    adjoint : (H, W, 3)
        Derivative of the loss by each value of the picture. For an unbiased gradient of a loss that is not linear, take
        it from a picture with another seed.
    spp : int, optional
        Samples per pixel; by default the description's. The gradient by roughness needs two at least to be quiet.

    Returns
    -------
    radiance : (H, W, 3) float64
        The picture, the same as `trace_picture` gives for so many samples.
    gradients : Gradients
        Unbiased but for roulette's and the walk's cut at very long paths, which the picture has as well.

    Raises
    ------
    InputError
        If the variant has no three colours, or the adjoint not the picture's shape.
    MediumError
        If the scene's interfaces contradict each other.
    """
    adjoint = np.asarray(adjoint, np.float64)
    shape = (camera.height, camera.width, 3)
    if adjoint.shape != shape:
        raise InputError("adjoint", f"one number for each value of the picture, {shape}", adjoint.shape)
    where, picture = _checked(kernel), 0.0
    by_colour, weights = np.zeros((where.count, 3)), adjoint.reshape(-1, 3).T
    for radiance, sums in _passes(kernel, where, camera, eye, seed, spp):
        picture = picture + radiance
        by_colour += np.einsum("pcn,cn->pc", sums, weights)
    media, first_light = where.media, where.first_light
    alpha, values = np.zeros(dr.width(kernel.surfaces.alpha)), by_colour.sum(1)
    alpha[where.rough] = values[media:first_light]
    environment, lights = _by_light(where, values[first_light:])
    return np.asarray(picture).T.reshape(shape), Gradients(by_colour[:media], alpha, float(environment), lights)


def picture_derivatives(
    kernel: LoadedScene, camera: Camera, eye: Eye, seed: int, spp: int | None = None
) -> PictureDerivatives:
    """Return a picture and its derivative by every parameter as images (forward mode).

    Parameters and errors are those of `picture_and_gradients`, whose gradients are these images weighted by the
    adjoint. The picture is linear in the lights, so these images tell it for any strength of them.
    """
    where, picture, sums = _checked(kernel), 0.0, 0.0
    for radiance, more in _passes(kernel, where, camera, eye, seed, spp):
        picture, sums = picture + radiance, sums + more
    shape = (camera.height, camera.width, 3)
    images = np.moveaxis(np.asarray(sums), 1, -1).reshape(-1, *shape)
    media, first_light = where.media, where.first_light
    alpha = np.zeros((dr.width(kernel.surfaces.alpha), *shape))
    alpha[where.rough] = images[media:first_light]
    environment, lights = _by_light(where, images[first_light:])
    return PictureDerivatives(np.asarray(picture).T.reshape(shape), images[:media], alpha, environment, lights)


def changed(kernel: LoadedScene, sigma_a: np.ndarray | None = None, alpha: np.ndarray | None = None) -> LoadedScene:
    """Return the loaded scene with other absorption or roughness, without loading it again.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene, in an RGB variant. It stays as it is; its description is carried over unchanged.
    sigma_a : (media, 3), optional
        Absorption of each of `kernel.surfaces.media` [1/m], >= 0.
    alpha : (rows,), optional
        Roughness by row of `kernel.surfaces`, within [0, 1].

    Raises
    ------
    InputError
        Where a value is outside its range, or their number is not the scene's.
    """
    where, table = _checked(kernel), kernel.surfaces
    if sigma_a is not None:
        column = _column("sigma_a", sigma_a, (where.media, 3), np.inf)
        table = replace(table, sigma_a=column, absorption=column)
    if alpha is not None:
        table = replace(table, alpha=_column("alpha", alpha, (dr.width(table.alpha),), 1.0))
    return replace(kernel, surfaces=table)


def _column(name: str, values: np.ndarray, shape: tuple[int, ...], most: float) -> mi.Float:
    values = np.asarray(values, np.float64)
    if values.shape != shape:
        raise InputError(name, f"numbers of shape {shape}", values.shape)
    if not (np.isfinite(values) & (values >= 0.0) & (values <= most)).all():
        raise InputError(name, f"finite numbers from 0 to {most:g}", f"{values.min():g} to {values.max():g}")
    column = mi.Float(values.astype(np.float32).ravel())
    dr.make_opaque(column)
    return column


def _checked(kernel: LoadedScene) -> Slots:
    if not (mi.is_rgb and dr.is_diff_v(mi.Float)) or mi.is_polarized:
        raise InputError("derivatives", "an RGB variant with AD, such as llvm_ad_rgb", mi.variant())
    return slots(kernel)


def _by_light(where: Slots, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the environment's value and those of the area lights in the scene's order."""
    names = list(where.emitters)
    lights = sum(name != "environment" for name in names)
    order = [names.index(f"light{i}") for i in range(lights)]
    return values[names.index("environment")], values[order]


def _passes(
    kernel: LoadedScene, where: Slots, camera: Camera, eye: Eye, seed: int, spp: int | None
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield each pass's share of the picture (3, pixels) and of the derivatives (slots, 3, pixels)."""
    pixels, view = camera.width * camera.height, pinhole(camera, eye)
    spp = kernel.description.picture.spp if spp is None else spp
    if spp < 1:
        raise InputError("spp", "at least 1", spp)
    share, done, counts = max(1, _TAPE // (3 * where.count * pixels)), 0, np.zeros(2)
    pixel = np.arange(pixels, dtype=np.uint32)
    while done < spp:
        count = min(share, spp - done)
        ray, _, points = camera_paths(view, pixel, np.full_like(pixel, done), count, spp, seed)
        first, sums = _one_pass(kernel, where, ray, points, count)
        counts += [np.array(x).sum(dtype=np.int64) for x in (first.violations, first.segments)]
        check_media(counts, eye)
        radiance = np.array(first.radiance, np.float64).reshape(3, pixels, count).sum(2) / spp
        yield radiance, sums.reshape(where.count, 3, pixels) / spp
        done += count


def _one_pass(
    kernel: LoadedScene, where: Slots, ray: mi.Ray3f, points: Samples, count: int
) -> tuple[Radiance, np.ndarray]:
    picture = kernel.description.picture
    first = trace(kernel, ray, mi.UnpolarizedSpectrum(1.0), points, picture)
    dr.eval(first, ray, points.pixel, points.index)
    into = tape(where, first.radiance, _others(first.radiance, count))
    again = replay(kernel, ray, points, picture, into)
    dr.eval(again, into.sums)
    return first, np.array(dr.block_sum(into.sums, count), np.float64)


def _others(radiance: mi.Color3f, count: int) -> mi.Color3f:
    """Return for each path the mean of its pixel's other paths; 0 where it is alone."""
    if count == 1:
        return dr.zeros(mi.Color3f, dr.width(radiance))
    means = [dr.repeat(dr.block_sum(channel, count), count) - channel for channel in radiance]
    others = mi.Color3f(*means) / dr.opaque(mi.Float, count - 1)
    dr.eval(others)
    return others
