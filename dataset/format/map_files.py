"""Maps of a view that are written on request: disparity, visibility in the pair, heatmap, object coordinates, parts.

=====================  ==========================================================================================
``disparity.exr``      float32 [px]; ``left``, ``right`` of the first surface, ``left.background`` and
                       ``right.background`` of the first opaque one; 0 where there is none
``pair.png``           16 bits: how the other camera sees the point of each pixel (`annotate.stereo`, 2 bits each)
``heatmap.png``        16 bits: 65535 times the heat
``coordinates.exr``    half; ``X``, ``Y``, ``Z`` of the first surface, ``back.X,Y,Z`` of the last one of the same
                       object along the ray; NaN where there is none
``vessel_parts.png``   16 bits (`annotate.vessel_parts.PART_BITS`), of all vessels
=====================  ==========================================================================================
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from ...annotate.coordinates import back_wall, object_coordinates
from ...annotate.heatmap import view_heatmap
from ...annotate.labels import Labels
from ...annotate.outlines import openings
from ...annotate.projection import disparity, transformed
from ...annotate.stereo import PairVisibility, StereoLabels
from ...annotate.vessel_parts import VesselParts, part_bits, vessel_parts
from ...core.errors import InputError
from ...procedural.description.camera import Camera
from ...procedural.description.material_list import opaque_media
from ...procedural.description.scene import Scene
from ...render.frame import Eye, Frame, Geometry, Layers
from . import layout
from .exr import read_channel, read_exr, stacked, unstacked, write_exr
from .pictures import read_png, write_png

#: Place of the two bits of each map in ``pair.png``.
PAIR_SHIFTS = {("left", "first"): 0, ("left", "background"): 2, ("right", "first"): 4, ("right", "background"): 6}
#: Value of the heat 1 in ``heatmap.png``.
HEAT_STEPS = 65535


def write_maps(folder: Path, scene: Scene, frame: Frame, labels: Labels, files: Collection[str]) -> None:
    """Write the maps of a view that its left camera's labels are enough for.

    Parameters
    ----------
    folder : Path
        The view's folder.
    scene : Scene
        The scene.
    frame, labels : Frame, Labels
        The view, rendered and labelled.
    files : collection of str
        Kinds of files (`file_kinds`); those that need layers are left out where the scene records none.
    """
    camera, geometry, layers = scene.cameras[frame.view], frame.geometry, frame.layers
    if "heatmap" in files:
        write_heatmap(folder / layout.HEATMAP, view_heatmap(geometry.id, labels.objects))
    if "coordinates" in files and layers is not None:
        depths = geometry.Z, back_wall(layers, geometry.id)
        maps = [object_coordinates(Z, geometry.id, labels.objects, camera.K) for Z in depths]
        write_coordinates(folder / layout.COORDINATES, *maps)
    if "vessel-parts" in files and layers is not None:
        parts = parts_of(scene, layers, camera).values()
        write_png(folder / layout.VESSEL_PARTS, part_bits([*parts], geometry.id.shape))


def parts_of(scene: Scene, layers: Layers, camera: Camera) -> dict[str, VesselParts]:
    """Return the masks of the parts of each vessel of a scene, by name, from the layers of a camera's view."""
    found, turbid = {}, opaque_media(scene)
    for body in scene.vessels:
        mouths = [transformed(body.world_T_object, mouth) for mouth in openings(body)]
        found[body.name] = vessel_parts(layers, body.id, mouths, camera, turbid)
    return found


def write_disparity(path: Path, camera: Camera, geometry: Geometry, right: Geometry) -> None:
    """Write ``disparity.exr``."""
    channels = {}
    for eye, seen in (("left", geometry), ("right", right)):
        for name, depth in ((eye, seen.Z), (f"{eye}.background", seen.background_Z)):
            channels[name] = disparity(depth, camera.fx, camera.baseline).astype(np.float32)
    write_exr(path, channels)


def read_disparity(path: Path, eye: Eye, background: bool) -> np.ndarray:
    """Return a map of ``disparity.exr``, (H, W) float32 [px]."""
    return read_channel(path, f"{eye}.background" if background else eye)


def write_pair(path: Path, stereo: StereoLabels) -> None:
    """Write ``pair.png``."""
    maps = {(eye, field): getattr(getattr(stereo, eye), field) for eye, field in PAIR_SHIFTS}
    bits = [maps[name].astype(np.uint16) << shift for name, shift in PAIR_SHIFTS.items()]
    write_png(path, np.bitwise_or.reduce(bits))


def read_pair(path: Path, eye: Eye) -> PairVisibility:
    """Return what the other camera sees of the points of one eye."""
    bits = read_ids(path)
    first, background = (bits >> PAIR_SHIFTS[eye, field] & 3 for field in ("first", "background"))
    return PairVisibility(first.astype(np.uint8), background.astype(np.uint8))


def write_heatmap(path: Path, heat: np.ndarray) -> None:
    """Write ``heatmap.png`` of a map, (H, W) float in [0, 1]."""
    write_png(path, np.rint(heat.astype(np.float64) * HEAT_STEPS).astype(np.uint16))


def write_coordinates(path: Path, front: np.ndarray, back: np.ndarray) -> None:
    """Write ``coordinates.exr`` of two maps, (H, W, 3)."""
    write_exr(path, unstacked(front.astype(np.float16), "XYZ") | unstacked(back.astype(np.float16), "back.XYZ"))


def read_coordinates(path: Path, back: bool) -> np.ndarray:
    """Return a map of ``coordinates.exr``, (H, W, 3) float32."""
    return stacked(read_exr(path), "back.XYZ" if back else "XYZ", path).astype(np.float32)


def read_ids(path: Path) -> np.ndarray:
    """Return a map of 16-bit numbers, (H, W) uint16; InputError where it is something else."""
    values = read_png(path)
    if values.dtype != np.uint16:
        raise InputError(path, "16-bit numbers", f"{values.dtype} {values.shape}")
    return values
