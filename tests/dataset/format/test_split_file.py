from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.split_file import merged_splits, read_splits, splits_file, write_splits
from glassware.dataset.reader import Dataset
from glassware.procedural.materials.surface_files import SurfaceFiles
from glassware.procedural.scene.asset_files import AssetFiles
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.splits import SplitSettings, families_of, split_of

SETTINGS = SceneSettings(splits=SplitSettings(val=0.3, test=0.3, unseen_families=2))


def test_each_scene_is_in_its_split_and_unseen_families_are_named():
    record = splits_file(SETTINGS, AssetFiles(), 5, range(40))
    for name in ("train", "val", "test"):
        assert getattr(record, name) == tuple(i for i in range(40) if split_of(SETTINGS.splits, 5, i) == name)
        assert getattr(record, name)
    assert record.unseen_families == families_of(SETTINGS.splits, 5, "test", SETTINGS.vessels.categories)


def test_unseen_families_are_named_without_their_weights():
    vessels = {"categories": {"beaker": 2, "bowl": 1, "vase": 3}}
    weighted = SceneSettings.model_validate({"vessels": vessels, "splits": {"test": 0.3, "unseen_families": 1}})
    (unseen,) = splits_file(weighted, AssetFiles(), 5, range(3)).unseen_families
    assert unseen in vessels["categories"]


def test_unseen_files_are_named_by_folder(tmp_path):
    files = AssetFiles(textures=tuple(SurfaceFiles(tmp_path / "wood" / f"{i}.png", tmp_path, "wood") for i in range(4)))
    settings = SceneSettings(texture_dir=tmp_path, splits=SplitSettings(unseen_assets=0.5))
    unseen = splits_file(settings, files, 5, range(3)).unseen_assets
    assert list(unseen) == ["texture_dir"]
    assert len(unseen["texture_dir"]) == 2
    assert set(unseen["texture_dir"]) < {f"wood/{i}.png" for i in range(4)}


def test_records_of_shards_join_to_that_of_the_whole():
    parts = [splits_file(SETTINGS, AssetFiles(), 5, part) for part in (range(20, 40), range(20))]
    assert merged_splits(*parts) == splits_file(SETTINGS, AssetFiles(), 5, range(40))


def test_a_data_set_gives_the_scenes_of_a_split(stored):
    record = splits_file(SETTINGS, AssetFiles(), 5, range(3)).model_copy(
        update={"train": (0, 9), "val": (), "test": ()}
    )
    write_splits(stored, record)
    assert read_splits(stored) == record
    assert [scene.scene_id for scene in Dataset.open(stored).split("train")] == [0]  # 9 is not made yet
    assert Dataset.open(stored).split("test") == ()
    (stored / "splits.json").unlink()
    with pytest.raises(InputError, match=r"expected a data set that is split, .* found one without splits"):
        Dataset.open(stored).split("train")
