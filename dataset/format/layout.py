"""Names of the files and folders of a data set (`glassware/dataset/1`).

::

    dataset.json  views.parquet  preview.png  report.html  view.html
    manifest.json  splits.json  build.jsonl           (only of builds)
    assets/<sha16>-<name>
    scenes/000007/
        scene.json  meshes/*.ply  objects.json  views.json  checksums.json  light.parquet
        000/
            camera.json  labels.json  instances.png
            left.png  right.png  left.exr  right.exr  geometry.exr  layers.exr  refraction.exr
            right_labels.json  right_instances.png  right_geometry.exr  disparity.exr  pair.png
            heatmap.png  coordinates.exr  vessel_parts.png  mattes.exr  cryptomatte.exr
            sensor_depth.png  sensor_valid.png  ir_left.png  ir_right.png
            raw_left.exr  raw_right.exr
            stokes.exr  dolp.png  aolp.png  polarisation_mosaic.png
            sensor_depth.exr  classes.png             (only of converted data sets)
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from ...core.folder_lock import LOCK as LOCK

DATASET_SCHEMA = "glassware/dataset/1"

DATASET, VIEWS, PREVIEW = "dataset.json", "views.parquet", "preview.png"
REPORT, PAGE, RECORDING = "report.html", "view.html", "view.rrd"
#: A first look at a scene that is being rendered, gone when it is done.
DRAFT = "draft.png"
MANIFEST, SPLITS, LOG = "manifest.json", "splits.json", "build.jsonl"
ASSETS, SCENES = "assets", "scenes"
SCENE, OBJECTS, SCENE_VIEWS, CHECKSUMS = "scene.json", "objects.json", "views.json", "checksums.json"
CAMERA, LABELS, INSTANCES, GEOMETRY = "camera.json", "labels.json", "instances.png", "geometry.exr"
LIGHT = "light.parquet"  # of a scene, with the setting picture.keep_light
LAYERS, REFRACTION = "layers.exr", "refraction.exr"
RIGHT_LABELS, RIGHT_INSTANCES, RIGHT_GEOMETRY = "right_labels.json", "right_instances.png", "right_geometry.exr"
DISPARITY, PAIR, HEATMAP = "disparity.exr", "pair.png", "heatmap.png"
COORDINATES, VESSEL_PARTS = "coordinates.exr", "vessel_parts.png"
MATTES, CRYPTOMATTE = "mattes.exr", "cryptomatte.exr"
SENSOR_DEPTH, SENSOR_VALID = "sensor_depth.png", "sensor_valid.png"  # with the setting sensors.depth
IR_LEFT, IR_RIGHT = "ir_left.png", "ir_right.png"
RAW_LEFT, RAW_RIGHT = "raw_left.exr", "raw_right.exr"  # with the setting sensors.sensitivities
#: With the setting sensors.polarisation.
STOKES, DOLP, AOLP, MOSAIC = "stokes.exr", "dolp.png", "aolp.png", "polarisation_mosaic.png"
#: Of converted data sets, where they have them.
MEASURED_DEPTH, CLASSES = "sensor_depth.exr", "classes.png"

_SCENE_NAME = re.compile(r"[0-9]{6,}")
_VIEW_NAME = re.compile(r"[0-9]{3,}")


def scene_name(scene_id: int) -> str:
    """Return the name of a scene's folder: six digits, or more."""
    return f"{scene_id:06d}"


def view_name(view: int) -> str:
    """Return the name of a view's folder inside its scene's: three digits."""
    return f"{view:03d}"


def scene_folder(root: Path, scene_id: int) -> Path:
    """Return a scene's folder in a data set."""
    return root / SCENES / scene_name(scene_id)


def scene_ids(root: Path) -> list[int]:
    """Return the ids of the scenes of a data set, ascending; hidden folders (incomplete scenes) are left out."""
    return _numbers(root / SCENES, _SCENE_NAME)


def view_numbers(scene: Path) -> list[int]:
    """Return the numbers of the views in a scene's folder, ascending."""
    return _numbers(scene, _VIEW_NAME)


def _numbers(folder: Path, pattern: re.Pattern[str]) -> list[int]:
    if not folder.is_dir():
        return []
    # os.scandir knows which entries are folders without a system call for each: there may be a hundred thousand.
    with os.scandir(folder) as entries:
        return sorted(int(entry.name) for entry in entries if pattern.fullmatch(entry.name) and entry.is_dir())
