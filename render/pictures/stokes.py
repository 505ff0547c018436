"""Polarisation camera: the Stokes vector of every pixel, in polarised variants.

The Stokes frame of a pixel has its x axis along the rows of the picture, to the right, and its y axis up, seen against
the light. Away from the centre of the picture, where rows are not perpendicular to the ray, x is perpendicular to the
ray and to the camera's vertical. Mitsuba's `stokes` integrator uses the same frame.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.errors import InputError
from ...procedural.description.camera import Camera
from .._mitsuba import dr, mi
from ..frame import Eye
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, pinhole
from .integrator import trace
from .picture import PATHS_PER_PASS, camera_paths, check_media


def trace_stokes(
    loaded: LoadedScene, camera: Camera, eye: Eye = "left", seed: int = 0, spp: int | None = None
) -> np.ndarray:
    """Render the Stokes vectors of one eye of a camera, undenoised.

    Emitters are unpolarised. Smooth and rough glass polarise by Fresnel's equations; opaque surfaces as Mitsuba's BSDF
    does: the principled one of all our materials depolarises.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, in a polarised variant.
    camera : Camera
        The stereo pair.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Seed of this picture.
    spp : int, optional
        Samples per pixel; by default the description's.

    Returns
    -------
    (H, W, 4, 3) float32
        s0, s1, s2, s3 of each pixel as linear Rec.709, in the unit of `trace_picture`'s radiance; three equal channels
        in variants of one channel. s0 is the radiance. s1 > 0 is horizontal, s1 < 0 vertical polarisation, s2 > 0 that
        along the diagonal from lower left to upper right, s3 > 0 turns clockwise as seen by the camera.

    Raises
    ------
    InputError
        If the active variant is not polarised, or `spp` is below 1.
    MediumError
        If more segments change their medium than hairline cracks explain.
    """
    if not mi.is_polarized:
        raise InputError("backend", "a polarised variant, such as llvm_ad_spectral_polarized", mi.variant())
    spp = loaded.description.picture.spp if spp is None else spp
    if spp < 1:
        raise InputError("spp", "at least 1", spp)
    if not 0 <= seed < 1 << 32:
        raise InputError("seed", "a number of 32 bits", seed)
    pixels, counts = camera.width * camera.height, np.zeros(2)
    total = np.zeros((4, 3, pixels))
    for sums, events in _passes(loaded, pinhole(camera, eye), pixels, spp, seed):
        total += sums
        counts += events
        check_media(counts, eye)
    images = (total / spp).astype(np.float32)
    return np.ascontiguousarray(np.moveaxis(images, -1, 0)).reshape(camera.height, camera.width, 4, 3)


def _passes(
    loaded: LoadedScene, view: Pinhole, pixels: int, spp: int, seed: int
) -> Iterator[tuple[np.ndarray, list[np.int64]]]:
    """Yield each pass's sums over the samples (4, 3, pixels), and its violations and segments."""
    # A path holds 56 bytes of results, where one of a picture holds 20.
    per_pass, done, pixel = max(1, PATHS_PER_PASS // 3 // pixels), 0, np.arange(pixels, dtype=np.uint32)
    while done < spp:
        count = min(per_pass, spp - done)
        ray, weight, sampler = camera_paths(view, pixel, np.full_like(pixel, done), count, spp, seed)
        result = trace(loaded, ray, weight, sampler, loaded.description.picture)
        vectors = (result.radiance, *_in_camera(view, ray.d, *result.polarisation))
        dr.eval(vectors, result.violations, result.segments)
        sums = [[np.array(dr.block_sum(channel, count), np.float64) for channel in vector] for vector in vectors]
        yield np.array(sums), [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]
        done += count


def _in_camera(
    view: Pinhole, direction: mi.Vector3f, s1: mi.Color3f, s2: mi.Color3f, s3: mi.Color3f
) -> tuple[mi.Color3f, ...]:
    """Return Stokes vectors in the camera's frame instead of Mitsuba's frame of the rays."""
    down = view.world_R_camera @ mi.Vector3f(0.0, 1.0, 0.0)
    right = dr.normalize(dr.cross(down, direction))
    R = mi.mueller.rotate_stokes_basis(-direction, mi.mueller.stokes_basis(-direction), right)
    return s1 * R[1, 1] + s2 * R[1, 2], s1 * R[2, 1] + s2 * R[2, 2], s3


def degree_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the degree of linear polarisation, sqrt(s1^2 + s2^2) / s0; 0 where s0 is 0.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors. Noise of s1 and s2 makes the degree too high on average: render with many samples.

    Returns
    -------
    (..., channels)
        From 0 to 1 for light of one wavelength and for ``luminance(stokes)[..., None]``. Red, green and blue of
        spectral variants are differences of wavelengths: in saturated or noisy colours their degree may lie above 1.
    """
    return _ratio(np.hypot(stokes[..., 1, :], stokes[..., 2, :]), stokes[..., 0, :])


def degree_of_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the degree of polarisation, sqrt(s1^2 + s2^2 + s3^2) / s0; otherwise as the linear degree."""
    return _ratio(np.sqrt((stokes[..., 1:, :] ** 2).sum(-2)), stokes[..., 0, :])


def angle_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the angle of linear polarisation, atan2(s2, s1) / 2.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors.

    Returns
    -------
    (..., channels)
        Angle from the picture's x axis, counter-clockwise as seen in the picture, in (-pi/2, pi/2] [rad].
    """
    return 0.5 * np.arctan2(stokes[..., 2, :], stokes[..., 1, :])


def _ratio(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)
