from __future__ import annotations

import shutil

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.cameras.presets import CAMERAS
from glassware.dataset.commands.develop import main
from glassware.dataset.format.checksums import faults_of
from glassware.dataset.format.dataset_file import read_head, write_head
from glassware.dataset.format.layout import scene_folder
from glassware.dataset.format.pictures import read_png
from glassware.dataset.reader import Dataset
from glassware.learn.data.views import read_camera


def test_a_developed_data_set_is_whole_and_shares_all_but_its_pictures(stored, tmp_path) -> None:
    out = tmp_path / "phone"
    assert main([str(stored), "--camera", "phone", "--out", str(out), "--seed", "5"]) == 0
    source, developed = Dataset.open(stored), Dataset.open(out)
    record = developed.head.developed
    assert record is not None
    assert (record.camera, record.seed) == (CAMERAS["phone"], 5)
    assert developed.index() == source.index()
    for old, new in zip(source.views(), developed.views(), strict=True):
        assert not np.array_equal(old.picture("right"), new.picture("right"))
        assert (new.folder / "geometry.exr").samefile(old.folder / "geometry.exr")
        assert new.camera().model_dump_json() == old.camera().model_dump_json()
        assert read_camera(new).colour_camera == "phone"
    for scene in developed.scenes:
        assert not list(faults_of(scene.folder))
    first = (developed.views()[0].folder / "left.png").read_bytes()
    assert main([str(stored), "--camera", "phone", "--out", str(out), "--seed", "5"]) == 0  # again: kept
    assert (developed.views()[0].folder / "left.png").read_bytes() == first


def test_the_ideal_camera_gives_the_pictures_that_were_built(stored, tmp_path) -> None:
    assert main([str(stored), "--camera", "ideal", "--out", str(tmp_path / "ideal")]) == 0
    for old in Dataset.open(stored).views():
        new = tmp_path / "ideal" / old.folder.relative_to(stored)
        assert (new / "camera.json").read_bytes() == (old.folder / "camera.json").read_bytes()
        for name in ("left.png", "right.png"):
            step = read_png(new / name).astype(int) - read_png(old.folder / name)
            assert np.abs(step).max() <= 1  # radiance is stored in halves
            assert (step != 0).mean() < 0.03


def test_a_picture_that_keeps_the_lens_distortion_says_so_and_no_network_is_trained_on_it(stored, tmp_path) -> None:
    own = tmp_path / "own.yaml"
    own.write_text("like: phone\ndistortion: {k1: 0.02}\nrectified: false\n")
    assert main([str(stored), "--camera", str(own), "--out", str(tmp_path / "own")]) == 0
    view = Dataset.open(tmp_path / "own").views()[0]
    with pytest.raises(InputError, match="distortion: expected none, to which labels belong"):
        read_camera(view)
    assert view.camera().K.shape == (3, 3)


def _without_radiance(root) -> None:
    write_head(root, read_head(root).model_copy(update={"files": ("layers",)}))


def _without_a_file(root) -> None:
    (scene_folder(root, Dataset.open(root).scenes[0].scene_id) / "001" / "right.exr").unlink()


@pytest.mark.parametrize(
    ("spoil", "options", "line"),
    [
        (_without_radiance, [], "radiance, which render-scene and build-dataset write with --write radiance"),
        (_without_a_file, [], "right.exr: expected a data set with radiance"),
        (shutil.rmtree, [], "expected the folder of a data set, with dataset.json, found none"),
        (None, ["--camera", "phon"], "is it phone?"),
        (None, ["--camera", "fold.yaml"], "fold over inside pictures"),
        (None, ["--out", "data"], "--out: expected another folder"),
    ],
)
def test_what_cannot_be_developed_is_one_line_and_nothing_is_written(
    stored, tmp_path, monkeypatch, capsys, spoil, options, line
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fold.yaml").write_text("distortion: {k1: -20}\n")
    if spoil is not None:
        spoil(stored)
    before = sorted(path.name for path in tmp_path.iterdir())
    out = [] if "--out" in options else ["--out", "new"]
    assert main(["data", *out, *options]) == 2
    printed = capsys.readouterr().err
    assert line in printed
    assert printed.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == before
