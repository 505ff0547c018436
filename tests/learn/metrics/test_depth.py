from __future__ import annotations

from dataclasses import astuple

import cv2
import numpy as np
import pytest

from glassware.learn.metrics.depth import (
    BIN,
    DepthErrors,
    cleargrasp_errors,
    constant_errors,
    depth_errors,
    depth_histogram,
    mean_errors,
)


def one_by_one(predicted, true, mask) -> DepthErrors:
    """The formulas, pixel by pixel."""
    pairs = [
        (float(p), float(t))
        for p, t, m in zip(predicted.flat, true.flat, mask.flat, strict=True)
        if m and 0 < t < np.inf
    ]
    n = len(pairs)
    deltas = [sum(p > 0 and p / t < bound and t / p < bound for p, t in pairs) / n for bound in (1.05, 1.1, 1.25)]
    return DepthErrors(
        (sum((p - t) ** 2 for p, t in pairs) / n) ** 0.5,
        sum(abs(p - t) for p, t in pairs) / n,
        sum(abs(p - t) / t for p, t in pairs) / n,
        *deltas,
    )


@pytest.fixture
def picture(rng):
    true = rng.uniform(0.3, 1.5, (30, 41)).astype(np.float32)
    predicted = (true * rng.normal(1.0, 0.1, true.shape)).astype(np.float32)
    true[2], true[3], predicted[4] = 0.0, np.inf, -0.1
    return predicted, true, rng.uniform(size=true.shape) < 0.5


def _numbers(errors: DepthErrors | None) -> tuple:
    assert errors is not None
    return astuple(errors)


def test_the_errors_are_those_of_the_formulas(picture):
    assert _numbers(depth_errors(*picture)) == pytest.approx(astuple(one_by_one(*picture)))


def test_cleargrasps_protocol_compares_at_its_size(rng):
    true = rng.uniform(0.3, 1.5, (480, 640)).astype(np.float32)
    predicted, mask = true + rng.normal(0, 0.05, true.shape).astype(np.float32), rng.uniform(size=true.shape) < 0.3
    small = [
        cv2.resize(a.astype(np.float32), (256, 144), interpolation=cv2.INTER_NEAREST) for a in (predicted, true, mask)
    ]
    expected = one_by_one(small[0], small[1], small[2] > 0)
    assert _numbers(cleargrasp_errors(predicted, true, mask)) == pytest.approx(astuple(expected))


def test_pictures_without_a_pixel_do_not_count(picture):
    predicted, true, mask = picture
    assert depth_errors(predicted, true, np.zeros_like(mask)) is None
    assert depth_errors(predicted, np.zeros_like(true), mask) is None
    one, two = DepthErrors(1, 2, 3, 0.1, 0.2, 0.3), DepthErrors(3, 4, 5, 0.3, 0.4, 0.5)
    assert _numbers(mean_errors([one, None, two])) == pytest.approx((2, 3, 4, 0.2, 0.3, 0.4))
    assert mean_errors([None]) is None


def test_the_best_constant_depth_is_the_median_and_its_errors_are_those_of_a_flat_picture(rng):
    pictures = [rng.uniform(low, low + 0.5, (24, 32)) for low in (0.3, 0.5, 0.9)]
    masks = [rng.uniform(size=one.shape) < 0.5 for one in pictures]
    found = constant_errors([depth_histogram(*pair) for pair in zip(pictures, masks, strict=True)])
    assert found is not None
    constant, errors = found
    flat = [depth_errors(np.full(t.shape, constant), t, m) for t, m in zip(pictures, masks, strict=True)]
    mean = mean_errors(flat)
    assert mean is not None
    # Depths count as the middles of bins of 1 mm; a delta changes for pixels that cross its bound by that.
    assert (errors.rmse, errors.mae) == pytest.approx((mean.rmse, mean.mae), abs=BIN)
    assert _numbers(errors)[2:] == pytest.approx(_numbers(mean)[2:], abs=5e-3)
    for other in (constant - 0.02, constant + 0.02):
        worse = mean_errors([depth_errors(np.full(t.shape, other), t, m) for t, m in zip(pictures, masks, strict=True)])
        assert worse is not None
        assert worse.mae > mean.mae


def test_without_a_known_depth_there_is_no_constant(picture):
    _, true, _ = picture
    assert constant_errors([depth_histogram(true, np.zeros(true.shape, bool))]) is None
