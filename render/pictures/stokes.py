"""What a polarisation camera sees: the Stokes vector of every pixel, in polarised variants.

The frame of a pixel has its x axis along the rows of the picture, to the right, and its y axis up, as one looks at the
light. Away from the centre of the picture, where its rows are not perpendicular to the ray, x is what is perpendicular
to the ray and to the camera's vertical. Mitsuba's `stokes` integrator has the same frame.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.errors import InputError
from ...procedural.description.surroundings import Camera
from .._mitsuba import dr, mi
from ..frame import Eye
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, pinhole
from .integrator import trace
from .picture import PATHS_PER_PASS, camera_paths, check_media


def trace_stokes(
    kernel: LoadedScene, camera: Camera, eye: Eye = "left", seed: int = 0, spp: int | None = None
) -> np.ndarray:
    """Render the Stokes vectors of one eye of a camera, undenoised.

    Lamps and sky are unpolarised. Smooth and rough glass polarise by Fresnel's equations; opaque surfaces as Mitsuba's
    BSDF says: the principled one of all our materials mirrors and scatters unpolarised light.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene, in a polarised variant.
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
        in a variant of one. s0 is the radiance. s1 > 0 swings along the rows of the picture, s1 < 0 up and down,
        s2 > 0 from lower left to upper right, s3 > 0 turns clockwise as the camera sees it.

    Raises
    ------
    InputError
        If the active variant is not polarised, or `spp` is below 1.
    MediumError
        If more than hairline cracks let light change its medium.
    """
    if not mi.is_polarized:
        raise InputError("backend", "a polarised variant, such as llvm_ad_spectral_polarized", mi.variant())
    spp = kernel.description.picture.spp if spp is None else spp
    if spp < 1:
        raise InputError("spp", "at least 1", spp)
    if not 0 <= seed < 1 << 32:
        raise InputError("seed", "a number of 32 bits", seed)
    pixels, counts = camera.width * camera.height, np.zeros(2)
    total = np.zeros((4, 3, pixels))
    for sums, events in _passes(kernel, pinhole(camera, eye), pixels, spp, seed):
        total += sums
        counts += events
        check_media(counts, eye)
    images = (total / spp).astype(np.float32)
    return np.ascontiguousarray(np.moveaxis(images, -1, 0)).reshape(camera.height, camera.width, 4, 3)


def _passes(
    kernel: LoadedScene, view: Pinhole, pixels: int, spp: int, seed: int
) -> Iterator[tuple[np.ndarray, list[np.int64]]]:
    """Yield each pass's sums over the samples (4, 3, pixels), and its violations and segments."""
    # A path holds 56 bytes of results, where one of a picture holds 20.
    share, done, pixel = max(1, PATHS_PER_PASS // 3 // pixels), 0, np.arange(pixels, dtype=np.uint32)
    while done < spp:
        count = min(share, spp - done)
        ray, weight, points = camera_paths(view, pixel, np.full_like(pixel, done), count, spp, seed)
        result = trace(kernel, ray, weight, points, kernel.description.picture)
        vectors = (result.radiance, *_in_camera(view, ray.d, *result.polarisation))
        dr.eval(vectors, result.violations, result.segments)
        sums = [[np.array(dr.block_sum(channel, count), np.float64) for channel in vector] for vector in vectors]
        yield np.array(sums), [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]
        done += count


def _in_camera(
    view: Pinhole, direction: mi.Vector3f, s1: mi.Color3f, s2: mi.Color3f, s3: mi.Color3f
) -> tuple[mi.Color3f, ...]:
    """Turn Stokes vectors from Mitsuba's frame of the rays to the camera's."""
    down = view.world_R_camera @ mi.Vector3f(0.0, 1.0, 0.0)
    right = dr.normalize(dr.cross(down, direction))
    R = mi.mueller.rotate_stokes_basis(-direction, mi.mueller.stokes_basis(-direction), right)
    return s1 * R[1, 1] + s2 * R[1, 2], s1 * R[2, 1] + s2 * R[2, 2], s3


def degree_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return sqrt(s1^2 + s2^2) / s0, the share of the light that swings along one line; 0 where it is dark.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors. The noise of s1 and s2 makes the degree too high on average: take many samples.

    Returns
    -------
    (..., channels)
        From 0 to 1 for light of one wavelength and for ``luminance(stokes)[..., None]``. Red, green and blue of
        spectral variants are differences of wavelengths: in saturated or noisy colours their degree may lie above 1.
    """
    return _over(np.hypot(stokes[..., 1, :], stokes[..., 2, :]), stokes[..., 0, :])


def degree_of_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return sqrt(s1^2 + s2^2 + s3^2) / s0, circular polarisation included; otherwise as the linear degree."""
    return _over(np.sqrt((stokes[..., 1:, :] ** 2).sum(-2)), stokes[..., 0, :])


def angle_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return atan2(s2, s1) / 2, the line along which the light swings.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors.

    Returns
    -------
    (..., channels)
        Angle from the picture's x axis, counter-clockwise as one looks at the picture, in (-pi/2, pi/2] [rad].
    """
    return 0.5 * np.arctan2(stokes[..., 2, :], stokes[..., 1, :])


def _over(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)
