"""The stored light as a list of places, for whoever asked to keep it."""

from __future__ import annotations

import numpy as np

from ...procedural.description.scene import TABLE_ID
from ..frame import SurfaceLight
from ..scene.loaded_scene import LoadedScene
from .irradiance_cache import IrradianceCache


def surface_light(kernel: LoadedScene, stored: IrradianceCache) -> SurfaceLight:
    """Return the light that arrives at each node of a scene, in the nodes' order.

    Parameters
    ----------
    kernel : LoadedScene
        The scene, loaded for the cache.
    stored : IrradianceCache
        Its light.
    """
    nodes = stored.points
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
