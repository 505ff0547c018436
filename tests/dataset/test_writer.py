from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.dataset.format.pictures import stored_radiance
from glassware.dataset.format.views_table import SCHEMA
from glassware.dataset.reader import Dataset
from glassware.dataset.verification.scene import check_written
from glassware.dataset.writer import finish_dataset, start_dataset
from glassware.procedural.description.surroundings import AreaLight, ConstantEnvironment, PictureEnvironment
from glassware.procedural.surroundings.lights import aimed
from glassware.procedural.surroundings.photometry import photometry

TESTS = Path(__file__).parents[1]


def _names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def _files(root):
    return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def test_the_files_are_those_of_the_contract(stored):
    view = ["camera.json", "geometry.exr", "instances.png", "labels.json", "left.exr", "left.png", "right.exr"]
    assert _names(stored) == ["dataset.json", "scenes", "views.parquet"]
    assert _names(stored / "scenes") == ["000000"]
    scene = stored / "scenes" / "000000"
    assert _names(scene) == ["000", "001", "checksums.json", "meshes", "objects.json", "scene.json", "views.json"]
    assert _names(scene / "001") == sorted([*view, "right.png"])


def test_json_has_sorted_keys(stored):
    for path in stored.rglob("*.json"):
        pairs = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=list)
        assert [key for key, _ in pairs] == sorted(key for key, _ in pairs)


def test_everything_comes_back(made, stored):
    scene, _, views = made
    data = Dataset.open(stored)
    assert data.head.seed == 7
    (found,) = data.scenes
    assert found.scene().model_dump_json() == scene.model_dump_json()
    assert len(found.views) == len(views)
    for view, again in zip(views, found.views, strict=True):
        assert again.camera().model_dump_json() == scene.cameras[view.frame.view].model_dump_json()
        assert again.labels().model_dump_json() == view.labels.model_dump_json()
        np.testing.assert_array_equal(again.radiance("left"), view.frame.left.astype(np.float16))
        np.testing.assert_array_equal(again.radiance("right"), view.frame.right.astype(np.float16))
        for field in vars(view.frame.geometry):
            before, after = getattr(view.frame.geometry, field), getattr(again.geometry(), field)
            assert before.dtype == after.dtype
            half = field in ("normal", "transmittance")  # 11 bits, in docs/format.md
            np.testing.assert_array_equal(before.astype(np.float16) if half else before, after)


def test_radiance_that_a_half_cannot_hold_stays_float32():
    light = np.array([[[1.0, 60_000.0, 3e-5]]], np.float32)
    assert stored_radiance(light, 1.0).dtype == np.float16
    assert stored_radiance(2.0 * light, 1.0).dtype == np.float32  # beyond 65504
    assert stored_radiance(light, 1e3).dtype == np.float32  # black is below the smallest half of 11 bits


def test_labels_on_disk_pass_every_check(stored):
    for found in Dataset.open(stored).scenes:
        for view in found.views:
            check_written(view, found.scene(), found.objects())


def test_the_index_has_a_row_for_each_view(made, stored):
    _, _, views = made
    table = pq.read_table(stored / "views.parquet")
    assert table.schema.equals(SCHEMA)
    rows = table.to_pylist()
    assert [row["view"] for row in rows] == [0, 1]
    assert all((stored / row["left"]).is_file() and (stored / row["right"]).is_file() for row in rows)
    assert rows[0]["object_ids"] == [2, 3, 4]
    assert rows[1]["visible_fractions"] == [label.fractions.visible for label in views[1].labels.objects]
    assert rows[0]["noise_left"] is None


def test_writing_the_same_scene_again_gives_the_same_bytes(made, head, stored, write_scene):
    scene, points, views = made
    before = _files(stored)
    start_dataset(stored, head, [0])
    write_scene(stored, scene, points, iter(views))
    finish_dataset(stored)
    assert _files(stored) == before


def test_a_data_set_grows_by_another_scene(made, head, stored, write_scene):
    scene, points, views = made
    start_dataset(stored, head, [12])
    write_scene(stored, scene.model_copy(update={"scene_id": 12}), points, views[:1])
    assert finish_dataset(stored) == 3
    assert [found.scene_id for found in Dataset.open(stored).scenes] == [0, 12]


def test_a_scene_added_to_a_build_keeps_what_the_head_says_of_the_build(made, head, tmp_path, write_scene):
    scene, points, views = made
    root = tmp_path / "data"
    start_dataset(root, head.model_copy(update={"scenes": "0:5", "hashes": {"assets": "0" * 64}}), [0])
    write_scene(root, scene.model_copy(update={"scene_id": 7}), points, views[:1])
    finish_dataset(root, head)
    found = Dataset.open(root).head
    assert found.scenes == "0:5,7"
    assert found.hashes == {"assets": "0" * 64}


def test_scenes_of_another_seed_or_setting_are_not_mixed_in(made, head, stored):
    before = _files(stored)
    for change, words in (({"seed": 8}, "seed"), ({"config": {"spp": 16}}, "setting spp")):
        with pytest.raises(InputError, match=words):
            start_dataset(stored, head.model_copy(update=change), [1])
        assert _files(stored) == before
    start_dataset(stored, head.model_copy(update={"seed": 8}), [0, 1])  # all of them are replaced


def test_a_stopped_replacement_leaves_the_old_data_set_as_it_was(made, head, stored, write_scene):
    scene, points, _ = made
    before = _files(stored)

    def stopped():
        raise KeyboardInterrupt
        yield

    start_dataset(stored, head.model_copy(update={"seed": 8}), [0])
    with pytest.raises(KeyboardInterrupt):
        write_scene(stored, scene.model_copy(update={"seed": 8}), points, stopped())
    assert _files(stored) == before


def test_a_finished_replacement_has_the_new_head(made, head, stored, write_scene):
    scene, points, views = made
    other = head.model_copy(update={"seed": 8})
    start_dataset(stored, other, [0])
    write_scene(stored, scene.model_copy(update={"seed": 8}), points, iter(views))
    finish_dataset(stored, other)
    assert Dataset.open(stored).head.seed == 8


def test_two_processes_with_other_seeds_do_not_share_a_folder(head, tmp_path):
    start_dataset(tmp_path / "a", head, [0])
    (tmp_path / "a" / "scenes" / f".000000.partial-{os.getppid()}").mkdir()  # the parent process is alive
    with pytest.raises(InputError, match="seed"):
        start_dataset(tmp_path / "a", head.model_copy(update={"seed": 8}), [1])
    start_dataset(tmp_path / "a", head, [1])  # with the same seed they may


def test_a_folder_that_holds_something_else_is_not_touched(head, tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"something else \(thesis.tex"):
        start_dataset(tmp_path, head, [0])
    assert _names(tmp_path) == ["thesis.tex"]
    with pytest.raises(InputError, match="a folder"):
        start_dataset(tmp_path / "thesis.tex", head, [0])


def test_a_data_set_of_an_unknown_schema_is_not_touched(head, stored):
    path = stored / "dataset.json"
    path.write_text(path.read_text().replace("glassware/dataset/1", "glassware/dataset/2"))
    before = _files(stored)
    with pytest.raises(InputError, match="glassware/dataset/1, found glassware/dataset/2"):
        start_dataset(stored, head, [0])
    assert _files(stored) == before


def test_an_exception_between_views_leaves_nothing_of_the_scene(made, head, tmp_path, write_scene):
    scene, points, views = made

    def failing():
        yield views[0]
        raise RuntimeError("out of light")

    start_dataset(tmp_path / "a", head, [0])
    with pytest.raises(RuntimeError, match="out of light"):
        write_scene(tmp_path / "a", scene, points, failing())
    assert _names(tmp_path / "a" / "scenes") == []
    assert finish_dataset(tmp_path / "a") == 0


def test_assets_are_listed_with_their_licences(made, head, tmp_path, write_scene):
    scene, points, views = made
    assert cv2.imwrite(str(tmp_path / "sky.hdr"), np.full((4, 8, 3), 0.5, np.float32))
    sky = asset(tmp_path / "sky.hdr").model_copy(update={"licence": "CC0"})
    scene = scene.model_copy(update={"environment": PictureEnvironment(asset=sky)})
    start_dataset(tmp_path / "a", head, [0])
    write_scene(tmp_path / "a", scene, points, views)
    finish_dataset(tmp_path / "a")
    (listed,) = Dataset.open(tmp_path / "a").head.assets
    assert (listed.licence, listed.source) == ("CC0", "sky.hdr")
    assert (tmp_path / "a" / listed.path).read_bytes() == (tmp_path / "sky.hdr").read_bytes()


def test_the_light_of_a_scene_is_a_label(made, head, tmp_path, write_scene):
    scene, points, views = made
    pose = aimed(np.array([0.0, 0.5, 2.0]), np.zeros(3), 0.0)
    lamp = AreaLight(kind="panel", world_T_light=pose, size=(0.6, 0.6), radiance=(3.0, 3.0, 3.0))
    even = ConstantEnvironment(radiance=(0.1, 0.1, 0.1))
    scene = scene.model_copy(update={"environment": even, "lights": (lamp,)})
    start_dataset(tmp_path / "a", head, [0])
    write_scene(tmp_path / "a", scene, points, views)
    finish_dataset(tmp_path / "a")
    (stored,) = Dataset.open(tmp_path / "a").scenes
    light = stored.photometry()
    assert light is not None
    assert light == photometry(scene.environment, scene.lights)
    # 100 cd/m^2 all around, and a panel of 3000 cd/m^2.
    assert light.environment_illuminance == pytest.approx(100.0 * np.pi, rel=1e-6)
    (panel,) = light.lamps
    assert (panel.kind, panel.luminance) == ("panel", pytest.approx(3000.0))
    assert panel.flux == pytest.approx(np.pi * 0.36 * 3000.0)
    assert light.illuminance == pytest.approx(light.environment_illuminance + panel.illuminance)
    # A scene of an earlier version has none.
    file = stored.folder / "views.json"
    record = json.loads(file.read_text())
    del record["photometry"]
    file.write_text(json.dumps(record))
    assert stored.photometry() is None


CHILD = """
import importlib.util, pathlib, signal, sys, time
spec = importlib.util.spec_from_file_location("analytic", sys.argv[2])
analytic = importlib.util.module_from_spec(spec)
sys.modules["analytic"] = analytic
spec.loader.exec_module(analytic)
from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import annotate
from glassware.dataset.format.dataset_file import DatasetFile
from glassware.dataset.writer import scene_writer, start_dataset
signal.signal(signal.SIGINT, signal.default_int_handler)  # also where the parent ignores it
root, scene = pathlib.Path(sys.argv[1]), analytic.scene(2)
points = scene_keypoints(scene)
start_dataset(root, DatasetFile(name="t", seed=7, config={}, versions={}, backend="none"), [0])
with scene_writer(root, scene, points) as writer:
    for camera in scene.cameras:
        frame = analytic.frame(scene, camera)
        sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
        writer.add(frame, annotate(scene, camera, frame.geometry, points, sight))
        print("view", flush=True)
        time.sleep(60)
"""


def _stopped(root, how):
    command = [sys.executable, "-P", "-c", CHILD, str(root), str(TESTS / "analytic.py")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "view\n"
        child.send_signal(how)
        child.wait(timeout=30)
        assert child.returncode != 0


def test_ctrl_c_leaves_no_half_scene_and_no_stray_folder(head, tmp_path):
    _stopped(tmp_path / "a", signal.SIGINT)
    assert _names(tmp_path / "a" / "scenes") == []
    assert Dataset.open(tmp_path / "a").scenes == ()


def test_what_a_killed_process_leaves_is_no_scene_and_goes_with_the_next_start(head, tmp_path):
    _stopped(tmp_path / "a", signal.SIGKILL)
    (stray,) = _names(tmp_path / "a" / "scenes")
    assert stray.startswith(".000000.partial-")
    assert Dataset.open(tmp_path / "a").scenes == ()
    start_dataset(tmp_path / "a", head, [0])
    assert _names(tmp_path / "a" / "scenes") == []
