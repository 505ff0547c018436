from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from glassware.dataset.commands.view import main
from glassware.dataset.reader import Dataset
from glassware.dataset.viewer.choice import chosen

RERUN = Path(sys.executable).with_name("rerun")


@pytest.fixture
def recording(proven, tmp_path):
    """A recording, its chunks by entity."""
    chunk = pytest.importorskip("rerun.chunk")
    path = tmp_path / "out.rrd"
    assert main([str(proven), "--save", str(path)]) == 0
    reader = chunk.RrdReader(str(path))
    assert len(reader.recordings()) == 1
    assert len(reader.blueprints()) == 1
    found: dict[str, dict] = {}
    for part in reader.stream():
        batch = part.to_record_batch()
        columns = {name: batch.column(name).to_pylist() for name in batch.schema.names if ":" in name}
        found.setdefault(str(part.entity_path), {}).update(columns)
    return path, found


def test_rerun_reads_the_same_depth_ids_poses_and_intrinsics(proven, recording):
    _, found = recording
    view = Dataset.open(proven).views()[0]
    camera, geometry = view.camera(), view.geometry()
    depth = found["/world/left/depth"]
    stored = np.frombuffer(bytes(depth["DepthImage:buffer"][0][0]), np.uint16).reshape(geometry.Z.shape)
    metres = stored / depth["DepthImage:meter"][0][0]
    np.testing.assert_allclose(metres, np.where(np.isfinite(geometry.Z), geometry.Z, 0.0), atol=1e-4)
    ids = np.frombuffer(bytes(found["/world/left/ids"]["SegmentationImage:buffer"][0][0]), np.uint16)
    np.testing.assert_array_equal(ids.reshape(geometry.id.shape), geometry.id)
    pose = found["/world/right"]
    np.testing.assert_allclose(pose["Transform3D:translation"][0][0], camera.world_T_right[:3, 3], atol=1e-6)
    turn = np.array(pose["Transform3D:mat3x3"][0][0]).reshape(3, 3).T  # column by column
    np.testing.assert_allclose(turn, camera.world_T_right[:3, :3], atol=1e-6)
    K = np.array(found["/world/left"]["Pinhole:image_from_camera"][0][0]).reshape(3, 3).T
    np.testing.assert_allclose(K, camera.K + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]), rtol=1e-6)


def test_each_object_has_a_pose_a_box_and_surfaces(proven, recording):
    _, found = recording
    for item in Dataset.open(proven).scenes[0].objects().objects:
        entity = f"/world/objects/{item.name}"
        pose = np.asarray(item.world_T_object)
        np.testing.assert_allclose(found[entity]["Transform3D:translation"][0][0], pose[:3, 3], atol=1e-6)
        np.testing.assert_allclose(
            2 * np.array(found[f"{entity}/box"]["Boxes3D:half_sizes"][0][0]), item.size, rtol=1e-6
        )
        assert [name for name in found if name.startswith(f"{entity}/") and "Mesh3D:vertex_positions" in found[name]]


def test_the_checker_of_rerun_finds_nothing_wrong(recording):
    if not RERUN.is_file():
        pytest.skip("needs Rerun's command")
    run = subprocess.run(
        [RERUN, "rrd", "verify", recording[0]], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr
    assert "1 file verified without error" in run.stdout + run.stderr


def test_views_are_evenly_spaced_and_no_more_than_allowed(proven, tmp_path):
    root = tmp_path / "data"
    shutil.copytree(proven, root)
    scenes = root / "scenes"
    for number in range(1, 5):
        shutil.copytree(scenes / "000000", scenes / f"{number:06d}")
    shutil.copytree(scenes / "000000" / "000", scenes / "000000" / "001")
    data = Dataset.open(root)

    def numbers(wanted, most):
        return [(one.scene.scene_id, [view.number for view in one.views]) for one in chosen(data, wanted, most)]

    assert numbers((), 3) == [(0, [0]), (2, [0]), (4, [0])]
    assert numbers((), 99) == [(0, [0, 1]), *((number, [0]) for number in range(1, 5))]
    assert numbers((3, 0), 2) == [(3, [0]), (0, [0])]
    assert numbers((0,), 1) == [(0, [0])]
