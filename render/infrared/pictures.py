"""The infrared pictures of a view: the projector's light and ambient light, from both infrared cameras."""

from __future__ import annotations

import numpy as np

from ...core.randomness import stream_seed
from ...procedural.description.camera import Camera
from ...procedural.description.depth_camera import DepthCamera
from .._mitsuba import dr
from ..frame import EYES, Eye, Infrared
from ..labels.geometry import trace_geometry
from ..pictures.picture import PATHS_PER_PASS, Tracer, camera_paths, check_media
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, pinhole
from .ambient import is_daylight, trace_ambient
from .media import at_wavelength
from .pattern import pattern_map
from .projected_light import ProjectedLight, projected_light, sees
from .reflectances import infrared_reflectances
from .trace_pattern import trace_pattern

#: How many infrared pixels across one of ambient light has where there are dots [1]: it is smoother than they are, and
#: would take longer than the colour pictures otherwise.
_COARSER = 2
#: Kinds of light, each with random numbers of its own.
_LIGHT = ("dots", "ambient")


def trace_infrared(loaded: LoadedScene, view: int, device: DepthCamera, tracer: Tracer) -> Infrared:
    """Return what the two infrared cameras of a view see.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    view : int
        Number of the camera that the device stands beside.
    device : DepthCamera
        The device.
    tracer : Tracer
        The tracer of the scene's pictures: ambient light is traced by it.
    """
    scene = loaded.description
    camera, seed = scene.cameras[view], scene.seed
    pair = device.infrared_pair(camera)
    infrared = at_wavelength(loaded, device.projector.wavelength)
    world_T_projector = device.world_T_projector(camera)
    light = projected_light(pattern_map(device.projector, seed, device.name), world_T_projector)
    seeds = {
        kind: [stream_seed(seed, scene.scene_id, f"sensors/{view}/{kind}/{eye}") for eye in EYES] for kind in _LIGHT
    }
    with infrared_reflectances(loaded):
        dots = [_dots(infrared, pair, eye, light, device, one) for eye, one in zip(EYES, seeds["dots"], strict=True)]
    daylight, coarser = is_daylight(scene), _COARSER if device.projector.power > 0.0 else 1
    ambient = [
        trace_ambient(loaded, (pair, eye), coarser, one, tracer, daylight)
        for eye, one in zip(EYES, seeds["ambient"], strict=True)
    ]
    Z = trace_geometry(infrared, pair).Z
    points, hit = _points(Z, pair)
    lit, shared = np.zeros(Z.shape, bool), np.zeros(Z.shape, bool)
    lit[hit] = sees(infrared, world_T_projector[:3, 3], points)
    shared[hit] = sees(infrared, pair.world_T_right[:3, 3], points)
    return Infrared(pair, (dots[0], dots[1]), (ambient[0], ambient[1]), Z, lit, shared, daylight)


def _dots(
    loaded: LoadedScene, pair: Camera, eye: Eye, light: ProjectedLight, device: DepthCamera, seed: int
) -> np.ndarray:
    """Return the radiance of the projector's light, (H, W) float32 [W/(m^2 sr)]."""
    view, spp, pixels = pinhole(pair, eye), device.samples, pair.width * pair.height
    if device.projector.power == 0.0:
        return np.zeros((pair.height, pair.width), np.float32)
    found, sums = np.zeros(2, np.int64), []
    for first in range(0, pixels, max(1, PATHS_PER_PASS // spp)):
        chosen = np.arange(first, min(pixels, first + max(1, PATHS_PER_PASS // spp)), dtype=np.uint32)
        total, counts = _pass(loaded, view, chosen, light, spp, seed)
        sums.append(total)
        found += counts
    check_media(found, eye)
    return (np.concatenate(sums) / spp).reshape(pair.height, pair.width).astype(np.float32)


def _pass(
    loaded: LoadedScene, view: Pinhole, pixel: np.ndarray, light: ProjectedLight, spp: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of some pixels, and the counts of `check_media`."""
    ray, _, sampler = camera_paths(view, pixel, np.zeros(len(pixel), np.uint32), spp, spp, seed)
    result = trace_pattern(loaded, ray, sampler, light)
    dr.eval(result.radiance.x, result.violations, result.segments)
    counts = np.array([np.array(x).sum(dtype=np.int64) for x in (result.violations, result.segments)])
    return np.array(dr.block_sum(result.radiance.x, spp)), counts


def _points(Z: np.ndarray, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of the pixels that have a depth, (n, 3) float64 in the world frame, and which these are."""
    hit = np.isfinite(Z)
    rows, columns = np.nonzero(hit)
    depth, (cx, cy) = Z[hit].astype(np.float64), camera.centre
    local = np.stack([(columns - cx) / camera.fx * depth, (rows - cy) / camera.fy * depth, depth], axis=1)
    return local @ camera.world_T_camera[:3, :3].T + camera.world_T_camera[:3, 3], hit
