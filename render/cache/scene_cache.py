"""When the light of a scene is stored, how well, and the proof that it is right."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream, stream_seed
from ...procedural.description.scene import TABLE_ID, Scene
from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..frame import LightCheck, SurfaceLight
from ..pictures.picture import PATH_TRACER, Tracer, camera_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole
from .cache_points import place_nodes
from .fill_cache import gather_light
from .irradiance_cache import StoredLight
from .trace_cached import reading

#: Samples of all pictures of a scene from which on its light is stored, unless asked otherwise. Below, storing it costs
#: more than it saves (docs/performance.md).
WORTH_IT = 1e8
#: Paths that store the light, over the camera's; and the fewest and most of a node on the average.
_SHARE, _FEWEST, _MOST = 0.1, 16, 40
#: The check: pixels, spread over at most so many views, and samples of each by both ways.
_PIXELS, _VIEWS, _SAMPLES = 1024, 8, 128
#: Most that the mean over these pixels may differ [share of it], beyond `_DOUBT` standard errors.
BOUND, _DOUBT = 0.01, 3.0


def uses_cache(scene: Scene) -> bool:
    """Return whether the scene's pictures are to read stored light.

    Raises
    ------
    InputError
        If that is asked for in a variant other than RGB.
    """
    if scene.picture.light == "path":
        return False
    rgb = mi.is_rgb and not mi.is_polarized
    asked = scene.picture.light == "shared" or scene.picture.keep_light
    if asked and not rgb:
        raise InputError("picture.light", "path, or an RGB variant such as llvm_ad_rgb", f"shared in {mi.variant()}")
    return rgb and (asked or _camera_samples(scene) >= WORTH_IT)


def _camera_samples(scene: Scene) -> float:
    return float(sum(2 * camera.width * camera.height for camera in scene.cameras)) * scene.picture.spp


def fill_scene_cache(kernel: LoadedScene) -> tuple[Tracer, LightCheck, StoredLight]:
    """Store a scene's light, and compare it with paths.

    Parameters
    ----------
    kernel : LoadedScene
        The scene, loaded with cut meshes.

    Returns
    -------
    tracer : Tracer
        What `trace_picture` is to be given: paths where the check failed.
    check : LightCheck
        What the comparison found.
    stored : StoredLight
        The light.
    """
    scene = kernel.description
    stored = stored_light(kernel)
    tracer = reading(kernel, stored)
    difference, error = compared(kernel, tracer)
    fine = abs(difference) <= BOUND + _DOUBT * error
    check = LightCheck(
        scene_id=scene.scene_id,
        mode="shared" if fine else "path",
        difference=difference,
        standard_error=error,
        bound=BOUND,
        pixels=_PIXELS,
        nodes=stored.nodes.count,
        paths=int(stored.samples.sum()),
    )
    return (tracer if fine else PATH_TRACER), check, stored


def stored_light(kernel: LoadedScene) -> StoredLight:
    """Return the light at all nodes of the scene, by as many paths as its pictures make worth while."""
    scene, nodes = kernel.description, place_nodes(kernel)
    paths = int(np.clip(_SHARE * _camera_samples(scene) / nodes.count, _FEWEST, _MOST))
    return gather_light(kernel, nodes, paths, stream_seed(scene.seed, scene.scene_id, "render/light"))


def compared(kernel: LoadedScene, tracer: Tracer) -> tuple[float, float]:
    """Return how much brighter pictures from stored light are than path-traced ones, and the standard error.

    Both are shares of the mean light of random pixels of the left pictures. The error is that of both ways' samples
    and of the choice of pixels; the noise of the stored light, which all pixels share, is not in it.
    """
    scene = kernel.description
    rng = stream(scene.seed, scene.scene_id, "render/light/check")
    views = rng.permutation(len(scene.cameras))[:_VIEWS]
    pairs = [_pairs(kernel, tracer, int(view), rng, _PIXELS // len(views)) for view in views]
    paths, stored = (np.concatenate(values) for values in zip(*pairs, strict=True))
    level, difference = float(paths.mean()), stored - paths
    if level <= 0.0:
        return 0.0, 0.0
    return float(difference.mean() / level), float(difference.std(ddof=1) / np.sqrt(len(paths)) / level)


def _pairs(
    kernel: LoadedScene, tracer: Tracer, view: int, rng: np.random.Generator, pixels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the luminance of random pixels by paths and from stored light."""
    camera, seeds = kernel.description.cameras[view], rng.integers(0, 1 << 32, 2)
    pixel = rng.integers(0, camera.width * camera.height, pixels).astype(np.uint32)
    values = []
    for seed, way in zip(seeds, (PATH_TRACER, tracer), strict=True):
        ray, weight, points = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), _SAMPLES, _SAMPLES, int(seed))
        radiance = way.trace(kernel, ray, weight, points, kernel.description.picture).radiance
        dr.eval(radiance)
        means = [np.array(dr.block_sum(channel, _SAMPLES), np.float64) / _SAMPLES for channel in radiance]
        values.append(luminance(np.stack(means, axis=1)))
    return values[0], values[1]


def surface_light(kernel: LoadedScene, stored: StoredLight) -> SurfaceLight:
    """Return the light that arrives at each node of a scene, in the nodes' order.

    Parameters
    ----------
    kernel : LoadedScene
        The scene, loaded with cut meshes.
    stored : StoredLight
        Its light.
    """
    nodes = stored.nodes
    x, y = (axis.coordinate(np.arange(axis.lines)) for axis in nodes.axes)
    grid = np.stack([np.tile(x, len(y)), np.repeat(y, len(x)), np.zeros(nodes.grid_count)], axis=1)
    up = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (nodes.grid_count, 1))
    instance = np.array(kernel.surfaces.instance)
    ids = [np.full(nodes.grid_count, TABLE_ID)]
    for body in kernel.opaque_bodies:
        sides = 1 if body.closed else 2
        ids.append(np.full(sides * len(body.positions), instance[body.row]))
    return SurfaceLight(
        id=np.concatenate(ids).astype(np.uint16),
        position=np.concatenate([grid.astype(np.float32), nodes.positions]),
        normal=np.concatenate([up, nodes.normals / np.linalg.norm(nodes.normals, axis=1, keepdims=True)]),
        irradiance=np.ascontiguousarray(stored.moments[:, :3], np.float32),
        paths=stored.samples.astype(np.uint32),
    )
