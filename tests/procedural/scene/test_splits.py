"""Splits follow from the seed; test scenes alone show what is kept for them."""

from __future__ import annotations

import math

import pytest

from glassware.core.errors import InputError
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.splits import SplitSettings, families_of, files_of, split_of
from glassware.procedural.vessels.settings import CATEGORIES

SCENES = 2000


def test_shares_are_those_asked_for_and_a_scene_keeps_its_split():
    settings = SplitSettings(val=0.2, test=0.1)
    splits = [split_of(settings, 5, scene) for scene in range(SCENES)]
    for name, share in (("val", 0.2), ("test", 0.1)):
        # Four standard deviations of a binomial count.
        assert abs(splits.count(name) - share * SCENES) < 4.0 * math.sqrt(SCENES * share * (1.0 - share))
    assert [split_of(settings, 5, scene) for scene in reversed(range(SCENES))] == splits[::-1]
    assert [split_of(settings, 6, scene) for scene in range(SCENES)] != splits


@pytest.mark.parametrize(("val", "test", "only"), [(0.0, 0.0, "train"), (1.0, 0.0, "val"), (0.0, 1.0, "test")])
def test_whole_shares_leave_no_others(val, test, only):
    settings = SplitSettings(val=val, test=test)
    assert {split_of(settings, 1, scene) for scene in range(50)} == {only}


def test_shares_beyond_the_whole_are_refused():
    with pytest.raises(ValueError, match="at most 1 together with val"):
        SplitSettings(val=0.6, test=0.5)


@pytest.mark.parametrize("seed", range(5))
def test_unseen_families_are_those_of_test_scenes_alone(seed):
    settings = SplitSettings(unseen_families=3)
    seen, unseen = (families_of(settings, seed, split, CATEGORIES) for split in ("train", "test"))
    assert len(unseen) == 3
    assert set(seen) | set(unseen) == set(CATEGORIES)
    assert not set(seen) & set(unseen)
    assert families_of(settings, seed, "val", CATEGORIES) == seen


def test_another_seed_keeps_other_families():
    settings = SplitSettings(unseen_families=3)
    assert len({families_of(settings, seed, "test", CATEGORIES) for seed in range(20)}) > 5


def test_more_unseen_families_than_there_are_is_refused():
    with pytest.raises(InputError, match=r"splits\.unseen_families: expected fewer than the 2 families, found 2"):
        families_of(SplitSettings(unseen_families=2), 1, "train", CATEGORIES[:2])


@pytest.mark.parametrize(("count", "share", "held"), [(10, 0.3, 3), (2, 0.01, 1), (3, 0.99, 2)])
def test_unseen_files_are_a_share_and_never_none_or_all(count, share, held):
    files = [f"{i}.png" for i in range(count)]
    settings = SplitSettings(unseen_assets=share)
    seen, unseen = (files_of(settings, 7, split, files, str) for split in ("val", "test"))
    assert len(unseen) == held
    assert sorted([*seen, *unseen]) == files


def test_a_single_file_cannot_be_both():
    with pytest.raises(InputError, match=r"folders of two files or more, found one with a\.png alone"):
        files_of(SplitSettings(unseen_assets=0.5), 1, "train", ["a.png"], str)


@pytest.mark.slow
def test_scenes_show_only_the_families_of_their_split():
    settings = SceneSettings(
        vessel_count=(2, 2), prop_count=(0, 0), splits=SplitSettings(val=0.0, test=0.5, unseen_families=2)
    )
    unseen = set(families_of(settings.splits, 2, "test", CATEGORIES))
    shown: dict[str, set[str]] = {"train": set(), "test": set()}
    for scene in range(4):
        drawn = draw_scene(settings, 2, scene)
        shown[split_of(settings.splits, 2, scene)] |= {vessel.category for vessel in drawn.vessels}
    assert shown["test"]
    assert shown["test"] <= unseen
    assert shown["train"]
    assert not shown["train"] & unseen


@pytest.mark.slow
def test_without_unseen_ones_a_scene_is_drawn_as_if_there_were_no_splits():
    plain, split = SceneSettings(), SceneSettings(splits=SplitSettings(val=0.0, test=1.0))
    assert draw_scene(plain, 4, 1).model_dump_json() == draw_scene(split, 4, 1).model_dump_json()
