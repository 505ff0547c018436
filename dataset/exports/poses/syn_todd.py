"""Syn-TODD's raw layout, which MVTrans' `dataset_blender.py` reads.

::

    train/12/                                  the number of a scene; val/ and test/ for scenes of these splits
        Camera_0_EmptyVessel_Frame_0_RGB_L.jpg  ..._RGB_R.jpg  ..._Depth.exr
        segmentation_Camera_0_transparent_vessel-00_visible_L.png
        BoundingBox.json

Cameras have Blender's axes (x right, y up, z back), and pixels are counted from the corner, as Blender does.
(Wang et al., *MVTrans*, ICRA 2023, and the loader of its code.)
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ....annotate.boxes import CORNER_SIGNS
from ....annotate.labels import ObjectLabel
from ....annotate.projection import project_camera, transformed
from ....core.atomic_io import atomic_folder
from ....core.json_file import json_text
from ....core.mesh import Mesh
from ....procedural.description.camera import Camera
from ....render.frame import EYES, Geometry
from ...format.exr import write_exr
from ...format.pictures import write_png
from ...reader import StoredScene, StoredView
from ..files import write_jpeg
from ..job import Exporter, Job, chosen_ids, chosen_labels, vessel_ids, write_nothing
from ..reconstruction.nerfstudio import CV_T_GL, HALF_PIXEL
from .models import model_mesh

#: Colours of the segmentation, red, green, blue: the object, what else is not the table, the table.
OBJECT, OTHER, TABLE = (206, 206, 206), (177, 0, 7), (0, 0, 0)
#: Id of the table in our pictures.
_TABLE_ID = 1
#: Longest name of an object [characters].
_LONGEST_NAME = 38
#: Width of Blender's default sensor [mm].
SENSOR_WIDTH = 36.0
#: Blender's order of a box's corners (`Object.bound_box`), by the signs of x, y and z.
BOX_ORDER = ((-1, -1, -1), (-1, -1, 1), (-1, 1, 1), (-1, 1, -1), (1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1))
_CORNERS = [CORNER_SIGNS.tolist().index(list(signs)) for signs in BOX_ORDER]


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / job.split_of(scene.scene_id) / str(scene.scene_id)


def write(job: Job, scene: StoredScene) -> None:
    """Write the folder of a scene."""
    objects, description = scene.objects(), scene.scene()
    ids, vessels = chosen_ids(job, objects), vessel_ids(objects)
    spreads = {item.id: surface_covariance(model_mesh(item)) for item in description.objects if item.id in ids}
    boxes: dict[str, Any] = {}
    with atomic_folder(place(job, scene)) as folder:
        for number, view in zip(_numbers(scene), scene.views, strict=True):
            camera, geometry = view.camera(), view.geometry()
            _write_pictures(view, geometry, folder, number)
            entry = _camera(camera)
            for label in chosen_labels(view.labels(), ids, view):
                name = f"{'transparent_' if label.id in vessels else ''}{label.name}"[:_LONGEST_NAME]
                path = folder / f"segmentation_Camera_{number}_{name}_visible_L.png"
                write_png(path, segmentation(geometry.id, label.id))
                entry[name] = _object(label, camera, spreads[label.id])
            boxes[f"Camera_{number}"] = entry
        (folder / "BoundingBox.json").write_text(json_text(boxes), "utf-8")


EXPORTER = Exporter(
    purpose="the raw layout of Syn-TODD, for MVTrans' own code",
    place=place,
    write=write,
    finish=write_nothing,
)


def segmentation(ids: np.ndarray, object_id: int) -> np.ndarray:
    """Return the picture of an object's visible pixels, (H, W, 3) uint8.

    The loader takes for the table what is black in the pictures of all objects, so nothing else may be black.
    """
    colours = np.empty((*ids.shape, 3), np.uint8)
    colours[:] = OTHER
    colours[ids == _TABLE_ID] = TABLE
    colours[ids == object_id] = OBJECT
    return colours


def surface_covariance(mesh: Mesh) -> np.ndarray:
    """Return the covariance of points spread evenly over a surface, object frame, (3, 3) [m^2].

    The integral of x x^T over a triangle of area A with corners v_k is A / 12 times the sum of v_k v_k^T and s s^T,
    where s is the sum of the corners: that of a quadratic function in barycentric coordinates.
    """
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    sums = corners.sum(axis=1)
    mean = (areas[:, None] * sums / 3.0).sum(axis=0) / areas.sum()
    squares = np.einsum("fki,fkj->fij", corners, corners) + sums[:, :, None] * sums[:, None, :]
    return (areas[:, None, None] * squares / 12.0).sum(axis=0) / areas.sum() - np.outer(mean, mean)


def _numbers(scene: StoredScene) -> list[int]:
    """Return the numbers of the cameras: places in the grid of 57, by which the loader finds neighbours, else views."""
    places = [view.camera().grid_index for view in scene.views]
    known = [place for place in places if place is not None]
    return known if len(set(known)) == len(places) else [view.number for view in scene.views]


def _write_pictures(view: StoredView, geometry: Geometry, folder: Path, number: int) -> None:
    stem = f"Camera_{number}_EmptyVessel_Frame_0"
    for eye, letter in zip(EYES, "LR", strict=True):
        write_jpeg(folder / f"{stem}_RGB_{letter}.jpg", view.picture(eye))
    write_exr(folder / f"{stem}_Depth.exr", {"G": geometry.Z})


def _camera(camera: Camera) -> dict[str, Any]:
    world_T_camera = np.array(camera.world_T_camera) @ CV_T_GL
    x, y, z, w = Rotation.from_matrix(world_T_camera[:3, :3]).as_quat().tolist()
    K = camera.K + np.array([[0.0, 0.0, HALF_PIXEL], [0.0, 0.0, HALF_PIXEL], [0.0, 0.0, 0.0]])
    return {
        "focal_length": camera.fx * SENSOR_WIDTH / camera.width,
        "camera_intrinsic": K.tolist(),
        "camera_location": world_T_camera[:3, 3].tolist(),
        "quaternion_WXYZ": [w, x, y, z],
        "camera_extrinsic": world_T_camera.tolist(),
        "sensor_width": SENSOR_WIDTH,
        "sensor_height": SENSOR_WIDTH * camera.height / camera.width,
        "sensor_fit": "HORIZONTAL",
        "resolution_x": camera.width,
        "resolution_y": camera.height,
        "baseline": camera.baseline,
    }


def _object(label: ObjectLabel, camera: Camera, spread: np.ndarray) -> dict[str, Any]:
    corners = np.array(label.box3d)[_CORNERS]
    pixels, _ = project_camera(corners, camera.K)
    pose = CV_T_GL @ np.array(label.camera_T_object)
    box = label.box2d.amodal
    left, top, right, bottom = (None,) * 4 if box is None else (value + HALF_PIXEL for value in box)
    return {
        "3dbox": {
            "image_frame": [None if np.isnan(u) else [u + HALF_PIXEL, v + HALF_PIXEL] for u, v in pixels.tolist()],
            "camera_frame": transformed(CV_T_GL, corners).tolist(),
        },
        "2dbox_imgframe": {"x1": left, "x2": right, "y1": top, "y2": bottom},
        "6dpose_c_obj": pose.tolist(),
        "covariance": (pose[:3, :3] @ spread @ pose[:3, :3].T).tolist(),
    }
