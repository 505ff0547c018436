"""Readers of KeyPose and ClearGrasp on frames of the data sets themselves.

They are looked for in ``../shared/data``, as the projects' repositories have them; without them these tests skip.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glassware.annotate.boxes import amodal_box, box_corners, modal_box
from glassware.annotate.projection import inverse_pose, transformed, unproject
from glassware.dataset.readers.recognition import open_source
from glassware.dataset.readers.source_view import Collection, kinds_of
from glassware.dataset.readers.text_proto import numbers, read_text_proto

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"
#: Masks were drawn by hand, and the model is one of a few hundred points [px].
MASK_ERROR = 12.0


def sample(name: str) -> Collection:
    if not (DATA / name).is_dir():
        pytest.skip(f"no sample of {name} in {DATA}")
    layout, collection = open_source(DATA / name)
    assert layout.name == name
    assert not collection.left_out
    return collection


def view_of(collection: Collection, end: str) -> Any:
    return next(entry.read() for entry in collection.entries if entry.name.endswith(end))


def test_keypoints_of_keypose_lie_at_the_same_place_in_the_world_in_all_its_frames():
    placed = []
    for entry in sample("keypose").entries:
        view: Any = entry.read()
        (item,) = view.objects
        placed.append(transformed(view.camera.world_T_camera @ item.camera_T_object, np.zeros((1, 3)))[0])
    assert len(placed) == 2
    assert np.linalg.norm(placed[0] - placed[1]) < 0.002  # labels of one point, by another frame


def test_the_disparity_of_keyposes_keypoints_is_that_of_its_baseline():
    collection = sample("keypose")
    view: Any = collection.entries[0].read()
    (item,) = view.objects
    path = next((DATA / "keypose").rglob("000001_R.pbtxt"))
    right = [numbers(p, "u", 1, path)[0] for p in read_text_proto(path)["kp_target"][0]["keypoints"]]
    shift = item.keypoints.pixels[:, 0] - right
    assert shift == pytest.approx(view.camera.K[0, 0] * view.camera.baseline / item.keypoints.Z, abs=0.1)


def test_the_box_of_keyposes_aligned_model_is_around_its_mask():
    for entry in sample("keypose").entries:
        view: Any = entry.read()
        (item,) = view.objects
        corners = transformed(item.camera_T_object, box_corners(tuple(item.size)))
        box, mask = amodal_box(corners, view.camera.K), modal_box(view.instances == item.id)
        assert box is not None
        assert mask is not None
        assert np.abs(np.subtract(box, mask)).max() < MASK_ERROR
        assert entry.split == "test"


def test_depth_of_cleargrasps_renders_agrees_with_their_normals_and_poses():
    view = view_of(sample("cleargrasp"), "000000000")
    rows, columns = slice(500, 900), slice(1200, 1700)  # the tray and what lies in it
    K = view.camera.K - np.array([[0, 0, columns.start], [0, 0, rows.start], [0, 0, 0]])
    points, normals = unproject(view.Z[rows, columns], K), view.normals[rows, columns]
    # Half floats at 1 m are 1 mm apart, so over 16 pixels.
    across, down = points[8:-8, 16:] - points[8:-8, :-16], points[16:, 8:-8] - points[:-16, 8:-8]
    normal = np.cross(down, across)
    alike = (normal * normals[8:-8, 8:-8]).sum(axis=-1) / np.linalg.norm(normal, axis=-1)
    assert np.nanmedian(alike) > 0.99
    floor = view.normals[view.instances == 0] @ view.camera.world_T_camera[:3, :3].T
    assert np.nanmedian(floor, axis=0) == pytest.approx([0.0, 0.0, 1.0], abs=0.01)
    for item in view.objects:
        seen = np.nanmedian(view.Z[view.instances == item.id])
        assert 0.0 < item.camera_T_object[2, 3] - seen + 0.05 < 0.15  # its middle is behind what is seen of it
        assert inverse_pose(item.camera_T_object) @ item.camera_T_object == pytest.approx(np.eye(4), abs=1e-6)


@pytest.mark.parametrize(("number", "missing"), [("000000080", 0.49), ("000000123", 0.29)])
def test_the_depth_camera_of_cleargrasp_misses_glass_and_agrees_beside_it(number, missing):
    view = view_of(sample("cleargrasp"), number)
    glass = view.classes == 1
    assert np.isnan(view.sensor_Z[glass]).mean() == pytest.approx(missing, abs=0.01)
    error = np.abs(view.sensor_Z - view.Z)[~glass]
    assert np.nanmedian(error) < 0.002
    assert np.nanmedian((view.sensor_Z - view.Z)[glass]) > 0.01  # it sees what is behind the glass
    facing = view.normals[..., 2][np.isfinite(view.normals[..., 2])]
    assert (facing < 0.1).mean() > 0.99
    assert kinds_of(view) == ("intrinsics", "depth", "sensor-depth", "normals", "classes")
