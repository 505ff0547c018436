"""BOP's layout, read back by the definitions of its toolkit."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
import trimesh

from glassware.dataset.exports.depth import depth_picture
from glassware.dataset.exports.poses.silhouette import wide_depth, wide_silhouette
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset
from glassware.procedural.description.camera import Camera

#: Pixels of an outline whose centres a mesh and a closed form may decide differently, as a fraction of the silhouette.
EDGE = 0.02


@pytest.fixture
def out(stored, tmp_path):
    export(stored, "bop", tmp_path / "out")
    return tmp_path / "out"


def _json(path):
    return json.loads(path.read_text())


def _png(path):
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def _pose(rotation, translation):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.reshape(rotation, (3, 3)), np.divide(translation, 1000.0)
    return pose


def test_cameras_and_poses_come_back(stored, out):
    scene = out / "train_pbr" / "000000"
    for view in Dataset.open(stored).views():
        camera, found = view.camera(), _json(scene / "scene_camera.json")[str(view.number)]
        np.testing.assert_allclose(np.reshape(found["cam_K"], (3, 3)), camera.K, atol=1e-6)
        world = _pose(found["cam_R_w2c"], found["cam_t_w2c"])
        np.testing.assert_allclose(world @ np.array(camera.world_T_camera), np.eye(4), atol=1e-6)
        poses = _json(scene / "scene_gt.json")[str(view.number)]
        assert [pose["obj_id"] for pose in poses] == [2, 3, 4]
        for pose, label in zip(poses, view.labels().objects, strict=True):
            again = _pose(pose["cam_R_m2c"], pose["cam_t_m2c"])
            np.testing.assert_allclose(again, np.array(label.camera_T_object), atol=1e-6)


def test_masks_are_the_same_to_the_bit_and_depth_to_half_a_step(stored, out):
    scene = out / "train_pbr" / "000000"
    for view in Dataset.open(stored).views():
        geometry, name = view.geometry(), f"{view.number:06d}"
        for number, label in enumerate(view.labels().objects):
            np.testing.assert_array_equal(
                _png(scene / f"mask/{name}_{number:06d}.png") == 255, geometry.crossed[number]
            )
            visible = _png(scene / f"mask_visib/{name}_{number:06d}.png")
            np.testing.assert_array_equal(visible == 255, geometry.id == label.id)
        scale = _json(scene / "scene_camera.json")[str(view.number)]["depth_scale"]
        depth = _png(scene / f"depth/{name}.png") * scale
        assert depth.shape == geometry.Z.shape
        hit = np.isfinite(geometry.Z)
        assert (depth[~hit] == 0).all()
        assert np.abs(depth - 1000.0 * geometry.Z)[hit].max() <= scale / 2 + 1e-3


def test_each_file_has_boxes_by_its_own_convention(stored, out):
    scene = out / "train_pbr" / "000000"
    coco, infos = _json(scene / "scene_gt_coco.json"), _json(scene / "scene_gt_info.json")
    for view in Dataset.open(stored).views():
        annotations = {a["category_id"]: a for a in coco["annotations"] if a["image_id"] == view.number}
        for label, info in zip(view.labels().objects, infos[str(view.number)], strict=True):
            left, top, right, bottom = label.box2d.modal or pytest.fail("every object is visible")
            width, height = right - left, bottom - top
            assert info["bbox_visib"] == [left + 0.5, top + 0.5, width - 1, height - 1]
            assert annotations[label.id]["bbox"] == [left + 0.5, top + 0.5, width, height]
            assert sum(annotations[label.id]["segmentation"]["counts"][1::2]) == info["px_count_visib"]
            assert info["px_count_visib"] == label.pixels.visible
            assert info["px_count_all"] >= label.pixels.silhouette


def test_models_are_in_millimetres_with_their_symmetries(stored, out):
    infos = _json(out / "models" / "models_info.json")
    for record in Dataset.open(stored).scene(0).objects().objects:
        mesh = trimesh.load_mesh(out / "models" / f"obj_{record.id:06d}.ply", process=False)
        info = infos[str(record.id)]
        size = [info["size_x"], info["size_y"], info["size_z"]]
        np.testing.assert_allclose(size, 1000.0 * np.array(record.size), atol=1e-2)
        np.testing.assert_allclose(mesh.extents, size, atol=1e-3)
        np.testing.assert_allclose(mesh.bounds[0], [info["min_x"], info["min_y"], info["min_z"]], atol=1e-3)
        assert max(size) <= info["diameter"] <= np.linalg.norm(size) + 1e-6
    assert infos["2"]["symmetries_continuous"] == [{"axis": [0.0, 0.0, 1.0], "offset": [0.0, 0.0, 0.0]}]
    assert len(infos["3"]["symmetries_continuous"]) == 2  # a ball
    box = infos["4"]["symmetries_discrete"]
    assert len(box) == 3  # half turns
    assert all(np.reshape(motion, (4, 4))[3].tolist() == [0, 0, 0, 1] for motion in box)


def test_pixels_outside_of_the_picture_are_counted(analytic):
    scene = analytic.scene(views=1)
    wide = scene.cameras[0]
    item = scene.objects[2]
    w, h = wide.width // 3, wide.height // 3
    for offset in ((0, 0), (w // 2, 0), (-w // 3, h // 3)):
        # The picture is a third of the wide one, somewhere in it; the canvas is the wide picture, moved by the offset.
        cx, cy = wide.centre
        small = Camera(
            **wide.model_dump(include={"focal", "world_T_camera", "baseline", "exposure", "grid_index"}),
            width=w,
            height=h,
            centre=(cx - w - offset[0], cy - h - offset[1]),
        )
        moved = wide.model_copy(update={"centre": (cx - offset[0], cy - offset[1]), "width": 3 * w, "height": 3 * h})
        truth = analytic.geometry(scene, moved).crossed[2]
        points = np.linalg.inv(wide.world_T_camera) @ np.array(item.world_T_object)
        vertices = item.mesh.vertices @ points[:3, :3].T + points[:3, 3]
        canvas = wide_silhouette(vertices, item.mesh.faces, small.K, w, h)
        assert truth.sum() > 100
        assert (canvas != truth).sum() <= EDGE * truth.sum()


def test_depths_that_do_not_fit_are_coarser_or_unknown():
    near, scale = depth_picture(np.array([[1.0, 6.5, np.inf]]))
    assert (near.tolist(), scale) == ([[10000, 65000, 0]], 0.1)
    far, scale = depth_picture(np.array([[1.0, 60.0, 70.0, np.inf]]))
    assert (far.tolist(), scale) == ([[1000, 60000, 0, 0]], 1.0)


def test_test_scenes_have_a_folder_and_targets_of_their_own(stored, tmp_path):
    splits = {"train": [], "val": [], "test": [0], "unseen_families": [], "unseen_assets": {}}
    (stored / "splits.json").write_text(json.dumps(splits | {"schema_version": "glassware/splits/1"}))
    export(stored, "bop", tmp_path / "out", split="test", vessels_only=True)
    targets = _json(tmp_path / "out" / "test_targets_bop19.json")
    assert {(target["im_id"], target["obj_id"]) for target in targets} == {(0, 2), (1, 2)}
    assert (tmp_path / "out" / "test" / "000000" / "rgb" / "000001.png").is_file()


def test_liquids_are_objects_of_their_own_on_request(proven, tmp_path):
    export(proven, "bop", tmp_path / "out", liquids=True)
    scene, infos = tmp_path / "out/train_pbr/000000", _json(tmp_path / "out/models/models_info.json")
    view = Dataset.open(proven).scene(0).views[0]
    description, geometry, labels = view.scene(), view.geometry(), view.labels().objects
    held = [(body, liquid) for body in description.vessels for liquid in body.liquids]
    assert held
    poses = _json(scene / "scene_gt.json")["0"]
    assert [pose["obj_id"] for pose in poses] == [label.id for label in labels] + [500 + n for n in range(len(held))]

    def mask(kind, number):
        return _png(scene / kind / f"000000_{number:06d}.png") == 255

    ids = [label.id for label in labels]
    for number, (body, liquid) in enumerate(held, start=len(labels)):
        row, model = ids.index(body.id), poses[number]["obj_id"]
        assert poses[number] == poses[row] | {"obj_id": model}
        mesh = trimesh.load_mesh(tmp_path / "out" / "models" / f"obj_{model:06d}.ply")
        assert mesh.volume == pytest.approx(1e9 * liquid.volume, rel=0.01)
        assert infos[str(model)]["category"] == f"liquid, {liquid.medium.name}"
        whole = mask("mask", number)
        assert whole.any()
        assert (whole & ~geometry.crossed[row]).sum() <= EDGE * whole.sum()
        np.testing.assert_array_equal(mask("mask_visib", number), whole & (geometry.id == body.id))
    for row, label in enumerate(labels):
        shown = mask("mask_visib", row)
        for number, (body, _) in enumerate(held, start=len(labels)):
            if body.id == label.id:
                shown |= mask("mask_visib", number)
        np.testing.assert_array_equal(shown, geometry.id == label.id)


def test_depth_of_a_mesh_is_that_of_its_closed_form(analytic):
    scene = analytic.scene(views=1)
    camera, item = scene.cameras[0], scene.objects[2]  # a box: its mesh is the shape itself
    truth = analytic.geometry(scene, camera)
    pose = np.linalg.inv(camera.world_T_camera) @ np.array(item.world_T_object)
    points = item.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
    depth = wide_depth(points, item.mesh.faces, camera.K, camera.width, camera.height)
    depth = depth[camera.height : 2 * camera.height, camera.width : 2 * camera.width]
    shown = (truth.id == item.id) & np.isfinite(depth)
    assert shown.sum() > 0.95 * (truth.id == item.id).sum() > 50
    np.testing.assert_allclose(depth[shown], truth.Z[shown], atol=1e-5)
