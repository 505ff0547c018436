"""ClearGrasp's layouts, read as its own code reads them: channel R, instances by number, fields of view."""

from __future__ import annotations

import json
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from glassware.annotate.projection import pixel_rays
from glassware.dataset.exports.completion.outlines import CONTACT, NONE, OCCLUSION, outlines
from glassware.dataset.exports.run import export
from glassware.dataset.format.exr import read_exr
from glassware.dataset.reader import Dataset


@pytest.fixture
def out(stored, add_sensor_depth, tmp_path):
    export(add_sensor_depth(stored), "cleargrasp", tmp_path / "out")
    return tmp_path / "out" / "train" / "scene-000000"


def png(path) -> Any:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def quaternion_matrix(w, x, y, z):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_depth_masks_and_normals_are_those_of_the_view(stored, out):
    for view in Dataset.open(stored).views():
        geometry, stem = view.geometry(), f"{view.number:09d}"
        depth = read_exr(out / "depth-imgs-rectified" / f"{stem}-depth-rectified.exr")
        for channel in "RGB":
            np.testing.assert_array_equal(depth[channel], np.where(np.isfinite(geometry.Z), geometry.Z, 0.0))
        mask = png(out / "segmentation-masks" / f"{stem}-segmentation-mask.png")
        np.testing.assert_array_equal(mask == 255, geometry.id == 2)
        assert set(np.unique(mask)) == {0, 255}
        normals = read_exr(out / "camera-normals" / f"{stem}-cameraNormals.exr")
        stacked = np.stack([normals[name] for name in "RGB"], axis=-1).astype(np.float64)
        np.testing.assert_array_equal(stacked * (1.0, -1.0, -1.0), geometry.normal)
        # Towards the camera: z is positive where the surface is on the axis, and the table looks up.
        height, width = geometry.Z.shape
        rays = pixel_rays(height, width, view.camera().K) * (1.0, -1.0, -1.0)
        assert ((stacked * rays).sum(axis=-1)[mask == 255] < 0.0).all()
        assert stacked[geometry.id == 1][:, 1].mean() > 0.3
        assert png(out / "rgb-imgs" / f"{stem}-rgb.jpg").shape[:2] == geometry.Z.shape


def test_cameras_and_poses_come_back_from_the_json(stored, out):
    for view in Dataset.open(stored).views():
        camera, stem = view.camera(), f"{view.number:09d}"
        record = json.loads((out / "json-files" / f"{stem}-masks.json").read_text())
        seen = record["camera"]
        for side, focal, pixels in (("x", camera.fx, camera.width), ("y", camera.fy, camera.height)):
            angle = seen["field_of_view"][f"{side}_axis_rads"]
            assert pixels / 2.0 / np.tan(angle / 2.0) == pytest.approx(focal, rel=1e-9)
        matrix = np.array(seen["world_pose"]["matrix_4x4"])
        np.testing.assert_allclose(matrix @ np.diag([1, -1, -1, 1]), camera.world_T_camera, atol=1e-6)
        np.testing.assert_allclose(
            quaternion_matrix(*seen["world_pose"]["rotation"]["quaternion"]), matrix[:3, :3], atol=1e-6
        )
        values = read_exr(out / "variant-masks" / f"{stem}-variantMasks.exr")["R"]
        poses = record["variants"]["masks_and_poses_by_pixel_value"]
        assert record["variants"]["instance_count"] == len(poses) == 1
        for value, instance in poses.items():
            (label,) = [one for one in view.labels().objects if one.id == instance["glassware_id"]]
            np.testing.assert_array_equal(values == float(value), view.geometry().id == label.id)
            pose = np.array(instance["world_pose"]["matrix_4x4"])
            world = np.array(camera.world_T_camera) @ np.array(label.camera_T_object)
            np.testing.assert_allclose(pose, world, atol=1e-6)
            turn = quaternion_matrix(*instance["world_pose"]["rotation"]["quaternion"])
            np.testing.assert_allclose(turn, pose[:3, :3], atol=1e-6)


def test_the_sensor_has_the_layout_of_real_pictures(stored, out):
    camera = Dataset.open(stored).scene(0).views[0].camera()
    stated = yaml.safe_load((out / "sensor" / "camera_intrinsics.yaml").read_text())
    assert [stated[name] for name in ("fx", "fy", "cx", "cy")] == [camera.fx, camera.fy, *camera.centre]
    for view in Dataset.open(stored).views():
        geometry, stem = view.geometry(), out / "sensor" / f"{view.number:09d}"
        true = read_exr(stem.with_name(f"{stem.name}-opaque-depth-img.exr"))["R"]
        np.testing.assert_array_equal(true, np.where(np.isfinite(geometry.Z), geometry.Z, np.nan))
        sensed = read_exr(stem.with_name(f"{stem.name}-transparent-depth-img.exr"))["R"]
        assert (sensed[::5] == 0.0).all()
        np.testing.assert_allclose(sensed[sensed > 0.0], geometry.Z[sensed > 0.0], atol=5.1e-4)
        normals = read_exr(stem.with_name(f"{stem.name}-normals.exr"))["G"]
        assert (normals[~np.isfinite(geometry.Z)] == -1.0).all()
        mask = png(stem.with_name(f"{stem.name}-mask.png"))
        np.testing.assert_array_equal(mask == 255, geometry.id == 2)


def test_without_a_sensor_there_is_no_folder_for_it(stored, tmp_path):
    export(stored, "cleargrasp", tmp_path / "out")
    assert not (tmp_path / "out" / "train" / "scene-000000" / "sensor").exists()


def test_an_outline_is_a_jump_of_depth_or_a_contact():
    """A box that stands on a table at a grazing angle: contact below, jumps above and at the sides."""
    rows = np.arange(12)[:, None]
    table = np.broadcast_to(2.0 - 0.08 * rows, (12, 10)).copy()  # 8 cm from row to row
    Z, ids = table.copy(), np.ones((12, 10), int)
    Z[3:9, 3:7], ids[3:9, 3:7] = table[8, 0], 2  # its face, as near as the table where it stands
    found = outlines(Z, ids, ids == 2)
    assert (found[8, 4:6] == CONTACT).all()
    assert (found[3, 3:7] == OCCLUSION).all()
    assert (found[3:8, [3, 6]] == OCCLUSION).all()
    assert (found[4:8, 4:6] == NONE).all()
    assert (found[ids != 2] == NONE).all()
    sky = np.full((3, 3), np.inf)
    sky[1, 1] = 1.0
    assert outlines(sky, np.eye(3, dtype=int)[::-1] * 0 + (sky == 1.0), sky == 1.0)[1, 1] == OCCLUSION
