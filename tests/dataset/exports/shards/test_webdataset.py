"""Shards and the card, read as WebDataset and the Hub define them: key, first dot, ending; types from the card."""

from __future__ import annotations

import hashlib
import json
import tarfile
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from glassware.annotate.masks import decode_mask
from glassware.core.errors import InputError
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset

#: Python types of the names that the card uses.
TYPES = {"int64": int, "float64": float, "string": str, "bool": bool}


@pytest.fixture
def out(stored, tmp_path):
    export(stored, "webdataset", tmp_path / "out", eye="both")
    return tmp_path / "out"


def test_the_card_says_that_light_is_simplified(stored, tmp_path):
    export(stored, "webdataset", tmp_path / "usual")
    assert "Of the pictures" not in (tmp_path / "usual" / "README.md").read_text()
    (scene,) = (stored / "scenes").glob("*/scene.json")
    data = json.loads(scene.read_text())
    data["picture"] = {"glass_shadows": False}
    scene.write_text(json.dumps(data))
    export(stored, "webdataset", tmp_path / "out")
    note = "Of the pictures: simplified light: picture.glass_shadows no (true: yes)."
    assert note in (tmp_path / "out" / "README.md").read_text().splitlines()


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


def test_all_configurations_have_the_same_keys(out):
    keys = [list(_samples(out / name / "train-000000.tar")) for name in ("pictures", "geometry", "labels")]
    assert keys == [["000000_000", "000000_001"]] * 3


def test_depth_and_polarisation_cameras_have_shards_of_their_own(copy, add_sensors, tmp_path):
    export(add_sensors(copy), "webdataset", tmp_path / "out")
    (view,) = Dataset.open(copy).views()
    kinds = {one["config_name"]: one["features"] for one in _card(tmp_path / "out")["dataset_info"]}
    assert list(kinds) == ["pictures", "geometry", "sensor", "polarisation", "labels"]
    for config, record in (("sensor", view.depth_camera()), ("polarisation", view.polarisation_camera())):
        (shard,) = (tmp_path / "out" / config).iterdir()
        (members,) = _samples(shard).values()
        assert record is not None
        described = {one["name"]: one for one in kinds[config]}
        assert set(members) == {name for name in described if not name.startswith("__")}
        stored = json.loads(members.pop(f"{config}.json"))
        _check(stored, described[f"{config}.json"])
        assert stored == record.model_dump(mode="json") | {n: v for n, v in stored.items() if v is None}
        for name, content in members.items():
            assert content == (view.folder / name).read_bytes(), name
    assert "`sensor_depth.png` is what a depth camera reports" in (tmp_path / "out" / "README.md").read_text()
    members = {
        one["includes"] for one in json.loads((tmp_path / "out" / "croissant.json").read_text())["distribution"][5:]
    }
    assert {"*.ir_left.png", "*.stokes.exr", "*.sensor.json", "*.polarisation_mosaic.png"} <= members


def test_labels_of_a_camera_that_the_data_set_has_not_are_refused_and_nothing_is_written(stored, tmp_path):
    with pytest.raises(InputError, match=r"--labels: expected .* sensor needs --sensors\.depth d435, found sensor"):
        export(stored, "webdataset", tmp_path / "out", labels=("pictures", "sensor"))
    assert not (tmp_path / "out").exists()


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


def test_digests_are_those_of_the_shards(out):
    lines = [line.split("  ") for line in (out / "SHA256SUMS").read_text().splitlines()]
    assert sorted(name for _, name in lines) == sorted(str(path.relative_to(out)) for path in out.rglob("*.tar"))
    for digest, name in lines:
        assert hashlib.sha256((out / name).read_bytes()).hexdigest() == digest


def test_the_licence_and_those_of_assets_are_in_the_card_and_in_croissant(stored, tmp_path):
    head = json.loads((stored / "dataset.json").read_text())
    asset = {"path": "assets/a.hdr", "sha256": "0" * 64, "source": "a.hdr", "licence": "CC0-1.0"}
    (stored / "dataset.json").write_text(json.dumps(head | {"assets": [asset]}))
    export(stored, "webdataset", tmp_path / "out", licence="cc-by-4.0")
    text = (tmp_path / "out" / "README.md").read_text()
    assert _card(tmp_path / "out")["license"] == "cc-by-4.0"
    assert "| `a.hdr` | CC0-1.0 | `0000000000000000` |" in text
    record = json.loads((tmp_path / "out" / "croissant.json").read_text())
    assert record["license"] == "cc-by-4.0"
    assert [(item["name"], item["license"]) for item in record["isBasedOn"]] == [("a.hdr", "CC0-1.0")]


@pytest.mark.slow  # loading `datasets` takes seconds
def test_datasets_reads_all_configurations_with_fractions_as_fractions(stored, out, tmp_path, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    datasets = pytest.importorskip("datasets")
    views = Dataset.open(stored).views()
    read = {
        name: datasets.load_dataset(str(out), name, split="train", cache_dir=str(tmp_path / "cache"))
        for name in ("pictures", "geometry", "labels")
    }
    assert {name: len(rows) for name, rows in read.items()} == dict.fromkeys(read, len(views))
    for number, view in enumerate(views):
        np.testing.assert_array_equal(np.array(read["pictures"][number]["left.png"]), view.picture())
        camera = read["pictures"][number]["camera.json"]
        np.testing.assert_allclose(camera["world_T_camera"], view.camera().world_T_camera, atol=1e-6)
        ids = np.array(read["geometry"][number]["instances.png"])
        np.testing.assert_array_equal(ids, view.geometry().id)
        for item, label in zip(read["labels"][number]["labels.json"]["objects"], view.labels().objects, strict=True):
            assert item["visible_fraction"] == (label.fractions and label.fractions.visible)
            np.testing.assert_array_equal(
                decode_mask(item["mask_seen"], tuple(item["mask_size"])),
                decode_mask(label.mask_seen.counts, label.mask_seen.size),
            )


@pytest.mark.slow  # loading `mlcroissant` takes seconds
@pytest.mark.filterwarnings("ignore")  # of libraries that it uses
def test_mlcroissant_finds_no_error_and_reads_every_record(stored, out, tmp_path, monkeypatch):
    mlcroissant = pytest.importorskip("mlcroissant")
    from etils import epath  # pyright: ignore[reportMissingImports]

    # Its cache knows shards by their names alone: those of another export would be read.
    extract = "mlcroissant._src.operation_graph.operations.extract.EXTRACT_PATH"
    monkeypatch.setattr(extract, epath.Path(tmp_path / "cache"))
    described = mlcroissant.Dataset(jsonld=str(out / "croissant.json"))
    assert not described.metadata.issues.errors
    views = Dataset.open(stored).views()
    sets = [item.id for item in described.metadata.record_sets]
    assert len(sets) == 7
    rows = {name: list(described.records(name)) for name in sets}
    assert {name: len(found) for name, found in rows.items()} == dict.fromkeys(sets, len(views))
    for number, view in enumerate(views):
        row = rows["pictures-left-png-records"][number]
        assert row["pictures-left-png-records/key"] == f"000000_{view.number:03d}".encode()
        np.testing.assert_array_equal(np.array(row["pictures-left-png-records/content"]), view.picture())
        camera = json.loads(rows["pictures-camera-json-records"][number]["pictures-camera-json-records/content"])
        np.testing.assert_allclose(camera["K"], view.camera().K, atol=1e-6)
