from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from glassware.dataset.report.histograms import MOST_BARS, histogram, number_text
from glassware.dataset.report.quantities import Axis


@pytest.mark.parametrize("axis", get_args(Axis))
@pytest.mark.parametrize("size", [1, 2, 30, 5000])
def test_every_value_is_in_one_bin(rng, axis, size):
    values = {"linear": rng.normal(size=size), "log": rng.lognormal(0.0, 2.0, size)}.get(axis)
    if values is None:
        values = rng.integers(0, 101 if axis == "percent" else 9, size).astype(float)
    found = histogram(values.astype(np.float32).astype(float), axis)
    assert found.counts.sum() == size
    assert (np.diff(found.edges) > 0).all()
    centres = 0.5 * (found.edges[:-1] + found.edges[1:])
    assert len(centres) == len(found.counts) <= MOST_BARS


def test_whole_numbers_have_a_bar_each():
    found = histogram(np.array([1.0, 3.0, 3.0, 7.0]), "whole")
    assert found.counts.tolist() == [0, 1, 0, 2, 0, 0, 0, 1]
    assert found.edges[0] == -0.5


def test_one_value_is_in_the_middle():
    for axis in ("linear", "log"):
        assert histogram(np.full(9, 4.0), axis).counts.tolist() == [0, 0, 9, 0, 0]
    assert histogram(np.zeros(3), "log").counts.tolist() == [0, 0, 3, 0, 0]


def test_numbers_have_four_digits():
    shown = {0.123456: "0.1235", 12345.6: "12,350", 7.0: "7", 0.0: "0", 999.96: "1,000"}
    assert {value: number_text(value) for value in shown} == shown
