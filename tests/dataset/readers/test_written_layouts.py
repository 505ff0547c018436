"""Each reader on a small folder that was written after its format's specification."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glassware.dataset.readers.recognition import LAYOUTS, open_source
from glassware.dataset.readers.source_view import kinds_of

#: Depths are stored in tenths of a millimetre or as half floats at 0.6 m.
DEPTH_ERROR = 5e-4
POSE_ERROR = 1e-6


def views(root: Path, name: str) -> list[Any]:
    layout, collection = open_source(root)
    assert layout.name == name
    assert collection.left_out == ()
    return [entry.read() for entry in collection.entries]


def same_depth(found: Any, expected: np.ndarray) -> bool:
    assert found is not None
    known = expected > 0.0
    return bool(np.isnan(found[~known]).all() and np.abs(found[known] - expected[known]).max() < DEPTH_ERROR)


def test_keypose_has_stereo_pairs_both_depths_and_poses_of_its_models(makers, tmp_path):
    makers.keypose(tmp_path)
    found = views(tmp_path, "keypose")
    for number, view in enumerate(found):  # channel R in the first file, D in the second
        assert (view.picture == makers.picture(number)).all()
        assert (view.right == makers.picture(number + 100)).all()
        assert same_depth(view.Z, makers.depth())
        assert np.isnan(view.sensor_Z).sum() > np.isnan(view.Z).sum()
        assert view.camera.world_T_camera == pytest.approx(makers.world_T_camera(number), abs=POSE_ERROR)
        assert view.camera.baseline == 0.12
        (item,) = view.objects
        assert (view.instances == item.id).sum() == (makers.ids() == 1).sum()
        assert item.camera_T_object[:3, 2] == pytest.approx(makers.POSES[0][:3, 2], abs=POSE_ERROR)
        assert item.camera_T_object[:3, 3] == pytest.approx(makers.POSES[0][:3, 3], abs=POSE_ERROR)
        assert item.size == pytest.approx(makers.SIZE)
        assert item.symmetry.turns
        assert (item.keypoints.pixels[:, 0] - 31.5) / 60.0 * item.keypoints.Z == pytest.approx([-0.1, -0.1], abs=1e-6)


def test_keypose_without_models_has_no_poses(makers, tmp_path):
    makers.keypose(tmp_path / "data", frames=1)
    (tmp_path / "data" / "objects" / "bottle_0.obj").unlink()
    (view,) = views(tmp_path / "data", "keypose")
    assert view.objects[0].camera_T_object is None
    assert "poses" not in kinds_of(view)


def test_frames_of_keypose_that_are_known_to_be_damaged_are_left_out(makers, tmp_path):
    makers.keypose(tmp_path, frames=11, obj="mug_3", sequence="texture_8_pose_3")
    _, collection = open_source(tmp_path)
    assert [item.name for item in collection.left_out] == ["mug_3/texture_8_pose_3/000010"]
    assert len(collection.entries) == 10


@pytest.mark.parametrize("write", ["bop", "bop_shards"])
def test_bop_has_metres_boxes_about_their_centres_and_axes_of_revolution_along_z(makers, tmp_path, write):
    getattr(makers, write)(tmp_path)
    first, second = views(tmp_path, {"bop": "bop", "bop_shards": "bop-webdataset"}[write])
    assert (first.picture == makers.picture(0)).all()
    assert same_depth(first.Z, makers.depth())
    assert first.sensor_Z is None  # the split is rendered
    assert (first.instances == np.where(makers.ids() > 0, makers.ids() + 1, 0)).all()
    assert second.camera.world_T_camera == pytest.approx(makers.world_T_camera(1), abs=POSE_ERROR)
    assert np.allclose(first.camera.K, makers.K)
    turning, halved = first.objects
    assert turning.camera_T_object[:3, 2] == pytest.approx(makers.POSES[0][:3, 1], abs=POSE_ERROR)
    middle = makers.POSES[0] @ [0.005, 0.010, -0.020, 1.0]
    assert turning.camera_T_object[:3, 3] == pytest.approx(middle[:3], abs=POSE_ERROR)
    assert turning.size == pytest.approx([0.10, 0.06, 0.08])  # along z, x, y of the model
    assert turning.symmetry.turns
    assert not turning.symmetry.ball
    assert halved.symmetry.motions[1] == pytest.approx(np.diag([-1.0, -1.0, 1.0, 1.0]), abs=POSE_ERROR)
    assert halved.transparent is None
    assert turning.box == (17.5, 17.5, 25.5, 32.5)


def test_images_of_bop_are_one_scene_while_their_objects_stand_still(makers, tmp_path):
    folder = makers.bop(tmp_path, images=4)
    gt = makers.json.loads((folder / "scene_gt.json").read_text())
    for number in ("2", "3"):
        for item in gt[number]:
            item["cam_t_m2c"][2] += 100.0
    makers.save_json(folder / "scene_gt.json", gt)
    _, collection = open_source(tmp_path)
    scenes = [entry.scene for entry in collection.entries]
    assert scenes[0] == scenes[1] != scenes[2]


def test_depth_of_captured_bop_splits_is_a_sensors(makers, tmp_path):
    makers.bop(tmp_path, images=1, split="test")
    (view,) = views(tmp_path, "bop")
    assert view.Z is None
    assert same_depth(view.sensor_Z, makers.depth())


@pytest.mark.parametrize(("version", "last"), [(1, "stuff"), (2, "storage box")])
def test_classes_of_trans10k_are_levels_in_version_1_and_palette_indices_in_version_2(makers, tmp_path, version, last):
    makers.trans10k(tmp_path, version)
    _, collection = open_source(tmp_path)
    assert [entry.split for entry in collection.entries] == ["test", "train"]
    view: Any = collection.entries[0].read()
    assert collection.classes[int(view.classes.max())] == last
    expected = np.array([0, 1, 2] if version == 1 else [0, 7, 11])[makers.ids()]
    assert (view.classes == expected).all()
    assert kinds_of(view) == ("classes",)


def test_transcg_reads_the_steps_of_each_camera_and_only_good_perspectives(makers, tmp_path):
    makers.transcg(tmp_path)
    _, collection = open_source(tmp_path)
    assert [entry.name for entry in collection.entries] == ["scene1/0/D435", "scene1/1/D435", "scene1/1/L515"]
    for entry in collection.entries:
        view: Any = entry.read()
        assert same_depth(view.Z, makers.depth())
        assert (view.classes == (makers.ids() > 0)).all()
        assert np.allclose(view.camera.K, makers.K)


def test_todd_takes_the_first_object_as_its_world_and_zero_and_infinity_as_unknown(makers, tmp_path):
    makers.todd(tmp_path)
    first, second = views(tmp_path, "todd")
    placed = [
        [(view.camera.world_T_camera @ item.camera_T_object) for item in view.objects] for view in (first, second)
    ]
    assert np.array(placed[0]) == pytest.approx(np.array(placed[1]), abs=1e-6)
    assert placed[0][0] == pytest.approx(np.eye(4), abs=1e-6)
    assert np.isnan(first.sensor_Z[0, 0])
    assert np.isnan(first.Z[0, 0])
    assert set(np.unique(first.instances)) == {0, 2, 3}
    _, collection = open_source(tmp_path)
    assert len({entry.scene for entry in collection.entries}) == 1


@pytest.mark.parametrize("inverse", [False, True])
def test_clearpose_finds_the_direction_of_its_cameras_and_scales_old_intrinsics(makers, tmp_path, inverse):
    makers.clearpose(tmp_path, inverse=inverse)
    found = views(tmp_path, "clearpose")
    for number, view in enumerate(found):
        assert view.camera.world_T_camera == pytest.approx(makers.world_T_camera(number), abs=POSE_ERROR)
        assert [view.camera.K[0, 0], *view.camera.K[:2, 2]] == pytest.approx([601.46, 334.90, 248.15], abs=0.01)
        assert [item.transparent for item in view.objects] == [True, False]
        assert set(np.unique(view.instances)) == {0, 2, 3}
    assert np.isnan(found[0].sensor_Z).sum() > np.isnan(found[0].Z).sum()
    _, collection = open_source(tmp_path)
    assert {(entry.scene, entry.split) for entry in collection.entries} == {("set4/scene1", "train")}


def test_objects_of_clearpose_whose_class_is_there_twice_have_no_instances(makers, tmp_path):
    makers.clearpose(tmp_path, classes=(7, 7))
    view = views(tmp_path, "clearpose")[0]
    assert view.instances is None
    assert len(view.objects) == 2


@pytest.mark.parametrize("inverse", [False, True])
def test_syn_todd_has_opencv_axes_whichever_way_its_extrinsics_go(makers, tmp_path, inverse):
    makers.syn_todd(tmp_path, inverse=inverse)
    found = views(tmp_path, "syn-todd")
    for number, view in enumerate(found):
        assert view.camera.world_T_camera == pytest.approx(makers.world_T_camera(number), abs=POSE_ERROR)
        assert np.allclose(view.camera.K, makers.K)
        by_name = {item.name: item for item in view.objects}
        glass = by_name["transparent_vessel_with_a_name_longer_than_forty"]
        assert glass.camera_T_object == pytest.approx(makers.seen_from(number)[0], abs=POSE_ERROR)
        assert glass.size == pytest.approx(makers.SIZE)
        assert (glass.transparent, by_name["bowl"].transparent) == (True, False)
        assert ((view.instances == glass.id) == (makers.ids() == 1)).all()
        assert (view.instances[makers.ids() == 0] == 1).all()  # the table


def test_ttd_has_pairs_with_poses_of_what_can_be_seen(makers, tmp_path):
    makers.ttd(tmp_path)
    (view,) = views(tmp_path, "ttd")
    (item,) = view.objects
    assert item.name == "glass"
    assert item.size == pytest.approx(makers.SIZE)
    centre = makers.POSES[0] @ [0.007, 0.0, 0.0, 1.0]
    assert item.camera_T_object[:3, 3] == pytest.approx(centre[:3])
    assert np.allclose(view.camera.K, makers.K, atol=1e-5)
    assert view.camera.baseline == 0.117341
    assert ((view.instances == item.id) == (makers.ids() == 1)).all()


@pytest.mark.parametrize("captured", [False, True])
def test_dreds_and_std_have_both_depths_at_the_size_of_their_labels(makers, tmp_path, captured):
    makers.dreds(tmp_path, captured)
    (view,) = views(tmp_path, "dreds")
    assert view.picture.shape == (makers.HEIGHT, makers.WIDTH, 3)
    assert same_depth(view.Z, makers.depth())
    assert same_depth(view.sensor_Z, makers.depth())
    assert [(item.category, item.transparent) for item in view.objects] == [("bottle", True), ("mug", False)]
    assert (view.instances == np.array([0, 3, 4])[makers.ids()]).all()
    focal = 918.295 / 1280 if captured else 446.31 / 640
    assert view.camera.K[0, 0] / makers.WIDTH == pytest.approx(focal, rel=1e-5)


def test_every_layout_has_a_test_here_or_on_real_samples(makers):
    written = {"bop-webdataset" if name == "bop_shards" else name.replace("_", "-") for name in dir(makers)}
    assert set(LAYOUTS) - written == {"cleargrasp"}
