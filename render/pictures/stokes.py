"""Polarisation camera: the Stokes vector of every pixel, in polarised variants.

The Stokes frame of a pixel has its x axis along the rows of the picture, to the right, and its y axis up, seen against
the light. Away from the centre of the picture, where rows are not perpendicular to the ray, x is perpendicular to the
ray and to the camera's vertical. Mitsuba's `stokes` integrator uses the same frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...core.errors import InputError
from ...core.polarisation import angle_of_linear_polarisation as angle_of_linear_polarisation
from ...core.polarisation import degree_of_linear_polarisation as degree_of_linear_polarisation
from ...core.polarisation import degree_of_polarisation as degree_of_polarisation
from ...procedural.description.camera import Camera
from ...procedural.description.scene import Scene
from ...procedural.surroundings.colour import LUMINANCE
from .._mitsuba import dr, mi
from ..frame import Eye, StokesPicture
from ..scene.loaded_scene import LoadedScene, load
from ..scene.rays import Pinhole, pinhole
from .guides import trace_guides
from .integrator import trace
from .picture import PATHS_PER_PASS, camera_paths, check_media

#: Paths of one pass [1]: each holds 56 bytes of results, where one of a picture holds 20.
_PATHS_PER_PASS = PATHS_PER_PASS // 3
#: Groups of samples whose spread is the error of their mean [1], and the part of the samples of pixels that show glass
#: or a polished surface that all others get: their light is unpolarised.
GROUPS, UNPOLARISED = 8, 4


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
    per_pass, done, pixel = max(1, _PATHS_PER_PASS // pixels), 0, np.arange(pixels, dtype=np.uint32)
    while done < spp:
        count = min(per_pass, spp - done)
        yield _traced(loaded, view, pixel, np.full_like(pixel, done), count, spp, seed)
        done += count


def _traced(
    loaded: LoadedScene, view: Pinhole, pixel: np.ndarray, first: np.ndarray, count: int, most: int, seed: int
) -> tuple[np.ndarray, list[np.int64]]:
    """Trace `count` samples of each pixel, from its `first` one; return sums (4, 3, n), violations and segments."""
    ray, weight, sampler = camera_paths(view, pixel, first, count, most, seed)
    result = trace(loaded, ray, weight, sampler, loaded.description.picture)
    vectors = (result.radiance, *_in_camera(view, ray.d, *result.polarisation))
    dr.eval(vectors, result.violations, result.segments)
    sums = [[np.array(dr.block_sum(channel, count), np.float64) for channel in vector] for vector in vectors]
    return np.array(sums), [np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)]


def _in_camera(
    view: Pinhole, direction: mi.Vector3f, s1: mi.Color3f, s2: mi.Color3f, s3: mi.Color3f
) -> tuple[mi.Color3f, ...]:
    """Return Stokes vectors in the camera's frame instead of Mitsuba's frame of the rays."""
    down = view.world_R_camera @ mi.Vector3f(0.0, 1.0, 0.0)
    right = dr.normalize(dr.cross(down, direction))
    R = mi.mueller.rotate_stokes_basis(-direction, mi.mueller.stokes_basis(-direction), right)
    return s1 * R[1, 1] + s2 * R[1, 2], s1 * R[2, 1] + s2 * R[2, 2], s3


def room_light(loaded: LoadedScene) -> np.ndarray | None:
    """Return the light of a scene's room, `RoomEmitter.irradiance`; None where the room is a map, or there is none."""
    return None if loaded.room is None else np.array(loaded.room.irradiance)


def load_channels(scene: Scene, light: np.ndarray | None) -> tuple[LoadedScene, ...]:
    """Return a scene in the active polarised variant: once with wavelengths, else for red, green and blue.

    Parameters
    ----------
    scene : Scene
        The description.
    light : (n,) float32, optional
        That of the room (`room_light`), by the same scene in an RGB variant.
    """
    if mi.is_spectral:
        return (load(scene),)
    return tuple(load(scene, channel=k, room_light=light) for k in range(3))


def trace_stokes_view(channels: Sequence[LoadedScene], camera: Camera, samples: int, seed: int) -> StokesPicture:
    """Render the Stokes vectors of the left eye of a camera with their errors, undenoised.

    Pixels that show glass or polished surfaces take all samples, all others a quarter: what opaque surfaces scatter is
    unpolarised. Which these are is found by rays of its own, so that means have no bias.

    Parameters
    ----------
    channels : sequence of LoadedScene
        The scene in a polarised variant: with wavelengths alone, else loaded for red, green and blue (`load`). All see
        the same paths.
    camera : Camera
        The stereo pair.
    samples : int
        Paths of each pixel that shows glass; rounded up to a multiple of 32.
    seed : int
        Seed of this picture.

    Raises
    ------
    MediumError
        If more segments change their medium than hairline cracks explain.
    """
    guides = trace_guides(channels[0], camera, "left")
    polarised = (guides.glass | guides.polished).ravel()
    vector, error = np.zeros((polarised.size, 4, 3), np.float32), np.zeros((polarised.size, 4), np.float32)
    base = -(-samples // (GROUPS * UNPOLARISED))
    for chosen, size in ((polarised, UNPOLARISED * base), (~polarised, base)):
        pixels = np.nonzero(chosen)[0].astype(np.uint32)
        for part in np.array_split(pixels, max(1, -(-len(pixels) * GROUPS * size // _PATHS_PER_PASS))):
            if len(part):
                groups = _groups(channels, pinhole(camera, "left"), part, size, seed)
                vector[part], error[part] = groups.mean(0), _standard_error(groups)
    shape = (camera.height, camera.width)
    return StokesPicture(vector=vector.reshape(*shape, 4, 3), error=error.reshape(*shape, 4))


def _groups(channels: Sequence[LoadedScene], view: Pinhole, pixels: np.ndarray, size: int, seed: int) -> np.ndarray:
    """Return the means of `GROUPS` groups of `size` samples of some pixels, (groups, pixels, 4, 3)."""
    pixel = np.repeat(pixels, GROUPS)
    first = np.tile(np.arange(GROUPS, dtype=np.uint32) * np.uint32(size), len(pixels))
    found = []
    for loaded in channels:
        sums, events = _traced(loaded, view, pixel, first, size, GROUPS * size, seed)
        check_media(np.array(events, float), "left")
        found.append(sums)
    # A scene of one channel has it in all three; one with wavelengths is by itself.
    means = found[0] if len(found) == 1 else np.stack([sums[:, 0] for sums in found], axis=1)
    return np.moveaxis(means.reshape(4, 3, len(pixels), GROUPS) / size, (3, 2), (0, 1))


def _standard_error(groups: np.ndarray) -> np.ndarray:
    """Return the standard error of the luminance of a mean of groups, (groups, n, 4, 3) to (n, 4).

    The samples of a group are stratified among each other and less so with those of others, so that this is an upper
    bound.
    """
    return (groups @ LUMINANCE).std(0, ddof=1) / np.sqrt(len(groups))
