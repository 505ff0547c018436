"""Where stored light could be wrong, as parts of a picture: open table, caustics, contact shadows, props, glass."""

from __future__ import annotations

import numpy as np

from glassware.procedural.description.scene import TABLE_ID
from glassware.procedural.description.surroundings import Camera
from glassware.render.cache.irradiance_cache import IrradianceCache
from glassware.render.labels.geometry import trace_straight
from glassware.render.pictures.guides import trace_guides
from glassware.render.scene.loaded_scene import LoadedScene

#: A point of the table lies in a caustic, or in a deep shadow, where so many times the table's median light arrives.
CAUSTIC, SHADOW = 1.4, 0.5
#: Regions of fewer pixels are too noisy to tell anything.
FEWEST = 100


def regions(kernel: LoadedScene, stored: IrradianceCache) -> dict[str, np.ndarray]:
    """Return which pixels of the first camera's left eye are in each region, (H, W) bool."""
    camera = kernel.description.cameras[0]
    geometry = trace_straight(kernel, camera, 0)[0]
    glass = trace_guides(kernel, camera).glass
    table = (geometry.id == TABLE_ID) & ~glass
    light = np.zeros(table.shape)
    light[table] = _arriving(stored, _points(camera, geometry.Z)[table])
    median = np.median(light[table])
    props = np.isin(geometry.id, [prop.id for prop in kernel.description.props]) & ~glass
    found = {
        "open table": table & (light < CAUSTIC * median) & (light > SHADOW * median),
        "caustics": table & (light >= CAUSTIC * median),
        "deep shadows": table & (light <= SHADOW * median),
        "props": props,
        "glass": glass,
    }
    return {name: inside for name, inside in found.items() if inside.sum() >= FEWEST}


def _points(camera: Camera, Z: np.ndarray) -> np.ndarray:
    """Return the points seen, world, (H, W, 3)."""
    v, u = np.mgrid[: camera.height, : camera.width]
    local = np.stack(
        [(u - camera.centre[0]) / camera.focal, (v - camera.centre[1]) / camera.focal, np.ones_like(Z)], -1
    )
    pose = camera.world_T_camera
    return (local * np.where(np.isfinite(Z), Z, 0.0)[..., None]) @ pose[:3, :3].T + pose[:3, 3]


def _arriving(stored: IrradianceCache, points: np.ndarray) -> np.ndarray:
    """Return the irradiance of the grid's nearest node, mean of the colours."""
    x, y = stored.nodes.axes
    column = np.clip(np.rint(x.place(points[:, 0])), 0, x.lines - 1).astype(int)
    row = np.clip(np.rint(y.place(points[:, 1])), 0, y.lines - 1).astype(int)
    return stored.moments[row * x.lines + column, :3].mean(1)
