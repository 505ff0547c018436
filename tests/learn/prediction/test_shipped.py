"""The weights that come with glassware, their model card, and the pair to try them on."""

from __future__ import annotations

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from glassware.annotate.labels import Labels
from glassware.annotate.masks import decode_mask
from glassware.core.json_file import parsed, read_json
from glassware.dataset.commands.glassware import main
from glassware.learn.prediction.own_pictures import read_picture
from glassware.learn.prediction.predict import sample_pair
from glassware.learn.prediction.rigs import RigOptions, with_rig
from glassware.learn.training.weights import SHIPPED, WeightsHeader, read_shipped, shipped_weights

DOCS = Path(__file__).resolve().parents[3] / "docs"
#: Most bytes of one file of weights in the package.
MOST_BYTES = 20_000_000
#: Most bytes of the pair.
MOST_SAMPLE = 500_000

needs_weights = pytest.mark.skipif(not shipped_weights(), reason="this checkout has no weights in learn/weights")
needs_sample = pytest.mark.skipif(not sample_pair()[0].is_file(), reason="this checkout has no pair in learn/sample")
card = runpy.run_path(str(DOCS / "model_card.py"))


@needs_weights
@pytest.mark.parametrize("name", list(shipped_weights()))
def test_weights_are_small_whole_and_have_a_record(name):
    path = shipped_weights()[name]
    assert path.stat().st_size <= MOST_BYTES
    header, weights = read_shipped(path)
    assert header.name == name
    assert all(bool(np.isfinite(value.numpy()).all()) for value in weights.values())
    record = json.loads((SHIPPED / f"{name}.json").read_text())
    # Settings that were added since have the values that the network was trained with: their defaults.
    assert WeightsHeader.model_validate(record["weights"], strict=False) == header
    assert record["bytes"] == path.stat().st_size
    assert record["parameters"] == sum(value.numel() for value in weights.values())


@needs_weights
@pytest.mark.parametrize("name", list(shipped_weights()))
def test_the_model_card_on_the_page_is_that_of_the_weights(name):
    text = card["PAGES"][name].read_text("utf-8")
    assert card["with_card"](text, card["record"](name)) == text, "out of date: run .venv/bin/python docs/model_card.py"


def test_a_card_has_the_figures_of_its_reports():
    errors = {"mae": 0.0123, "rmse": 0.05, "rel": 0.02, "delta_105": 0.75, "delta_110": 0.9, "delta_125": 1.0}
    report = {
        "samples": 12,
        "depth": {"full": {"transparent": errors, "opaque": None}},
        "floors": {"full": {"transparent": {"constant": errors | {"mae": 0.088}}, "opaque": None}},
        "boxes": {"ap25": 0.5, "ap50": 0.25},
        "masks": {"ap50": 0.6, "iou_all": None},
        "pose": {"found": 0.75, "translation": 0.02, "translation_median": 0.015, "auc": 0.4},
    }
    network = {
        "context": "resnet18",
        "matching": "group",
        "planes": 24,
        "spacing": "inverse",
        "depth_range": [0.3, 1.2],
        "objects_at": "half",
    }
    frames = {"bottle_0/1": {"found": 2, "mask_iou": 0.61, "centre_error": 0.0284}}
    weights = {"network": network, "views": {"size": [128, 160]}, "focal": 153.5, "baseline": 0.12, "step": 9}
    record = {
        "name": "base", "parameters": 7_600_000, "bytes": 15_500_000, "weights": weights, "settings": {"batch": 4},
        "notes": {"machine": "two cores"},
        "reports": {"unseen scenes": report, "real pairs": {"ways": {"whole": frames}}},
    }  # fmt: skip
    begin, end = card["BEGIN"], card["END"]
    page = card["with_card"](f"before\n{begin}old\n{end}after\n", record)
    assert page.startswith(f"before\n{begin}")
    assert page.endswith(f"{end}after\n")
    assert "old" not in page
    for line in (
        "`base`: 7.6 million parameters, 15.5 MB.",
        "| machine | two cores |",
        "| size of pictures | 160 x 128 px; objects are found at half of it |",
        "On `unseen scenes`, 12 samples (depth at full size):",
        "| whole | bottle_0/1 | 2 | 0.61 | 28 | - | - |",
        "| transparent | 12 | 50 | 0.020 | 0.750 | 88 |",
        "| opaque | - | - | - | - | - |",
        "| mask IoU of all objects | - |",
        "| translation error of found objects, median | 15 mm |",
    ):
        assert line in page.splitlines(), line
    assert card["with_card"](page, record) == page


@needs_sample
def test_the_pair_is_small_and_its_camera_and_labels_belong_to_it():
    left, right = sample_pair()
    assert sum(path.stat().st_size for path in left.parent.iterdir()) <= MOST_SAMPLE
    own = with_rig([read_picture(left), read_picture(right)], RigOptions(str(left.with_name("camera.json"))))
    assert own[1].world_T_camera[0, 3] > 0.0
    labels = parsed(Labels, read_json(left.with_name("labels.json")), left)
    assert labels.objects


@needs_weights
@needs_sample
def test_the_first_command_of_a_new_user_finds_glasses_of_the_pair_where_they_are(tmp_path, capsys):
    """Most of the best object's mask lies on objects that are there, and its middle near one of theirs."""
    assert main(["predict", "base", "--sample", "--device", "cpu", "--threads", "1", "--out", str(tmp_path)]) == 0
    assert "objects; written to" in capsys.readouterr().out
    found = json.loads((tmp_path / "prediction.json").read_text())["objects"]
    labels = parsed(Labels, read_json(sample_pair()[0].with_name("labels.json")), tmp_path)
    height, width = found[0]["mask"]["size"]
    truth = np.zeros((height, width), bool)
    for item in labels.objects:
        truth |= decode_mask(item.mask_amodal.counts, (height, width))
    mask = decode_mask(found[0]["mask"]["counts"], (height, width))
    assert (mask & truth).sum() > 0.5 * mask.sum()
