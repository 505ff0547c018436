"""Statistics of the comparisons with other renderers."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
STUDIES = BENCH / "studies"

#: Noise of one pass's pixels in the made-up pictures, relative.
NOISE = 0.1


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch):
    """Import a file of bench/ or bench/studies/ by its name, as the commands do."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(BENCH))
    monkeypatch.syspath_prepend(str(STUDIES))
    yield importlib.import_module
    for name in set(sys.modules) - before:
        if str(BENCH) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def passes(rng: np.random.Generator, mean: np.ndarray, block_means) -> list[np.ndarray]:
    return [block_means(mean * (1.0 + NOISE * rng.standard_normal(mean.shape)), 10) for _ in range(8)]


def test_two_noisy_copies_of_one_picture_agree(module, rng: np.random.Generator) -> None:
    agreement = module("agreement")
    mean = rng.uniform(0.1, 1.0, (60, 80, 3))
    found = agreement.compared(*(passes(rng, mean, agreement.block_means) for _ in range(2)), 10)
    assert not found.different.any()
    assert found.z.shape == (6, 8, 3)


def test_one_block_that_is_brighter_is_found_and_no_other(module, rng: np.random.Generator) -> None:
    agreement = module("agreement")
    mean = np.full((60, 80, 3), 0.5)
    brighter = mean.copy()
    # The mean of 8 passes of 100 pixels has a noise of NOISE / sqrt(800) = 0.35 %, so 10 % stands far out.
    brighter[20:30, 40:50] *= 1.1
    found = agreement.compared(*(passes(rng, m, agreement.block_means) for m in (brighter, mean)), 10)
    assert np.argwhere(found.different).tolist() == [[2, 4]]
    assert (found.z[2, 4] > 0.0).all()


def test_time_to_an_error_follows_the_power_law_of_a_curve(module) -> None:
    equal_error = module("equal_error")
    curve = [equal_error.Point(n, 0.5 * n, 1.0 / n, 0.1 / n) for n in (4, 16, 64)]
    assert equal_error.time_to(curve, 0.1 / 32) == (pytest.approx(16.0), True)
    assert equal_error.time_to(curve, 0.1 / 256) == (pytest.approx(128.0), False)
    assert equal_error.rate(curve, pixels=100) == pytest.approx(200.0)


def test_a_point_that_is_slower_and_no_better_does_not_bend_the_curve(module) -> None:
    equal_error = module("equal_error")
    curve = [
        equal_error.Point(4, 2.0, 1.0, 0.1),
        equal_error.Point(8, 9.0, 1.0, 0.1),
        equal_error.Point(16, 8.0, 1.0, 0.025),
    ]
    assert equal_error.time_to(curve, 0.05) == (pytest.approx(4.0), True)


def test_a_reference_goes_on_where_it_stopped(module, tmp_path: Path) -> None:
    references = module("references")
    seeds: list[int] = []

    def one_pass(seed: int) -> np.ndarray:
        seeds.append(seed)
        return np.random.default_rng(seed).normal(1.0, NOISE, (4, 5, 3))

    references.reference(tmp_path / "r.npz", 2 * references.PASS_SPP, one_pass)
    found = references.reference(tmp_path / "r.npz", 16 * references.PASS_SPP, one_pass)
    assert len(set(seeds)) == 16
    assert found.passes == 16
    # Of a variance's estimate from 16 passes over 60 values the spread is sqrt(2 / 15 / 60) = 5 %; four of it.
    assert found.floor == pytest.approx(NOISE**2 / 16 / 1.01, rel=0.2)


def test_relmse_of_a_constant_error_is_its_closed_form(module) -> None:
    references = module("references")
    R = np.full((3, 4, 3), 0.5)
    kept = references.Reference(R, np.zeros_like(R), 2)
    assert references.relmse(R + 0.1, kept) == pytest.approx(0.01 / (0.25 + 0.01))
