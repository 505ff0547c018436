from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.vessels.families import FAMILIES
from glassware.procedural.vessels.family_pieces import MAX_SLOPE, Size, free_chain
from glassware.procedural.vessels.outline import Outline, bulging, easing, levelling, linear, waved
from glassware.procedural.vessels.settings import Category

LOW, HIGH, START, END = 0.02, 0.07, 0.03, 0.02
PIECES = {
    "linear": linear(LOW, HIGH, START, END),
    "bulging": bulging(LOW, HIGH, START, END, bulge=0.004, skew=-0.003),
    "waved": waved(LOW, HIGH, START, END, amplitude=0.002, half_waves=3),
    "levelling": levelling(LOW, HIGH, START, END, power=4),
    "easing": easing(LOW, HIGH, START, END),
}


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_joins_its_two_radii(name):
    ends = PIECES[name].derivative(np.array([LOW, HIGH]), 0)
    np.testing.assert_allclose(ends, [START, END], atol=1e-15)


@pytest.mark.parametrize("name", PIECES)
@pytest.mark.parametrize("order", [1, 2])
def test_a_piece_knows_its_derivatives(name, order):
    z, step = np.linspace(LOW + 1e-3, HIGH - 1e-3, 50), 1e-6
    piece = PIECES[name]
    differences = (piece.derivative(z + step, order - 1) - piece.derivative(z - step, order - 1)) / (2 * step)
    # Central differences over 2 um: truncation is below 1e-7 of the scale, rounding below 1e-7 absolute in slope.
    scale = np.abs(differences).max() + 1.0
    np.testing.assert_allclose(piece.derivative(z, order), differences, atol=1e-6 * scale)


def test_a_bulge_is_as_high_as_it_says_in_the_middle():
    middle = bulging(0.0, 0.1, 0.02, 0.04, bulge=0.005, skew=0.002).derivative(0.05, 0)
    assert middle == pytest.approx(0.03 + 0.005, abs=1e-15)


#: Families of an outline over the height; the profiles of the others are drawn as curves (`laboratory`).
OUTLINED = [category for category in FAMILIES if category not in ("test tube", "round flask")]


def _drawn(category: Category, seed: int) -> tuple[Outline, Size]:
    rng, family = np.random.default_rng(seed), FAMILIES[category]
    height = rng.uniform(*family.height)
    size = Size(height, float(np.clip(height * rng.uniform(*family.slenderness), *family.radius)), 0.011)
    outline = family.outline(rng, size)
    assert isinstance(outline, Outline)
    return outline, size


@pytest.mark.parametrize("category", OUTLINED)
def test_outlines_are_continuous_with_continuous_slope(category):
    for seed in range(20):
        outline, _ = _drawn(category, seed)
        z = np.linspace(0.0, outline.height, 20001)
        radius, slope = outline.derivative(z, 0), outline.derivative(z, 1)
        # The trapezoidal sum of the slope is the radius again: no jump of the radius hides anywhere.
        summed = radius[0] + np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(z))])
        np.testing.assert_allclose(radius, summed, atol=2e-6)
        # A kink would leave a jump of the slope that does not shrink with the step; 15 um of height are not enough
        # for the tightest joint to turn by more than this.
        assert np.abs(np.diff(slope)).max() < 0.25


@pytest.mark.parametrize("category", OUTLINED)
def test_outlines_stay_within_the_size_they_are_drawn_for(category):
    for seed in range(40):
        outline, size = _drawn(category, seed)
        radius = outline.derivative(np.linspace(0.0, outline.height, 2001), 0)
        # Smoothed joints may overshoot their pieces a little; a lip may flare beyond a neck, not beyond the body.
        assert radius.max() <= 1.02 * size.radius
        # A stem is solid. The neck of a small vessel is at most 0.8 of its radius wide.
        stemmed = category in ("stem glass", "cocktail glass")
        floor = 0.0025 if stemmed else 0.95 * min(size.room, 0.8 * size.radius)
        assert radius.min() >= floor
        assert outline.height == pytest.approx(size.height)


def test_free_chains_use_every_kind_of_piece_and_keep_their_slope(rng):
    kinds = set()
    for _ in range(100):
        z = np.linspace(0.0, 0.12, 4).tolist()
        for piece in free_chain(rng, z, rng.uniform(0.0, 0.1, 4).tolist(), (0.015, 0.05), 0.3):
            kinds.add("sine" if piece.half_waves else "polynomial" if len(piece.coefficients) > 2 else "linear")
            heights = np.linspace(piece.low, piece.high, 200)
            assert np.abs(piece.derivative(heights, 1)).max() <= MAX_SLOPE + 0.01
            radius = piece.derivative(heights, 0)
            # Pieces are checked at 65 heights when they are drawn; between those they may pass by little.
            assert radius.min() >= 0.015 - 2e-5
            assert radius.max() <= 0.05 + 2e-5
    assert kinds == {"linear", "polynomial", "sine"}


def test_sampled_points_are_evenly_spaced_with_normals_across_the_curve():
    outline, _ = _drawn("stem glass", 3)
    curve = outline.sampled(1e-4)
    steps = np.diff(curve.points, axis=0)
    lengths = np.hypot(*steps.T)
    np.testing.assert_allclose(lengths, lengths.mean(), rtol=0.05)
    across = (steps * 0.5 * (curve.normals[1:] + curve.normals[:-1])).sum(1) / lengths
    assert np.abs(across).max() < 0.02
    assert (curve.normals[:, 0] > 0.0).all()
