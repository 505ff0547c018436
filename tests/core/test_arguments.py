from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.arguments import (
    as_path,
    check_type,
    described,
    number,
    one_of,
    point,
    points,
    several,
    whole_number,
)
from glassware.core.errors import InputError


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("left", "'left'"),
        (None, "None"),
        (2.5, "2.5"),
        ((1, 2), "(1, 2)"),
        (Path("out"), "PosixPath('out')"),
        (np.zeros((3, 2)), "an array of shape (3, 2)"),
        (InputError("a", "b", "c"), "an InputError"),
        (dict, "the class dict"),
    ],
)
def test_a_value_is_described_on_one_line(value, text):
    assert described(value) == text


def test_a_long_value_is_described_by_its_type():
    assert described([["a" * 60] * 5] * 5) == "a list"
    assert len(described("a" * 1000)) < 100


def test_numbers_of_python_and_numpy_are_taken_and_others_refused():
    assert whole_number("seed", np.uint8(3), 0, 9) == 3
    assert type(whole_number("seed", np.int64(3), 0, 9)) is int
    for wrong in (True, 3.0, "3", None, -1, 10):
        with pytest.raises(InputError, match=r"^seed: expected a whole number from 0 to 9, found "):
            whole_number("seed", wrong, 0, 9)
    assert number("amount", np.float32(0.5), 0.0, 1.0) == 0.5
    for wrong in (True, "much", None, float("nan"), 2.0):
        with pytest.raises(InputError, match=r"^amount: expected a number from 0 to 1 kg, found "):
            number("amount", wrong, 0.0, 1.0, "kg")


def test_so_many_values_and_one_of_some_texts_are_taken_and_others_refused():
    for right in ((1, 2), [1, 2], np.array([1, 2])):
        assert several("shift", right, 2, "two") == (1, 2)
    for wrong in (3, None, "ab", (1,), (1, 2, 3), np.array(2), np.zeros((2, 2)), {1, 2}):
        with pytest.raises(InputError, match=r"^shift: expected two, found "):
            several("shift", wrong, 2, "two")
    assert one_of("eye", "left", ("left", "right")) == "left"
    for wrong in ("top", None, ["left"], np.zeros(2)):
        with pytest.raises(InputError, match=r"^eye: expected 'left' or 'right', found "):
            one_of("eye", wrong, ("left", "right"))
    with pytest.raises(InputError, match=r"^split: expected one of train, val, test, found 'all'$"):
        one_of("split", "all", ("train", "val", "test"))


def test_points_are_finite_rows_of_three():
    np.testing.assert_array_equal(point("eye", (1, 2, 3)), [1.0, 2.0, 3.0])
    assert points("points", np.zeros((0, 3))).shape == (0, 3)
    for wrong in ("above", (0, 0), None, [[0, 0, 0]], (True, False, True), (1, 2, "3")):
        with pytest.raises(InputError, match=r"^eye: expected three finite numbers \(x, y, z\) \[m\], found "):
            point("eye", wrong)
    for wrong in ((0.0, float("nan"), 0.0), (0.0, float("inf"), 0.0), (1e9, 0.0, 0.0)):
        with pytest.raises(InputError, match=r"^eye: expected finite numbers of at most 1e\+06 m"):
            point("eye", wrong)
    for wrong in ([0, 0, 0], [[0, 0]], [[0, 0, 0], [0, 0]], None):
        with pytest.raises(InputError, match=r"^points: expected points as an array"):
            points("points", wrong)


def test_types_and_paths_are_checked():
    check_type("x", 3, int, "a number")
    assert as_path("out", "data") == Path("data")
    with pytest.raises(InputError, match=r"^out: expected a path \(text or pathlib.Path\), found None$"):
        as_path("out", None)
