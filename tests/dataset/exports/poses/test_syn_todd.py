"""Syn-TODD's raw layout, read back as the loader of MVTrans reads it."""

from __future__ import annotations

import json
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh
from glassware.dataset.exports.poses.syn_todd import surface_covariance
from glassware.dataset.exports.run import export
from glassware.dataset.format.exr import read_exr
from glassware.dataset.reader import Dataset
from glassware.render.frame import EYES

#: From Blender's camera axes to OpenCV's.
GL = np.diag([1.0, -1.0, -1.0, 1.0])
#: Mean error of a JPEG picture of this quality [of 255].
JPEG_ERROR = 4.0


@pytest.fixture
def out(stored, tmp_path):
    export(stored, "syn-todd", tmp_path / "out")
    return tmp_path / "out" / "train" / "0"


def _names(entry):
    return [name for name, value in entry.items() if isinstance(value, dict)]


def test_cameras_and_poses_come_back(stored, out):
    boxes = json.loads((out / "BoundingBox.json").read_text())
    for view in Dataset.open(stored).views():
        camera = view.camera()
        entry = boxes[f"Camera_{camera.grid_index}"]
        extrinsic, K = np.array(entry["camera_extrinsic"]), np.array(entry["camera_intrinsic"])
        np.testing.assert_allclose(extrinsic @ GL, np.array(camera.world_T_camera), atol=1e-6)
        np.testing.assert_allclose(K[:2, 2] - 0.5, camera.centre, atol=1e-6)
        # Blender's own definition of the focal length.
        assert entry["focal_length"] / entry["sensor_width"] * entry["resolution_x"] == pytest.approx(camera.fx)
        names = _names(entry)
        assert [name.startswith("transparent_") for name in sorted(names)] == [False, False, True]
        for label in view.labels().objects:
            found = entry[next(name for name in names if name.endswith(label.name))]
            np.testing.assert_allclose(GL @ np.array(found["6dpose_c_obj"]), np.array(label.camera_T_object), atol=1e-6)


def test_corners_project_to_their_pixels_by_the_loaders_mirroring(stored, out):
    boxes = json.loads((out / "BoundingBox.json").read_text())
    for entry in boxes.values():
        K = np.array(entry["camera_intrinsic"])
        for name in _names(entry):
            box = entry[name]["3dbox"]
            points = np.array(box["camera_frame"])
            assert (points[:, 2] < 0.0).all()
            projected = points @ K.T
            u, v = (projected[:, :2] / projected[:, 2:]).T
            np.testing.assert_allclose(
                np.stack([entry["resolution_x"] - u, v], axis=1), np.array(box["image_frame"]), atol=1e-6
            )


def test_masks_table_depth_and_pictures_come_back(stored, out):
    for view in Dataset.open(stored).views():
        number, geometry, labels = view.camera().grid_index, view.geometry(), view.labels().objects
        table = np.ones(geometry.id.shape, bool)
        for label in labels:
            (path,) = out.glob(f"segmentation_Camera_{number}_*{label.name}_visible_L.png")
            colours: Any = cv2.imread(str(path))
            np.testing.assert_array_equal((colours == 206).all(axis=-1), geometry.id == label.id)
            table &= (colours == 0).all(axis=-1)
        np.testing.assert_array_equal(table, geometry.id == 1)
        stem = f"Camera_{number}_EmptyVessel_Frame_0"
        np.testing.assert_array_equal(read_exr(out / f"{stem}_Depth.exr")["G"], geometry.Z)
        for eye, letter in zip(EYES, "LR", strict=True):
            picture: Any = cv2.imread(str(out / f"{stem}_RGB_{letter}.jpg"))
            assert np.abs(picture[..., ::-1].astype(float) - view.picture(eye)).mean() < JPEG_ERROR


def test_the_covariance_is_that_of_points_on_the_surface():
    box = trimesh.creation.box(extents=(0.1, 0.2, 0.4))
    box.apply_translation((0.03, 0.0, 0.0))
    found = surface_covariance(Mesh("box", box.vertices, box.faces))
    points = trimesh.sample.sample_surface(box, 200_000, seed=1)[0]
    np.testing.assert_allclose(found, np.cov(points.T), atol=2e-4)
    # Of a cube of side a: a^2 / 6 for the two faces across the axis, a^2 / 12 for the other four, weighted by area.
    cube = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    expected = np.eye(3) * (1 / 4 * 2 / 6 + 1 / 12 * 4 / 6)
    np.testing.assert_allclose(surface_covariance(Mesh("cube", cube.vertices, cube.faces)), expected, atol=1e-7)
