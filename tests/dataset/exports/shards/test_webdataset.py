"""Shards and the card, read as WebDataset and the Hub define them: key, first dot, ending; types from the card."""

from __future__ import annotations

import json
import tarfile
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from glassware.annotate.masks import decode_mask
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset

#: Python types of the names that the card uses.
TYPES = {"int64": int, "float64": float, "string": str, "bool": bool}


@pytest.fixture
def out(stored, tmp_path):
    export(stored, "webdataset", tmp_path / "out", eye="both")
    return tmp_path / "out"


def _card(out) -> dict[str, Any]:
    return yaml.safe_load((out / "README.md").read_text().split("---\n")[1])


def _samples(shard) -> dict[str, dict[str, bytes]]:
    """Members of each sample by their endings; members of a sample follow each other."""
    samples, keys = {}, []
    with tarfile.open(shard) as tar:
        for entry in tar:
            key, ending = entry.name.split(".", 1)
            file = tar.extractfile(entry)
            assert file is not None
            samples.setdefault(key, {})[ending] = file.read()
            keys += [key] if not keys or keys[-1] != key else []
    assert len(keys) == len(set(keys))
    return samples


def _check(value, feature) -> None:
    """Compare a value of a JSON file with its type in the card."""
    if value is None:
        return
    if "struct" in feature:
        assert set(value) == {field["name"] for field in feature["struct"]}
        for field in feature["struct"]:
            _check(value[field["name"]], field)
    elif "list" in feature:
        inner = feature["list"]
        kind = {"dtype": inner} if isinstance(inner, str) else {"struct": inner} if isinstance(inner, list) else inner
        for item in value:
            _check(item, kind)
    else:
        assert type(value) is TYPES[feature["dtype"]]


def test_every_member_has_a_column_of_its_type_in_the_card(out):
    card = _card(out)
    assert [config["config_name"] for config in card["configs"]] == ["pictures", "geometry", "labels"]
    for config, info in zip(card["configs"], card["dataset_info"], strict=True):
        (files,) = config["data_files"]
        features = {feature["name"]: feature for feature in info["features"]}
        (shard,) = sorted(out.glob(files["path"]))
        for members in _samples(shard).values():
            assert {"__key__", "__url__", *members} == set(features)
            for ending, data in members.items():
                if ending.endswith(".json"):
                    _check(json.loads(data), features[ending])


def test_the_three_configurations_have_the_same_keys(out):
    keys = [list(_samples(out / name / "train-000000.tar")) for name in ("pictures", "geometry", "labels")]
    assert keys == [["000000_000", "000000_001"]] * 3


def test_cameras_poses_masks_and_pictures_come_back(stored, out):
    shards = {name: _samples(out / name / "train-000000.tar") for name in ("pictures", "geometry", "labels")}
    for view in Dataset.open(stored).views():
        key, camera, geometry = f"000000_{view.number:03d}", view.camera(), view.geometry()
        pictures, files = shards["pictures"][key], shards["geometry"][key]
        found = json.loads(pictures["camera.json"])
        for name in ("K", "world_T_camera", "world_T_right"):
            np.testing.assert_allclose(found[name], np.array(getattr(camera, name)), atol=1e-6)
        for eye in ("left", "right"):
            assert pictures[f"{eye}.png"] == (view.folder / f"{eye}.png").read_bytes()
        depth: Any = cv2.imdecode(np.frombuffer(files["depth.png"], np.uint8), cv2.IMREAD_UNCHANGED)
        step, hit = json.loads(files["geometry.json"])["depth_step_mm"], np.isfinite(geometry.Z)
        assert np.abs(depth * step - 1000.0 * geometry.Z)[hit].max() <= step / 2 + 1e-3
        assert (depth[~hit] == 0).all()
        ids = cv2.imdecode(np.frombuffer(files["instances.png"], np.uint8), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(ids, geometry.id)
        objects = json.loads(shards["labels"][key]["labels.json"])["objects"]
        for number, (item, label) in enumerate(zip(objects, view.labels().objects, strict=True)):
            np.testing.assert_allclose(item["camera_T_object"], np.array(label.camera_T_object), atol=1e-6)
            whole = decode_mask(item["mask_amodal"], tuple(item["mask_size"]))
            np.testing.assert_array_equal(whole, geometry.crossed[number])


def test_a_shard_has_the_same_bytes_each_time(stored, out, tmp_path):
    export(stored, "webdataset", tmp_path / "again", eye="both")
    for shard in out.rglob("*.tar"):
        assert shard.read_bytes() == (tmp_path / "again" / shard.relative_to(out)).read_bytes()
