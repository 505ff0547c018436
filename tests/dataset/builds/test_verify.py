"""Each kind of damage is found from the files alone, named, and ends with exit code 1."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from glassware.dataset.commands.verify import main
from glassware.dataset.format.checksums import write_checksums


@pytest.fixture
def data(undisturbed, tmp_path) -> Path:
    """A copy of the data set."""
    return shutil.copytree(undisturbed, tmp_path / "data")


def _edited(path: Path, **fields: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | fields))


def _resealed(path: Path, **fields: object) -> None:
    """Change a file of scene 2 and give it the right checksum: only its content can tell."""
    _edited(path, **fields)
    folder = path.parents[len(path.parts) - path.parts.index("000002") - 2]
    (folder / "checksums.json").unlink()
    write_checksums(folder)


def _flip(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1] + bytes([path.read_bytes()[-1] ^ 1]))


def _shorter_index(root: Path) -> None:
    table = pq.read_table(root / "views.parquet")
    pq.write_table(table.slice(0, 5), root / "views.parquet")


def _other_index(root: Path) -> None:
    rows = pq.read_table(root / "views.parquet")
    changed = [row | {"spp_left": 7} if row["scene_id"] == 3 else row for row in rows.to_pylist()]
    pq.write_table(type(rows).from_pylist(changed, schema=rows.schema), root / "views.parquet")


DAMAGES = {
    "a flipped bit": (lambda r: _flip(r / "scenes/000002/000/left.exr"), "000002/000/left.exr: expected SHA-256"),
    "a short file": (lambda r: (r / "scenes/000001/objects.json").write_text("{"), "objects.json: expected "),
    "a missing file": (
        lambda r: (r / "scenes/000001/000/right.png").unlink(),
        "right.png: expected a file, found none",
    ),
    "a file too many": (lambda r: (r / "scenes/000004/x").write_text(""), "000004/x: expected only files"),
    "no checksums": (lambda r: (r / "scenes/000000/checksums.json").unlink(), "checksums.json: expected a readable"),
    "a missing scene": (lambda r: shutil.rmtree(r / "scenes/000005"), "expected scenes 0:6, found 5 missing"),
    "a missing index": (lambda r: (r / "views.parquet").unlink(), "views.parquet: expected an index of all views"),
    "no index": (lambda r: (r / "views.parquet").write_bytes(b"PAR1"), "views.parquet: expected an index of all"),
    "an index that lacks a view": (_shorter_index, "expected view 0 of scene 5 with its values, found no more views"),
    "an index of other values": (_other_index, "views.parquet: expected view 0 of scene 3"),
    "another seed": (lambda r: _edited(r / "dataset.json", seed=4), "expected scene 0 of seed 4, found 0 of 3"),
    "other settings": (lambda r: _edited(r / "dataset.json", config={}), "expected the config of the stored hash"),
    "other versions": (lambda r: _edited(r / "dataset.json", versions={}), "expected the backend of the stored hash"),
    "a damaged head": (lambda r: (r / "dataset.json").write_text("{"), "dataset.json: expected a JSON file"),
    "another manifest": (lambda r: _edited(r / "manifest.json", files=[]), "manifest.json: expected the manifest"),
    "no splits": (lambda r: (r / "splits.json").unlink(), "splits.json: expected a readable file"),
    "other splits": (lambda r: _edited(r / "splits.json", train=[], val=[], test=[]), "found it in none"),
    "an unknown schema": (
        lambda r: _resealed(r / "scenes/000002/000/camera.json", schema_version="glassware/camera/9"),
        "camera.json: schema_version: expected glassware/camera/1",
    ),
    "another camera": (
        lambda r: _resealed(r / "scenes/000002/000/camera.json", baseline=0.5),
        "camera.json: expected camera 0 of scene.json",
    ),
    "labels that lack": (
        lambda r: _resealed(r / "scenes/000002/000/labels.json", objects=[]),
        "labels.json: expected labels of all objects",
    ),
}


@pytest.mark.parametrize(("damage", "says"), DAMAGES.values(), ids=DAMAGES)
def test_damage_is_named(data, capsys, damage, says):
    damage(data)
    assert main([str(data)]) == 1
    told = capsys.readouterr()
    assert says in told.out + told.err


def test_an_asset_that_was_changed_is_named(data, capsys):
    _flip(next((data / "assets").iterdir()))
    assert main([str(data)]) == 1
    assert "expected the file with SHA-256" in capsys.readouterr().out


def test_views_made_again_are_the_stored_ones_and_others_are_named(backend, data, capsys):
    assert main([str(data), "--rerender", "3", "--draw", "1"]) == 0
    assert "3 views rendered again bit for bit" in capsys.readouterr().out
    for scene in (data / "scenes").iterdir():
        _flip(scene / "000" / "left.exr")
        (scene / "checksums.json").unlink()
        write_checksums(scene)
    assert main([str(data), "--rerender", "1"]) == 1
    told = capsys.readouterr()
    assert "left.exr: expected the bytes that are made here and now" in told.out
    assert "1 fault\n" in told.err


def test_a_scene_that_its_seed_does_not_give_is_named(backend, data, capsys):
    shutil.rmtree(data / "scenes/000001")
    for name in ("000000", "000002", "000003", "000004", "000005"):
        (data / "scenes" / name / "meshes" / "vessel-00-outside.ply").exists()
        path = data / "scenes" / name / "scene.json"
        scene = json.loads(path.read_text())
        scene["lights"] = []
        path.write_text(json.dumps(scene))
    assert main([str(data), "--rerender", "1", "--draw", "0"]) == 1
    assert "scene.json: expected the bytes that are made here and now" in capsys.readouterr().out


def test_no_data_set_is_a_wrong_request(tmp_path, capsys):
    assert main([str(tmp_path)]) == 2
    assert "expected the folder of a data set" in capsys.readouterr().err


def test_a_data_set_of_other_versions_is_not_compared_bit_by_bit(data, capsys):
    head = json.loads((data / "dataset.json").read_text())
    _edited(data / "dataset.json", versions=head["versions"] | {"mitsuba": "3.0"})
    assert main([str(data), "--rerender", "1"]) == 2
    assert "versions.mitsuba: expected 3.9.1, which is here" in capsys.readouterr().err
