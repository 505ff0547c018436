"""COCO files that pycocotools reads, and that score 1.0 against themselves."""

from __future__ import annotations

import contextlib
import io
import json
from typing import Any

import numpy as np
import pytest
from pycocotools import mask as coco
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from glassware.annotate.masks import decode_mask
from glassware.dataset.exports.detection.category_ids import CATEGORY_IDS, FIRST_OTHER
from glassware.dataset.exports.detection.coco import KINDS
from glassware.dataset.exports.detection.polygons import polygons_of
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset

#: pycocotools 2.0.10 hands NumPy an array of its own that has no `copy`.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept a copy keyword")


def _loaded(out, kind, split="train") -> Any:
    with contextlib.redirect_stdout(io.StringIO()):
        return COCO(str(out / "annotations" / f"{kind}_{split}.json"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_scores_one_against_itself(stored, tmp_path, kind):
    export(stored, "coco", tmp_path / "out")
    truth = _loaded(tmp_path / "out", kind)
    found = [annotation | {"score": 1.0} for annotation in truth.dataset["annotations"]]
    with contextlib.redirect_stdout(io.StringIO()):
        score = COCOeval(truth, truth.loadRes(found), "keypoints" if kind == "keypoints" else "segm")
        if kind == "keypoints":
            score.params.kpt_oks_sigmas = np.array(truth.dataset["categories"][0]["sigmas"])
        score.evaluate()
        score.accumulate()
        score.summarize()
    assert score.stats[0] == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["instances", "amodal"])
def test_the_second_implementation_scores_the_same(stored, tmp_path, kind):
    faster = pytest.importorskip("faster_coco_eval")
    export(stored, "coco", tmp_path / "out")
    path = tmp_path / "out" / "annotations" / f"{kind}_train.json"
    truth = faster.COCO(json.loads(path.read_text()))
    found = [annotation | {"score": 1.0} for annotation in truth.dataset["annotations"]]
    score = faster.COCOeval_faster(truth, truth.loadRes(found), "segm")
    score.run()
    assert score.stats[0] == pytest.approx(1.0)


@pytest.mark.parametrize("polygons", [False, True])
def test_masks_are_the_same_to_the_bit(stored, tmp_path, polygons):
    export(stored, "coco", tmp_path / "out", polygons=polygons)
    views = Dataset.open(stored).views()
    for kind, field in (("instances", "mask_seen"), ("amodal", "mask_amodal")):
        truth = _loaded(tmp_path / "out", kind)
        for annotation in truth.dataset["annotations"]:
            labels = views[annotation["image_id"] - 1].labels().objects
            rle = getattr(next(label for label in labels if label.id == annotation["object"]), field)
            mask = decode_mask(rle.counts, rle.size)
            np.testing.assert_array_equal(truth.annToMask(annotation) == 1, mask)
            rows, columns = np.nonzero(mask)
            x, y, width, height = annotation["bbox"]
            assert (x, y) == (columns.min(), rows.min())
            assert (x + width, y + height) == (columns.max() + 1, rows.max() + 1)


def test_polygons_give_any_mask_again():
    rng = np.random.default_rng(5)
    ring = np.zeros((30, 40), bool)
    ring[5:25, 5:30] = True
    ring[10:20, 12:13] = ring[8:11, 20:27] = False
    for mask in (ring, rng.random((30, 40)) < 0.7, rng.random((30, 40)) < 0.3, np.ones((30, 40), bool)):
        outlines: Any = polygons_of(mask)
        codes: Any = coco.frPyObjects(outlines, 30, 40)
        np.testing.assert_array_equal(coco.decode(coco.merge(codes)) == 1, mask)


def test_keypoints_lie_half_a_pixel_further_than_in_our_labels(stored, tmp_path):
    export(stored, "coco", tmp_path / "out")
    truth = _loaded(tmp_path / "out", "keypoints")
    views = Dataset.open(stored).views()
    for annotation in truth.dataset["annotations"]:
        labels = views[annotation["image_id"] - 1].labels().objects
        label = next(label for label in labels if label.id == annotation["object"])
        rows = np.reshape(annotation["keypoints"], (-1, 3))
        for point, (x, y, flag) in zip(label.keypoints, rows, strict=True):
            assert flag == {"outside": 0, "occluded": 1, "through_glass": 2, "visible": 2}[point.state]
            if flag:
                assert (x - 0.5, y - 0.5) == pytest.approx(point.pixel, abs=1e-9)


def test_pictures_are_those_of_the_views_and_props_can_be_left_out(stored, tmp_path):
    export(stored, "coco", tmp_path / "out", vessels_only=True)
    truth = _loaded(tmp_path / "out", "instances")
    assert {category["supercategory"] for category in truth.dataset["categories"]} == {"vessel"}
    for image, view in zip(truth.dataset["images"], Dataset.open(stored).views(), strict=True):
        path = tmp_path / "out" / "images" / image["file_name"]
        assert path.read_bytes() == (view.folder / "left.png").read_bytes()
        assert path.stat().st_ino == (view.folder / "left.png").stat().st_ino


def test_scenes_go_to_the_files_of_their_splits(stored, tmp_path):
    splits = {"train": [], "val": [], "test": [0], "unseen_families": [], "unseen_assets": {}}
    (stored / "splits.json").write_text(json.dumps(splits | {"schema_version": "glassware/splits/1"}))
    export(stored, "coco", tmp_path / "out")
    names = sorted(path.name for path in (tmp_path / "out" / "annotations").iterdir())
    assert names == ["amodal_test.json", "instances_test.json", "keypoints_test.json"]


def test_categories_have_the_ids_of_every_data_set(stored, tmp_path):
    export(stored, "coco", tmp_path / "out")
    categories = _loaded(tmp_path / "out", "instances").dataset["categories"]
    assert [(category["id"], category["name"]) for category in categories] == [
        (CATEGORY_IDS["tumbler"], "tumbler"),
        (CATEGORY_IDS["box"], "box"),
        (FIRST_OTHER, "sphere"),
    ]
