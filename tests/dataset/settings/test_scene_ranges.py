from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glassware.core.errors import InputError
from glassware.dataset.settings.scene_ranges import format_scenes, parse_scenes, requested_scenes, shard


def test_a_text_names_scenes_in_its_order_each_once():
    assert parse_scenes("7,3:6,4, 0") == [7, 3, 4, 5, 0]


@given(st.sets(st.integers(0, 999_999), max_size=50))
def test_what_is_written_reads_back(scenes):
    assert parse_scenes(format_scenes(scenes)) == sorted(scenes)


def test_runs_are_written_as_ranges():
    assert format_scenes([0, 1, 2, 5, 7, 8]) == "0:3,5,7:9"


@pytest.mark.parametrize("text", ["a", "3:", ":3", "3:3", "-1", "0:1000001", "1000000", "1,,2", "1;2"])
def test_what_names_no_scenes_is_refused(text):
    with pytest.raises(InputError, match="--scenes: expected"):
        parse_scenes(text)


@given(st.integers(0, 200), st.integers(1, 30))
def test_shards_are_nearly_equal_and_together_the_whole(count, shards):
    scenes = list(range(count))
    parts = [shard(scenes, f"{i}/{shards}") for i in range(1, shards + 1)]
    assert [scene for part in parts for scene in part] == scenes
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "1/0", "a/b"])
def test_a_shard_that_is_none_is_refused(text):
    with pytest.raises(InputError, match="--shard: expected i/n"):
        shard([1], text)


def test_a_count_is_a_range_from_the_first_scene():
    assert requested_scenes("", 20) == requested_scenes("0:20", None) == list(range(20))


@pytest.mark.parametrize(
    ("scenes", "count", "line"),
    [
        (
            "20",
            None,
            "--scenes: expected --count 20 or --scenes 0:20 for 20 scenes, 20:21 for scene 20 alone, found '20'",
        ),
        ("0", None, "--scenes: expected --count 1 for one scene, 0:1 for scene 0 alone, found '0'"),
        ("0:3", 20, "--count: expected it without --scenes, or --scenes without it, found both"),
        ("", None, "--scenes: expected scenes such as 0:2000, or --count 2000, found none"),
    ],
)
def test_a_request_that_may_mean_two_things_is_asked_back(scenes, count, line):
    with pytest.raises(InputError) as error:
        requested_scenes(scenes, count)
    assert str(error.value) == line
