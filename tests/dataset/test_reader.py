from __future__ import annotations

import json

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.pictures import write_png
from glassware.dataset.reader import Dataset


def _edit(path, change):
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("dataset.json", lambda root: Dataset.open(root)),
        ("scenes/000000/objects.json", lambda root: Dataset.open(root).scene(0).objects()),
        ("scenes/000000/scene.json", lambda root: Dataset.open(root).scene(0).scene()),
        ("scenes/000000/000/camera.json", lambda root: Dataset.open(root).scene(0).views[0].camera()),
        ("scenes/000000/000/labels.json", lambda root: Dataset.open(root).scene(0).views[0].labels()),
    ],
)
def test_a_file_of_an_unknown_schema_damaged_or_missing_is_one_clear_line(stored, name, read):
    path = stored / name
    _edit(path, lambda data: data.update(schema_version="glassware/thing/9"))
    with pytest.raises(InputError, match=r"schema_version: expected glassware/.*/1, found glassware/thing/9"):
        read(stored)
    path.write_text(path.read_text()[:100])
    with pytest.raises(InputError, match="expected a JSON file"):
        read(stored)
    path.unlink()
    with pytest.raises(InputError, match="expected a readable file"):
        read(stored)


def test_a_label_file_with_a_wrong_field_names_it(stored):
    path = stored / "scenes" / "000000" / "000" / "labels.json"
    _edit(path, lambda data: data["objects"][1]["pixels"].update(visible=-1))
    with pytest.raises(InputError, match=r"objects\.1\.pixels\.visible"):
        Dataset.open(stored).scene(0).views[0].labels()


@pytest.mark.parametrize("change", [{"counts": "1"}, {"size": [10, 10]}])
def test_a_damaged_mask_is_one_clear_line(stored, change):
    path = stored / "scenes" / "000000" / "000" / "labels.json"
    _edit(path, lambda data: data["objects"][2]["mask_seen"].update(change))
    with pytest.raises(InputError, match="object 4 mask_seen"):
        Dataset.open(stored).scene(0).views[0].geometry()


def test_ids_of_another_size_are_one_clear_line(stored):
    view = Dataset.open(stored).scene(0).views[0]
    write_png(view.folder / "instances.png", np.zeros((4, 4), np.uint16))
    with pytest.raises(InputError, match=r"instances\.png"):
        view.geometry()


def test_a_folder_or_scene_that_is_not_there_is_one_clear_line(stored, tmp_path):
    with pytest.raises(InputError, match="the folder of a data set"):
        Dataset.open(tmp_path / "none")
    with pytest.raises(InputError, match=r"dataset\.json"):
        Dataset.open(tmp_path)
    with pytest.raises(InputError, match="a scene 5"):
        Dataset.open(stored).scene(5)


def test_views_are_gone_through_in_order(stored):
    assert [view.number for view in Dataset.open(stored).views()] == [0, 1]
    assert Dataset.open(stored).scene(0).views[0].picture("right").dtype == np.uint8
