from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from glassware.learn.decoding.decode import decode
from glassware.learn.metrics.box_iou import box_iou
from glassware.learn.targets.encoding import CORRECTED, REFERENCE
from glassware.learn.targets.view import OPAQUE, detectable, view_targets

HEIGHT, WIDTH = 192, 256
#: Fields are float32 in units of about 1/50 px; 256 px away that is 4e-6 of a box's place, and some ten times that of
#: its size, which is a difference of corners.
IOU = 1.0 - 1e-3
RADIANS, METRES = 1e-3, 1e-4


def outputs_of(targets: dict[str, np.ndarray], offsets: bool = True) -> dict[str, torch.Tensor]:
    """What a perfect network would give: the targets, classes as logits."""
    names = ["heatmap", "vertex", "z_centroid", "covariance"] + (["offset"] if offsets else [])
    outputs = {name: torch.from_numpy(targets[name]) for name in names}
    classes = torch.nn.functional.one_hot(torch.from_numpy(targets["seg"]), OPAQUE + 1)
    return outputs | {"seg": 9.0 * classes.movedim(-1, 0).float()}


def batch_of(views: list, encoding, offsets: bool = True):
    rows = [outputs_of(view_targets(ids, Z, objects, K, encoding), offsets) for ids, Z, objects, K in views]
    outputs = {name: torch.stack([row[name] for row in rows]) for name in rows[0]}
    return outputs, torch.from_numpy(np.stack([K for *_, K in views]))


@pytest.fixture(scope="module")
def views(box_scene):
    rng = np.random.default_rng(5)
    made = []
    for _ in range(12):
        pose, K = box_scene.camera(rng, HEIGHT, WIDTH)
        made.append((*box_scene.view(pose, K, box_scene.boxes(rng, int(rng.integers(1, 6))), HEIGHT, WIDTH), K))
    return made


def matched(views, found):
    """Go through pairs of a label and the detection whose peak is nearest to its pixels' mean."""
    for (ids, _, objects, _), detections in zip(views, found, strict=True):
        for item in detectable(objects):
            y, x = np.nonzero(ids == item.id)
            away = np.linalg.norm(detections.peak.numpy() - [x.mean(), y.mean()], axis=1)
            index = int(away.argmin())
            assert away[index] < 3.0  # a thin sloping object's hottest pixel is not the one nearest to its mean
            yield ids, item, detections, index


@pytest.mark.parametrize("encoding", [CORRECTED, REFERENCE], ids=["corrected", "reference"])
@pytest.mark.parametrize("rotation", ["covariance", "vertices"])
def test_the_targets_decode_to_the_labels_boxes_and_poses(views, encoding, rotation):
    outputs, K = batch_of(views, encoding)
    found = decode(outputs, K, replace(encoding, rotation=rotation))
    assert [len(detections) for detections in found] == [len(detectable(objects)) for _, _, objects, _ in views]
    for _, item, detections, index in matched(views, found):
        pose, size = detections.camera_T_object[index].numpy(), detections.size[index].numpy()
        assert box_iou(pose, size, item.camera_T_object, item.size) > IOU
        np.testing.assert_allclose(pose[:3, 3], item.camera_T_object[:3, 3], atol=METRES)
        np.testing.assert_allclose(size, item.size, atol=METRES)
        turn = pose[:3, :3].T @ item.camera_T_object[:3, :3]
        assert np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)) < RADIANS


def test_the_targets_decode_to_the_labels_masks(views):
    outputs, K = batch_of(views, CORRECTED)
    for ids, item, detections, index in matched(views, decode(outputs, K)):
        np.testing.assert_array_equal(detections.mask[index].numpy(), ids == item.id)


def test_without_offsets_masks_come_from_the_vertex_field(views):
    """As for the released network: exact but for cells that two objects share, and those that count for neither."""
    outputs, K = batch_of(views, REFERENCE, offsets=False)
    overlaps = []
    for ids, item, detections, index in matched(views, decode(outputs, K, REFERENCE)):
        mask, true = detections.mask[index].numpy(), ids == item.id
        overlaps.append((mask & true).sum() / (mask | true).sum())
    assert np.mean(overlaps) > 0.8


def test_nothing_is_found_where_there_is_nothing(box_scene, rng):
    pose, K = box_scene.camera(rng, HEIGHT, WIDTH)
    outputs, K = batch_of([(*box_scene.view(pose, K, [], HEIGHT, WIDTH), K)], CORRECTED)
    (found,) = decode(outputs, K)
    assert len(found) == 0
    assert found.mask.shape == (0, HEIGHT, WIDTH)


def test_a_weaker_copy_of_an_object_is_left_out(views):
    outputs, K = batch_of(views[:1], CORRECTED)
    before = decode(outputs, K)[0]
    x, y = (int(value) for value in before.peak[0])
    # A second, lower peak on the same object, whose cell says the same.
    outputs["heatmap"][0, y + 8, x] = 0.9
    cell = (round(y / 8), round(x / 8))
    shift = 100.0 * 8 / (2 * HEIGHT)
    outputs["vertex"][0, :, cell[0] + 1, cell[1]] = outputs["vertex"][0, :, cell[0], cell[1]]
    outputs["vertex"][0, ::2, cell[0] + 1, cell[1]] -= shift
    for name in ("z_centroid", "covariance"):
        outputs[name][0, ..., cell[0] + 1, cell[1]] = outputs[name][0, ..., cell[0], cell[1]]
    assert len(decode(outputs, K)[0]) == len(before)
