"""Derivatives of the path-traced picture by absorption, roughness and emitters, for gradient descent.

They are estimated from the same paths as the picture. Absorption and emitters move no path, so each path's derivative
is exact; roughness changes directions, and its derivative is the path's radiance times the score of its walks
(`walk_score`): unbiased, with more variance. Visibility (silhouettes, shadows, edges of triangles) needs no special
treatment, because no parameter here moves a surface. Derivatives by pose, shape and index are in
`labels.refraction.refract`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InputError
from ...procedural.description.camera import Camera
from ...procedural.description.picture import PATHS_ALONE
from .._mitsuba import dr, mi
from ..frame import Eye
from ..pictures.integrator import Radiance, trace
from ..pictures.picture import camera_paths, check_media
from ..pictures.sampler import SobolSampler
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .replay import Slots, empty_tape, replay, slots_of

#: Maximum number of elements on the tape of one pass [1]: 256 MB.
_TAPE = 1 << 26


@dataclass(frozen=True, eq=False)
class Gradients:
    """Derivatives of a scalar, such as a loss, by the scene's parameters."""

    sigma_a: np.ndarray  #: (media, 3) float64, by absorption in red, green, blue, by `surfaces.media` [m]
    alpha: np.ndarray  #: (rows,) float64, by roughness, by row of `loaded.surfaces`; 0 where smooth or opaque
    environment: float  #: by the factor on the environment's radiance, which is 1
    lights: np.ndarray  #: (lights,) float64, by the factor on each area light's radiance, in the scene's order


@dataclass(frozen=True, eq=False)
class PictureDerivatives:
    """The picture and its derivative images, linear Rec.709, float64."""

    radiance: np.ndarray  #: (H, W, 3)
    sigma_a: np.ndarray  #: (media, H, W, 3), each colour by the medium's absorption of the same colour [m]
    alpha: np.ndarray  #: (rows, H, W, 3), by the roughness of each row of `loaded.surfaces`
    environment: np.ndarray  #: (H, W, 3), the part of the radiance that comes from the environment
    lights: np.ndarray  #: (lights, H, W, 3), the part that comes from each area light


def picture_and_gradients(
    loaded: LoadedScene, camera: Camera, eye: Eye, seed: int, adjoint: np.ndarray, spp: int | None = None
) -> tuple[np.ndarray, Gradients]:
    """Return a picture, and the gradients of a loss by the scene's parameters (reverse mode).

    Parameters
    ----------
    loaded : LoadedScene
        The loaded scene, in an RGB variant.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of the picture, as for `picture.trace_picture`.
    adjoint : (H, W, 3)
        Derivative of the loss by each value of the picture. For an unbiased gradient of a nonlinear loss, take it from
        a picture with another seed.
    spp : int, optional
        Samples per pixel; by default the description's. The control variate of roughness needs at least two.

    Returns
    -------
    radiance : (H, W, 3) float64
        The picture, as `trace_picture` renders it with the same number of samples.
    gradients : Gradients
        Unbiased except for the maximum lengths of paths and walks, which limit the picture as well.

    Raises
    ------
    InputError
        If the variant is not RGB with AD, or the adjoint does not have the picture's shape.
    MediumError
        If the scene's interfaces are inconsistent (`picture.check_media`).
    """
    adjoint = np.asarray(adjoint, np.float64)
    shape = (camera.height, camera.width, 3)
    if adjoint.shape != shape:
        raise InputError("adjoint", f"one number for each value of the picture, {shape}", adjoint.shape)
    slots, picture = _checked(loaded), 0.0
    by_colour, weights = np.zeros((slots.count, 3)), adjoint.reshape(-1, 3).T
    for radiance, sums in _passes(loaded, slots, camera, eye, seed, spp):
        picture = picture + radiance
        by_colour += np.einsum("pcn,cn->pc", sums, weights)
    media, first_light = slots.media, slots.first_light
    alpha, values = np.zeros(dr.width(loaded.surfaces.alpha)), by_colour.sum(1)
    alpha[slots.rough] = values[media:first_light]
    environment, lights = _by_light(slots, values[first_light:])
    return np.asarray(picture).T.reshape(shape), Gradients(by_colour[:media], alpha, float(environment), lights)


def picture_derivatives(
    loaded: LoadedScene, camera: Camera, eye: Eye, seed: int, spp: int | None = None
) -> PictureDerivatives:
    """Return a picture and its derivative by every parameter as images (forward mode).

    Parameters and errors are those of `picture_and_gradients`, whose gradients are these images weighted by the
    adjoint. The picture is linear in the emitters, so these images give it for any strength of them.
    """
    slots, picture, sums = _checked(loaded), 0.0, 0.0
    for radiance, more in _passes(loaded, slots, camera, eye, seed, spp):
        picture, sums = picture + radiance, sums + more
    shape = (camera.height, camera.width, 3)
    images = np.moveaxis(np.asarray(sums), 1, -1).reshape(-1, *shape)
    media, first_light = slots.media, slots.first_light
    alpha = np.zeros((dr.width(loaded.surfaces.alpha), *shape))
    alpha[slots.rough] = images[media:first_light]
    environment, lights = _by_light(slots, images[first_light:])
    return PictureDerivatives(np.asarray(picture).T.reshape(shape), images[:media], alpha, environment, lights)


def with_parameters(
    loaded: LoadedScene, sigma_a: np.ndarray | None = None, alpha: np.ndarray | None = None
) -> LoadedScene:
    """Return the loaded scene with other absorption or roughness, without reloading it.

    Parameters
    ----------
    loaded : LoadedScene
        The loaded scene, in an RGB variant. It is not modified; the result has the same description.
    sigma_a : (media, 3), optional
        Absorption of each of `loaded.surfaces.media` [1/m], >= 0.
    alpha : (rows,), optional
        Roughness by row of `loaded.surfaces`, in [0, 1].

    Raises
    ------
    InputError
        If a value is outside its range or an array has the wrong shape.
    """
    slots, table = _checked(loaded), loaded.surfaces
    if sigma_a is not None:
        column = _column("sigma_a", sigma_a, (slots.media, 3), np.inf)
        table = replace(table, sigma_a_rgb=column, sigma_a_render=column)
    if alpha is not None:
        table = replace(table, alpha=_column("alpha", alpha, (dr.width(table.alpha),), 1.0))
    return replace(loaded, surfaces=table)


def _column(name: str, values: np.ndarray, shape: tuple[int, ...], most: float) -> mi.Float:
    values = np.asarray(values, np.float64)
    if values.shape != shape:
        raise InputError(name, f"numbers of shape {shape}", values.shape)
    if not (np.isfinite(values) & (values >= 0.0) & (values <= most)).all():
        raise InputError(name, f"finite numbers from 0 to {most:g}", f"{values.min():g} to {values.max():g}")
    column = mi.Float(values.astype(np.float32).ravel())
    dr.make_opaque(column)
    return column


def _checked(loaded: LoadedScene) -> Slots:
    if not (mi.is_rgb and dr.is_diff_v(mi.Float)) or mi.is_polarized:
        raise InputError("derivatives", "an RGB variant with AD, such as llvm_ad_rgb", mi.variant())
    for name, (true, found) in loaded.description.picture.simplified.items():
        if name in PATHS_ALONE:
            raise InputError(f"picture.{name}", f"{true} for derivatives", found)
    return slots_of(loaded)


def _by_light(slots: Slots, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the environment's value and those of the area lights in the scene's order."""
    names = list(slots.emitters)
    lights = sum(name != "environment" for name in names)
    order = [names.index(f"light{i}") for i in range(lights)]
    return values[names.index("environment")], values[order]


def _passes(
    loaded: LoadedScene, slots: Slots, camera: Camera, eye: Eye, seed: int, spp: int | None
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield each pass's weighted contribution to the picture (3, pixels) and the derivatives (slots, 3, pixels)."""
    pixels, view = camera.width * camera.height, pinhole(camera, eye)
    spp = loaded.description.picture.spp if spp is None else spp
    if spp < 1:
        raise InputError("spp", "at least 1", spp)
    per_pass, done, counts = max(1, _TAPE // (3 * slots.count * pixels)), 0, np.zeros(2)
    pixel = np.arange(pixels, dtype=np.uint32)
    while done < spp:
        count = min(per_pass, spp - done)
        ray, _, sampler = camera_paths(view, pixel, np.full_like(pixel, done), count, spp, seed)
        first, sums = _one_pass(loaded, slots, ray, sampler, count)
        counts += [np.array(x).sum(dtype=np.int64) for x in (first.violations, first.segments)]
        check_media(counts, eye)
        radiance = np.array(first.radiance, np.float64).reshape(3, pixels, count).sum(2) / spp
        yield radiance, sums.reshape(slots.count, 3, pixels) / spp
        done += count


def _one_pass(
    loaded: LoadedScene, slots: Slots, ray: mi.Ray3f, sampler: SobolSampler, count: int
) -> tuple[Radiance, np.ndarray]:
    picture = loaded.description.picture
    first = trace(loaded, ray, mi.UnpolarizedSpectrum(1.0), sampler, picture)
    dr.eval(first, ray, sampler.pixel, sampler.index)
    tape = empty_tape(slots, first.radiance, _mean_of_others(first.radiance, count))
    again = replay(loaded, ray, sampler, picture, tape)
    dr.eval(again, tape.sums)
    return first, np.array(dr.block_sum(tape.sums, count), np.float64)


def _mean_of_others(radiance: mi.Color3f, count: int) -> mi.Color3f:
    """Return for each path the mean radiance of its pixel's other paths; 0 where there are none."""
    if count == 1:
        return dr.zeros(mi.Color3f, dr.width(radiance))
    means = [dr.repeat(dr.block_sum(channel, count), count) - channel for channel in radiance]
    others = mi.Color3f(*means) / dr.opaque(mi.Float, count - 1)
    dr.eval(others)
    return others
