"""What `glassware export` writes in other projects' layouts is read back as the labels that it was written from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset
from glassware.dataset.readers.recognition import open_source

#: Poses go through single precision, or through the text of it.
POSE_ERROR = 1e-5
#: A tenth of a millimetre, the step of BOP's depth, and half floats at half a metre [m].
DEPTH_ERROR = 1e-3


def read(root: Path, name: str) -> list[Any]:
    layout, collection = open_source(root)
    assert layout.name == name
    assert collection.left_out == ()
    return [entry.read() for entry in collection.entries]


def depth_agrees(found: np.ndarray | None, expected: np.ndarray) -> bool:
    assert found is not None
    known = np.isfinite(found)
    assert known.any()
    return bool(np.abs(found - expected)[known].max() < DEPTH_ERROR)


@pytest.mark.parametrize(("format_name", "name"), [("bop", "bop"), ("bop-webdataset", "bop-webdataset")])
def test_bop(stored, tmp_path, format_name, name):
    export(stored, format_name, tmp_path / "out")
    stored_views = Dataset.open(stored).views()
    for view, own in zip(read(tmp_path / "out", name), stored_views, strict=True):
        camera = own.camera()
        assert view.camera.world_T_camera == pytest.approx(camera.world_T_camera, abs=POSE_ERROR)
        assert np.allclose(view.camera.K, camera.K)
        assert (view.picture == own.picture()).all()
        assert depth_agrees(view.Z, own.geometry().Z)
        labels = [label for label in own.labels().objects if label.fractions is not None]
        for item, label in zip(view.objects, labels, strict=True):
            assert item.camera_T_object[:3, 3] == pytest.approx(label.camera_T_object[:3, 3], abs=POSE_ERROR)
            assert np.sort(item.size) == pytest.approx(np.sort(np.ptp(label.box3d @ label.camera_T_object[:3, :3], 0)))
            assert ((view.instances == item.id) == (own.geometry().id == label.id)).all()


def test_keypose(stored, tmp_path):
    export(stored, "keypose", tmp_path / "out")
    stored_views = Dataset.open(stored).views()
    found = read(tmp_path / "out", "keypose")
    assert found
    for view in found:
        own = next(one for one in stored_views if (one.picture() == view.picture).all())
        assert (view.right == own.picture("right")).all()
        camera = own.camera()
        assert view.camera.world_T_camera == pytest.approx(camera.world_T_camera, abs=POSE_ERROR)
        assert view.camera.baseline == pytest.approx(camera.baseline)
        assert depth_agrees(view.Z, own.geometry().Z)
        assert np.allclose(view.camera.K, camera.K)
        (item,) = view.objects
        labels = own.labels().objects
        label = next(one for one in labels if ((own.geometry().id == one.id) == (view.instances > 0)).all())
        reach = 0.5 * np.linalg.norm(np.ptp(label.box3d @ label.camera_T_object[:3, :3], axis=0)) + POSE_ERROR
        assert np.abs(item.keypoints.Z - label.camera_T_object[2, 3]).max() < reach


def test_cleargrasp(stored, tmp_path):
    export(stored, "cleargrasp", tmp_path / "out")
    for view, own in zip(read(tmp_path / "out", "cleargrasp"), Dataset.open(stored).views(), strict=True):
        camera = own.camera()
        assert view.camera.world_T_camera == pytest.approx(camera.world_T_camera, abs=POSE_ERROR)
        assert np.allclose(view.camera.K, camera.K, atol=1e-3)
        assert depth_agrees(view.Z, own.geometry().Z)
        normals = view.normals[np.isfinite(view.normals[..., 0])]
        expected = own.geometry().normal[np.isfinite(view.normals[..., 0])]
        assert normals == pytest.approx(expected, abs=2e-3)
        by_place = {tuple(np.round(label.camera_T_object[:3, 3], 4)): label for label in own.labels().objects}
        for item in view.objects:
            label = by_place[tuple(np.round(item.camera_T_object[:3, 3], 4))]
            assert item.camera_T_object == pytest.approx(np.asarray(label.camera_T_object), abs=1e-4)
            assert ((view.instances == item.id) == (own.geometry().id == label.id)).all()


def test_dreds(stored, add_sensor_depth, tmp_path):
    add_sensor_depth(stored)
    export(stored, "dreds", tmp_path / "out")
    for view, own in zip(read(tmp_path / "out", "dreds"), Dataset.open(stored).views(), strict=True):
        assert depth_agrees(view.Z, own.geometry().Z)
        assert depth_agrees(view.sensor_Z, own.geometry().Z)
        ids = own.geometry().id
        by_shape = {(ids == label.id).tobytes(): label for label in own.labels().objects}
        for item in view.objects:
            label = by_shape[(view.instances == item.id).tobytes()]
            assert item.camera_T_object == pytest.approx(np.asarray(label.camera_T_object), abs=POSE_ERROR)


def test_syn_todd(stored, tmp_path):
    export(stored, "syn-todd", tmp_path / "out")
    for view, own in zip(read(tmp_path / "out", "syn-todd"), Dataset.open(stored).views(), strict=True):
        camera = own.camera()
        assert np.allclose(view.camera.K, camera.K, atol=1e-3)
        assert view.camera.baseline == pytest.approx(camera.baseline)
        assert depth_agrees(view.Z, own.geometry().Z)
        for item in view.objects:
            near = [
                np.linalg.norm(one.camera_T_object[:3, 3] - item.camera_T_object[:3, 3]) for one in own.labels().objects
            ]
            assert min(near) < POSE_ERROR
