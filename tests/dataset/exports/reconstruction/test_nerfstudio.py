"""nerfstudio's and COLMAP's files, read back by the definitions on their pages."""

from __future__ import annotations

import json
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from glassware.annotate.projection import project
from glassware.dataset.exports.reconstruction.nerfstudio import HELD_OUT, Picture, transforms
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset

#: From nerfstudio's camera axes to OpenCV's.
GL = np.diag([1.0, -1.0, -1.0, 1.0])


@pytest.fixture
def out(stored, tmp_path):
    export(stored, "nerfstudio", tmp_path / "out")
    return tmp_path / "out" / "000000"


def _colmap(folder):
    """(K, camera_T_world) by file name, as COLMAP's page defines the text files."""
    lines = (folder / "cameras.txt").read_text().splitlines()
    cameras = {line.split()[0]: [float(value) for value in line.split()[4:]] for line in lines if line[0] != "#"}
    found = {}
    lines = [line for line in (folder / "images.txt").read_text().split("\n") if not line.startswith("#")]
    for line, points in zip(lines[:-1:2], lines[1::2], strict=True):
        assert points == ""
        w, x, y, z, *translation = (float(value) for value in line.split()[1:8])
        camera, name = line.split()[8:]
        pose = np.eye(4)
        # The rotation of a unit quaternion.
        pose[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        pose[:3, 3] = translation
        fx, fy, cx, cy = cameras[camera]
        found[name] = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), pose
    return found


@pytest.mark.parametrize("eye", ["left", "right", "both"])
def test_cameras_come_back_from_both_files(stored, tmp_path, eye):
    export(stored, "nerfstudio", tmp_path / "out", eye=eye)
    folder = tmp_path / "out" / "000000"
    frames = {frame["file_path"]: frame for frame in json.loads((folder / "transforms.json").read_text())["frames"]}
    colmap = _colmap(folder / "sparse" / "0")
    eyes = ("left", "right") if eye == "both" else (eye,)
    assert len(frames) == len(colmap) == 2 * len(eyes)
    for view in Dataset.open(stored).views():
        camera = view.camera()
        for side in eyes:
            name, pose = f"{side}_{view.number:03d}.png", camera.world_T_camera
            pose = np.array(pose if side == "left" else camera.world_T_right)
            frame, (K, camera_T_world) = frames[f"images/{name}"], colmap[name]
            np.testing.assert_allclose(np.array(frame["transform_matrix"]) @ GL, pose, atol=1e-6)
            np.testing.assert_allclose(camera_T_world @ pose, np.eye(4), atol=1e-6)
            half = np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
            np.testing.assert_allclose(K - half, camera.K, atol=1e-6)
            assert [frame[key] for key in ("fl_x", "fl_y", "cx", "cy")] == [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]
            assert (folder / "images" / name).read_bytes() == (view.folder / f"{side}.png").read_bytes()


def test_depth_is_in_millimetres_and_masks_show_the_objects(stored, out):
    for view in Dataset.open(stored).views():
        geometry, name = view.geometry(), f"left_{view.number:03d}.png"
        depth: Any = cv2.imread(str(out / "depths" / name), cv2.IMREAD_UNCHANGED)
        mask: Any = cv2.imread(str(out / "masks" / name), cv2.IMREAD_UNCHANGED)
        hit = np.isfinite(geometry.Z)
        assert depth.dtype == np.uint16
        assert (depth[~hit] == 0).all()
        assert np.abs(depth - 1000.0 * geometry.Z)[hit].max() <= 0.5 + 1e-3
        np.testing.assert_array_equal(mask == 255, geometry.id >= 2)
        assert set(np.unique(mask)) == {0, 255}


def test_files_that_are_named_are_there_and_masks_are_for_all_or_none(out):
    for name, keys in (
        ("transforms.json", ["file_path", "depth_file_path"]),
        ("transforms_objects.json", ["file_path", "depth_file_path", "mask_path"]),
    ):
        record = json.loads((out / name).read_text())
        for frame in record["frames"]:
            assert {key for key in frame if key.endswith("_path")} == set(keys)
            assert all((out / frame[key]).is_file() for key in keys)
        assert (out / record["ply_file_path"]).is_file()
        assert "train_filenames" not in record  # too few views to hold some out


def test_the_sparse_cloud_projects_onto_pixel_centres(stored, out):
    cloud: Any = trimesh.load(out / "sparse_pc.ply")
    camera = Dataset.open(stored).views()[0].camera()
    view = Dataset.open(stored).views()[0].geometry()
    count = int(np.isfinite(view.Z).sum())
    pixels, _ = project(np.asarray(cloud.vertices)[:count], camera.K, np.array(camera.world_T_camera))
    assert np.abs(pixels - np.rint(pixels)).max() < 1e-2  # coordinates are float32
    rows = [line.split() for line in (out / "sparse/0/points3D.txt").read_text().splitlines()[1:]]
    np.testing.assert_allclose([[float(value) for value in row[1:4]] for row in rows], cloud.vertices, atol=1e-6)


def test_every_eighth_view_is_held_out_and_all_three_splits_are_named(stored):
    camera = Dataset.open(stored).views()[0].camera()
    pictures = [Picture(f"left_{n:03d}.png", camera, np.eye(4), n % HELD_OUT == 0) for n in range(10)]
    record = transforms(pictures, depth=False, masks=False)
    assert record["val_filenames"] == record["test_filenames"] == ["images/left_000.png", "images/left_008.png"]
    assert len(record["train_filenames"]) == 8
