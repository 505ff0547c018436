"""KeyPose's files, parsed by protobuf with the messages of its data.proto, and used as its own code uses them."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from glassware.dataset.exports.run import export
from glassware.dataset.format.exr import read_exr
from glassware.dataset.reader import Dataset

#: Rounding of a pixel coordinate to float32, as protobuf stores it [px].
SINGLE = 1e-4


@pytest.fixture(scope="module")
def messages():
    """(name, text) -> message: KeyPose's data.proto, written down again."""
    protobuf = pytest.importorskip("google.protobuf")
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, text_format

    assert protobuf
    kinds = {"float": 2, "int32": 5, "bool": 8}
    fields = {
        "Transform": [("element", "float", 3)],
        "Camera": [(name, "float", 1) for name in ("fx", "fy", "cx", "cy", "baseline", "resx", "resy")],
        "KeyPoint": [(name, "float", 1) for name in ("u", "v", "x", "y", "z", "visible")],
        "Target": [("transform", "Transform", 1), ("camera", "Camera", 1), ("keypoints", "KeyPoint", 3)],
        "KeyTargets": [("kp_target", "Target", 1), ("proj_targets", "Target", 3), ("mirrored", "bool", 1)],
        "DataParams": [("resx", "int32", 1), ("resy", "int32", 1), ("num_kp", "int32", 1), ("camera", "Camera", 1)],
    }
    file = descriptor_pb2.FileDescriptorProto(name="keypose.proto", package="keypose", syntax="proto2")
    for name, rows in fields.items():
        message = file.message_type.add(name=name)
        for number, (field, kind, label) in enumerate(rows, start=1):
            entry = message.field.add(name=field, number=number, label=label, type=kinds.get(kind, 11))
            if kind not in kinds:
                entry.type_name = f".keypose.{kind}"
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)

    def parse(name, text):
        message = message_factory.GetMessageClass(pool.FindMessageTypeByName(f"keypose.{name}"))()
        return text_format.Parse(text, message)

    return parse


@pytest.fixture
def out(stored, add_sensor_depth, tmp_path):
    export(add_sensor_depth(stored), "keypose", tmp_path / "out")
    return tmp_path / "out"


def sequences(stored, out):
    """Pairs of a vessel's record and its folder."""
    listed = json.loads((out / "scenes" / "000000.json").read_text())["sequences"]
    records = {record.id: record for record in Dataset.open(stored).scene(0).objects().objects}
    return [(records[int(path.rsplit("_", 1)[1])], out / path) for path in listed]


def test_there_is_a_sequence_for_each_vessel_that_is_seen(stored, out):
    found = sequences(stored, out)
    assert [record.id for record, _ in found] == [2]
    for record, folder in found:
        assert folder == out / "train" / record.category / f"texture_0_pose_{record.id}"
        assert sorted(path.name for path in folder.glob("*_L.png")) == ["000000_L.png", "000001_L.png"]


def test_cameras_and_poses_come_back(stored, out, messages):
    for record, folder in sequences(stored, out):
        params = messages("DataParams", (folder / "data_params.pbtxt").read_text())
        assert (params.resx, params.resy, params.num_kp) == (params.camera.resx, params.camera.resy, 2)
        for view in Dataset.open(stored).views():
            camera = view.camera()
            for letter, pose in (("L", camera.world_T_camera), ("R", camera.world_T_right)):
                text = (folder / f"{view.number:06d}_{letter}.pbtxt").read_text()
                target = messages("KeyTargets", text).kp_target
                matrix = np.reshape(target.transform.element, (4, 4))
                np.testing.assert_allclose(matrix @ np.array(pose), np.eye(4), atol=1e-6)
                found = [target.camera.fx, target.camera.fy, target.camera.cx, target.camera.cy]
                np.testing.assert_allclose(found, [camera.fx, camera.fy, *camera.centre], rtol=1e-6)
                assert target.camera.baseline == pytest.approx(camera.baseline, rel=1e-6)
        assert record.symmetries_continuous


def test_keypoints_of_both_eyes_meet_at_the_ends_of_the_axis(stored, out, messages):
    """As KeyPose's code has it: (u, v, f b / z) through its Q matrix, and the inverse of the transform."""
    for record, folder in sequences(stored, out):
        half = 0.5 * record.size[2]
        ends = np.array([[0.0, 0.0, half, 1.0], [0.0, 0.0, -half, 1.0]]) @ np.array(record.world_T_object).T
        for path in folder.glob("*_?.pbtxt"):
            message = messages("KeyTargets", path.read_text())
            assert message.proj_targets[0] == message.kp_target
            for target in (message.kp_target, *message.proj_targets):
                camera = target.camera
                Q = np.array([[1, 0, 0, -camera.cx], [0, 1, 0, -camera.cy], [0, 0, 0, camera.fx], [0, 0, 0, 0.0]])
                Q[3, 2] = 1.0 / camera.baseline
                uvd = np.array([[k.u, k.v, camera.fx * camera.baseline / k.z, 1.0] for k in target.keypoints])
                world = uvd @ (np.linalg.inv(np.reshape(target.transform.element, (4, 4))) @ Q).T
                np.testing.assert_allclose(world[:, :3] / world[:, 3:], ends[:, :3], atol=2e-5)
                for keypoint in target.keypoints:
                    assert keypoint.x * camera.resx == pytest.approx(keypoint.u, abs=SINGLE)
                    inside = 0 <= keypoint.u < camera.resx and 0 <= keypoint.v < camera.resy
                    assert keypoint.visible == inside
        left, right = (messages("KeyTargets", (folder / f"000000_{eye}.pbtxt").read_text()) for eye in "LR")
        for one, other in zip(left.kp_target.keypoints, right.kp_target.keypoints, strict=True):
            disparity = left.kp_target.camera.fx * left.kp_target.camera.baseline / one.z
            assert one.u - other.u == pytest.approx(disparity, abs=10 * SINGLE)
            assert one.v == pytest.approx(other.v, abs=10 * SINGLE)


def test_masks_pictures_and_depth_are_those_of_the_view(stored, out):
    for record, folder in sequences(stored, out):
        for view in Dataset.open(stored).views():
            stem, geometry = f"{view.number:06d}", view.geometry()
            for eye, letter in (("left", "L"), ("right", "R")):
                assert (folder / f"{stem}_{letter}.png").read_bytes() == (view.folder / f"{eye}.png").read_bytes()
            mask = cv2.imread(str(folder / f"{stem}_mask.png"), cv2.IMREAD_UNCHANGED)
            np.testing.assert_array_equal(mask == 255, geometry.id == record.id)
            border = cv2.imread(str(folder / f"{stem}_border.png"), cv2.IMREAD_UNCHANGED) == 255
            assert border.any()
            assert not (border & (mask == 255)).any()
            depth = read_exr(folder / f"{stem}_Do.exr")["D"]
            np.testing.assert_array_equal(depth, np.where(np.isfinite(geometry.Z), geometry.Z, 0.0))
            sensed = read_exr(folder / f"{stem}_Dt.exr")["D"]
            assert (sensed[::5] == 0.0).all()
            known = sensed > 0.0
            np.testing.assert_allclose(sensed[known], geometry.Z[known], atol=5.1e-4)


def test_objects_have_vertices_and_keypoints_by_name(stored, out):
    for record, _ in sequences(stored, out):
        text = (out / "train" / "objects" / f"{record.category}_0_{record.id}.obj").read_text()
        parts = {part.split("\n", 1)[0]: part.count("\nv ") for part in text.split("o ")[1:]}
        assert list(parts) == ["mesh", "kp.000", "kp.001"]
        assert parts["mesh"] > 50
        assert parts["kp.000"] == parts["kp.001"] == 1
