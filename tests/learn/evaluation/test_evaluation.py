from __future__ import annotations

import json

import numpy as np
import pytest
import torch

from glassware.annotate.symmetries import REVOLUTION
from glassware.core.errors import InputError
from glassware.dataset.reader import Dataset
from glassware.learn import NetworkSettings, build_network
from glassware.learn.data.samples import SampleDataset, collate
from glassware.learn.data.settings import ViewSettings
from glassware.learn.decoding.decode import decode
from glassware.learn.evaluation.report import fill_class, pose_metrics, summarise, tables, thickness_class
from glassware.learn.evaluation.run import overlap_of, score_all
from glassware.learn.evaluation.score import ObjectScore, score_sample
from glassware.learn.metrics.pose import PoseErrors
from glassware.learn.targets.encoding import CORRECTED
from glassware.learn.targets.objects import ViewObject
from glassware.learn.targets.view import OPAQUE, detectable


@pytest.fixture(scope="module")
def samples(rendered) -> SampleDataset:
    return SampleDataset(rendered, "all", ViewSettings(), CORRECTED, ground_truth=True)


def perfect(sample) -> dict[str, torch.Tensor]:
    """What a network without a fault would give."""
    targets = sample.targets
    names = ("heatmap", "vertex", "z_centroid", "covariance", "offset", "depth")
    outputs = {name: targets[name][None] for name in names}
    classes = torch.nn.functional.one_hot(targets["seg"], OPAQUE + 1).movedim(-1, 0)
    return outputs | {"seg": 9.0 * classes[None].float()}


@pytest.fixture(scope="module")
def scores(samples) -> list:
    rows = [samples[(index, 0)] for index in range(len(samples))]
    return [score_sample(s.name, perfect(s), s.K[0], s.ground_truth, CORRECTED) for s in rows]


def test_perfect_outputs_have_perfect_summarise(scores, samples):
    found = summarise(scores)
    assert found["samples"] == 10
    for size in ("full", "cleargrasp"):
        for kind in ("transparent", "opaque", "objects", "all"):
            errors = found["depth"][size][kind]
            assert (errors["rmse"], errors["mae"], errors["rel"]) == (0.0, 0.0, 0.0)
            assert (errors["delta_105"], errors["delta_110"], errors["delta_125"]) == (1.0, 1.0, 1.0)
    assert found["boxes"]["ap25"] == found["boxes"]["ap75"] == 1.0
    # Fields are float32 (see the test of decoding).
    assert found["boxes"]["iou_all"] == pytest.approx(1.0, abs=1e-3)
    assert found["masks"]["ap"] == pytest.approx(1.0)
    wanted = sum(len(detectable(s.ground_truth.objects)) for s in (samples[(i, 0)] for i in range(10)))
    pose = found["pose"]
    assert (pose["objects"], pose["found"], pose["near"]) == (wanted, 1.0, 1.0)
    assert pose["auc"] > 0.999
    for group in ("by_category", "by_content", "by_thickness"):
        assert sum(row["objects"] for row in found[group].values()) == wanted
    for size in ("full", "cleargrasp"):
        for kind in ("transparent", "all"):
            floors = found["floors"][size][kind]
            assert 0.0 < floors["picture_median"]["mae"] <= floors["constant"]["mae"] + 1e-3  # bins of 1 mm
    json.dumps(found, allow_nan=False)


def test_a_network_that_sees_nothing_misses_everything(samples):
    sample = samples[(0, 0)]
    blind = perfect(sample) | {"heatmap": torch.zeros(1, 96, 128)}
    found = summarise([score_sample(sample.name, blind, sample.K[0], sample.ground_truth, CORRECTED)])
    assert found["boxes"] == {"ap25": 0.0, "ap50": 0.0, "ap75": 0.0, "iou_found": None, "iou_all": 0.0}
    assert (found["pose"]["found"], found["pose"]["auc"], found["pose"]["mae"]) == (0.0, 0.0, None)
    assert found["masks"]["ap"] == 0.0


def test_damaged_weights_are_one_clear_line(samples, tiny):
    net = build_network(tiny)
    torch.nn.init.constant_(net.get_parameter("vertex_head.predictor.bias"), float("nan"))
    with pytest.raises(InputError, match=r"scenes/000000/000: vertex: expected finite numbers from the network"):
        score_all(net, samples, NetworkSettings(), lambda _line: None)


def test_depth_errors_are_over_the_pixels_of_their_kind(samples):
    sample = samples[(0, 0)]
    wrong = perfect(sample)
    wrong["depth"] = wrong["depth"] + 0.03 * (sample.targets["seg"] == OPAQUE)[None]
    score = score_sample(sample.name, wrong, sample.K[0], sample.ground_truth, CORRECTED)
    transparent, opaque = score.full["transparent"], score.full["opaque"]
    assert transparent is not None
    assert opaque is not None
    assert transparent.mae == 0.0
    assert opaque.mae == pytest.approx(0.03, rel=1e-4)
    solid = [item for item in score.objects if not item.label.transparent]
    assert solid
    assert all(item.depth_mae == pytest.approx(0.03, rel=1e-4) for item in solid)


def test_what_no_other_view_has_in_its_picture_is_counted_apart(rendered):
    """Of a pair, what is less than its disparity from the left edge; depth is 5 cm off there and right elsewhere."""
    pairs = ViewSettings(count=2, rule="stereo")
    sample = SampleDataset(rendered, "all", pairs, CORRECTED, ground_truth=True)[(0, 0)]
    batch, labels = collate([sample]), sample.ground_truth
    assert labels is not None
    Z = labels.Z
    baseline = float(np.linalg.inv(batch.world_T_camera[0, 0].double())[0] @ batch.world_T_camera[0, 1, :, 3].double())
    known = (Z > 0.0) & np.isfinite(Z)
    disparity = float(sample.K[0][0, 0]) * baseline / np.where(known, Z, 1.0)
    outside = known & (np.arange(Z.shape[1]) - disparity < -0.5)
    overlap = overlap_of(batch, Z)
    assert outside.any()
    assert overlap is not None
    assert np.array_equal(outside, known & ~overlap)
    wrong = perfect(sample)
    wrong["depth"] = wrong["depth"] + 0.05 * torch.from_numpy(outside)[None]
    found = summarise([score_sample(sample.name, wrong, sample.K[0], labels, CORRECTED, None, overlap)])
    depth = found["depth"]
    assert depth["overlap"]["all"]["mae"] == 0.0
    assert depth["outside"]["all"]["mae"] == pytest.approx(0.05, rel=1e-4)
    assert depth["full"]["all"]["mae"] == pytest.approx(0.05 * outside.sum() / known.sum(), rel=1e-4)
    assert {"full", "cleargrasp", "overlap", "outside"} == set(tables(found)[1].columns[0].cells)


def test_missed_objects_count_in_the_area_and_not_in_the_means():
    def score(pose) -> ObjectScore:
        label = ViewObject(2, "can", False, REVOLUTION, None, np.eye(4), np.ones(3), 99)
        return ObjectScore(label, 0.5, pose, 8, None)

    pose = PoseErrors(translation=0.01, rotation=np.pi / 6, add=0.02, add_s=0.01, points=(0.05,) * 8)
    found = pose_metrics([score(pose), score(None)])
    assert found["found"] == 0.5
    assert found["auc"] == pytest.approx(0.25)
    assert found["near"] == 0.0
    assert found["mae"] == pytest.approx(0.05)
    assert found["rotation"] == pytest.approx(30.0)
    assert [fill_class(score(pose))] == ["solid"]


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        ((0.2, 0.03, 0.003), "below 10 mm"),
        ((0.0101, 0.2, 0.15), "10 to 30 mm"),
        ((0.0299, 0.0299, 0.3), "10 to 30 mm"),
        ((0.03, 0.08, 0.08), "30 mm and more"),
    ],
)
def test_objects_are_counted_by_the_least_side_of_their_box(sides, expected):
    label = ViewObject(2, "fork", False, REVOLUTION, None, np.eye(4), np.array(sides), 99)
    assert thickness_class(ObjectScore(label, 0.0, None, 8, None)) == expected


@pytest.mark.parametrize("changes", [{}, {"matching": "group", "readout": "windowed", "fusion": "visibility"}])
def test_evaluation_changes_no_weight_and_no_statistic(samples, tiny, changes):
    net = build_network(NetworkSettings(**(tiny.model_dump() | changes)))
    net.train()
    before = {name: value.clone() for name, value in net.state_dict().items()}
    threads = torch.get_num_threads()
    scores, worst = score_all(net, samples, NetworkSettings(), lambda _line: None, worst=2)
    assert len(scores) == 10
    assert len(worst) == 2
    assert before.keys() == net.state_dict().keys()
    for name, value in net.state_dict().items():
        assert torch.equal(value, before[name]), name
    assert not net.training
    assert all(parameter.grad is None and not parameter.requires_grad for parameter in net.parameters())
    assert torch.get_num_threads() == threads


def test_the_worst_samples_have_the_greatest_errors_of_depth(samples, tiny):
    scores, worst = score_all(build_network(tiny), samples, NetworkSettings(), lambda _line: None, worst=3)
    errors = sorted((_error_of_objects(score) for score in scores), reverse=True)
    assert [_error_of_objects(case.score) for case in worst] == errors[:3]
    assert worst[0].picture.shape == (2 * 96, 4 * 128, 3)


def test_a_batch_of_several_gives_each_its_own_boxes(samples):
    """Decoding takes each sample's own K: the same objects alone and side by side."""
    rows = [samples[(index, 0)] for index in (0, 6)]
    batch = collate(rows)
    outputs = {name: torch.cat([perfect(row)[name] for row in rows]) for name in perfect(rows[0])}
    together = decode(outputs, batch.K[:, 0].double())
    for row, found in zip(rows, together, strict=True):
        (alone,) = decode(perfect(row), row.K[:1].double())
        torch.testing.assert_close(found.camera_T_object, alone.camera_T_object)


def test_fills_are_those_of_the_objects(rendered, samples):
    vessels = [
        o for scene in Dataset.open(rendered).scenes for o in scene.objects().objects if o.material.kind == "glass"
    ]
    fills = {record.liquid.fill if record.liquid else None for record in vessels}
    labels = [o for i in range(10) for o in samples[(i, 0)].ground_truth.objects]
    assert {item.fill for item in labels if item.transparent} == fills


def _error_of_objects(score) -> float:
    errors = score.full["objects"]
    assert errors is not None
    return errors.mae
