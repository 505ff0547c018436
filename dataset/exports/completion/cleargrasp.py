"""ClearGrasp's layouts: that of its synthetic pictures, and that of its real ones where there is a sensor's depth.

::

    train/scene-000012/                              val/ and test/ for scenes of these splits
        rgb-imgs/000000004-rgb.jpg                   view 4
        depth-imgs-rectified/000000004-depth-rectified.exr
        camera-normals/000000004-cameraNormals.exr
        segmentation-masks/000000004-segmentation-mask.png
        outlines/000000004-outlineSegmentation.png
        variant-masks/000000004-variantMasks.exr
        json-files/000000004-masks.json
        sensor/000000004-transparent-rgb-img.jpg  -transparent-depth-img.exr  -opaque-depth-img.exr
               -mask.png  -normals.exr  camera_intrinsics.yaml

(Sajjan et al., *ClearGrasp*, ICRA 2020; Shreeyak/cleargrasp: README, api/utils.py and data/sample_dataset, from which
the conventions were read.)
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from ....annotate.labels import ObjectLabel
from ....core.atomic_io import atomic_folder, link_or_copy
from ....core.json_file import json_text
from ....procedural.description.camera import Camera
from ....render.frame import Geometry
from ...format import layout
from ...format.exr import unstacked, write_exr
from ...reader import StoredScene, StoredView
from ..depth import known_depth
from ..files import write_grey_png, write_jpeg
from ..job import Exporter, Job, chosen_ids, chosen_labels, vessel_ids, write_nothing
from ..sensor import sensor_depth
from .outlines import outlines

#: From Blender's and OpenGL's camera axes to OpenCV's: y and z turned round.
_CV_T_GL = np.diag([1.0, -1.0, -1.0, 1.0])
#: Number of the first instance in variant masks and JSON.
FIRST_INSTANCE = 100
#: Width of the sensor in the sample's JSON [mm].
_SENSOR_WIDTH = 32.0
#: What can be left out, by ClearGrasp's names of folders.
LABELS = ("camera-normals", "outlines", "variant-masks", "json-files")
_FOLDERS = ("rgb-imgs", "depth-imgs-rectified", "segmentation-masks")


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / job.split_of(scene.scene_id) / f"scene-{layout.scene_name(scene.scene_id)}"


def write(job: Job, scene: StoredScene) -> None:
    """Write the folder of a scene."""
    objects = scene.objects()
    ids = [number for number in chosen_ids(job, objects) if number in vessel_ids(objects)]
    with atomic_folder(place(job, scene)) as folder:
        for name in (*_FOLDERS, *filter(job.has, LABELS)):
            (folder / name).mkdir()
        for view in scene.views:
            _write_view(job, view, ids, folder)


EXPORTER = Exporter(
    purpose="ClearGrasp: depth, normals, outlines, masks of glass",
    place=place,
    write=write,
    finish=write_nothing,
    labels=LABELS,
)


def _write_view(job: Job, view: StoredView, ids: Sequence[int], folder: Path) -> None:
    camera, geometry, stem = view.camera(), view.geometry(), f"{view.number:09d}"
    labels = list(chosen_labels(view.labels(), ids, view))
    mask, picture = np.isin(geometry.id, ids), folder / "rgb-imgs" / f"{stem}-rgb.jpg"
    write_jpeg(picture, view.picture())
    depth = known_depth(geometry.Z)
    write_exr(folder / "depth-imgs-rectified" / f"{stem}-depth-rectified.exr", _grey(depth))
    normals = camera_normals(geometry)
    if job.has("camera-normals"):
        write_exr(folder / "camera-normals" / f"{stem}-cameraNormals.exr", unstacked(normals, "RGB"))
    write_grey_png(folder / "segmentation-masks" / f"{stem}-segmentation-mask.png", mask)
    if job.has("outlines"):
        edges = outlines(geometry.Z, geometry.id, mask)
        write_grey_png(folder / "outlines" / f"{stem}-outlineSegmentation.png", edges)
    if job.has("variant-masks"):
        _write_instances(folder / "variant-masks" / f"{stem}-variantMasks.exr", geometry, labels)
    if job.has("json-files"):
        record = masks_json(camera, labels)
        (folder / "json-files" / f"{stem}-masks.json").write_text(json_text(record), "utf-8")
    sensed = sensor_depth(view)
    if sensed is not None:
        _write_sensor(folder / "sensor", stem, picture, camera, sensed, depth, mask, normals)


def _write_instances(path: Path, geometry: Geometry, labels: Sequence[ObjectLabel]) -> None:
    instances = np.zeros(geometry.id.shape, np.float32)
    for number, label in enumerate(labels):
        instances[geometry.id == label.id] = FIRST_INSTANCE + number
    write_exr(path, _grey(instances) | {"A": np.ones(instances.shape, np.float32)})


def _write_sensor(
    folder: Path,
    stem: str,
    picture: Path,
    camera: Camera,
    sensed: np.ndarray,
    depth: np.ndarray,
    mask: np.ndarray,
    normals: np.ndarray,
) -> None:
    """Write a view as ClearGrasp's real pictures are: NaN is unknown in the true depth, -1 in normals."""
    folder.mkdir(exist_ok=True)
    link_or_copy(picture, folder / f"{stem}-transparent-rgb-img.jpg")
    write_exr(folder / f"{stem}-transparent-depth-img.exr", _grey(sensed))
    write_exr(folder / f"{stem}-opaque-depth-img.exr", _grey(np.where(depth > 0.0, depth, np.float32(np.nan))))
    write_grey_png(folder / f"{stem}-mask.png", mask)
    known = np.where((normals == 0.0).all(axis=-1, keepdims=True), np.float16(-1.0), normals)
    write_exr(folder / f"{stem}-normals.exr", unstacked(known, "RGB"))
    (cx, cy), name = camera.centre, "camera_intrinsics.yaml"
    values = {"camera_name": "glassware", "xres": camera.width, "yres": camera.height}
    values |= {"fx": camera.fx, "fy": camera.fy, "cx": cx, "cy": cy}
    (folder / name).write_text(yaml.safe_dump(values, sort_keys=False), "ascii")


def camera_normals(geometry: Geometry) -> np.ndarray:
    """Return normals in ClearGrasp's axes, x right, y up, z towards the camera, (H, W, 3) float16; 0 for none."""
    return (geometry.normal * np.array([1.0, -1.0, -1.0], np.float32)).astype(np.float16)


def masks_json(camera: Camera, labels: Sequence[ObjectLabel]) -> dict[str, Any]:
    """Return the content of a ``-masks.json``: camera and instances with their poses in the world.

    Matrices are rigid, quaternions have w first; the sample's matrices are scaled, and its quaternions are theirs.
    """
    world_T_camera = np.array(camera.world_T_camera)
    across = 2.0 * np.arctan(0.5 * camera.width / camera.fx)
    down = 2.0 * np.arctan(0.5 * camera.height / camera.fy)
    poses = {
        str(FIRST_INSTANCE + number): {
            "world_pose": _pose(world_T_camera @ np.array(label.camera_T_object)),
            "variant_uri": f"glassware:{label.category}/{label.name}",
            "instance_number": number,
            "glassware_id": label.id,
        }
        for number, label in enumerate(labels)
    }
    return {
        "variants": {"masks_and_poses_by_pixel_value": poses, "instance_count": len(labels)},
        "image": {"width_px": camera.width, "height_px": camera.height},
        "camera": {
            "sensor": {"height_mm": _SENSOR_WIDTH * camera.height / camera.width, "width_mm": _SENSOR_WIDTH},
            "field_of_view": {"x_axis_rads": float(across), "y_axis_rads": float(down)},
            "world_pose": _pose(world_T_camera @ _CV_T_GL),
            "intrinsics": camera.K.tolist(),
        },
    }


def _pose(pose: np.ndarray) -> dict[str, Any]:
    x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
    turn = {"quaternion": [w, x, y, z], "inverted_quaternion": [w, -x, -y, -z]}
    return {"rotation": turn, "matrix_4x4": pose.tolist()}


def _grey(values: np.ndarray) -> dict[str, np.ndarray]:
    """Return one channel as three equal ones, float32, as ClearGrasp's readers take R."""
    return dict.fromkeys("RGB", values.astype(np.float32))
