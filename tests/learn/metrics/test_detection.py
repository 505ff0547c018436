from __future__ import annotations

import numpy as np
import pytest

from glassware.learn.metrics.detection import ImageOverlaps, average_precision, matches, mean_overlap


def picture(scores, overlaps, ignored=None) -> ImageOverlaps:
    overlaps = np.asarray(overlaps, float).reshape(len(scores), -1)
    return ImageOverlaps(np.asarray(scores, float), overlaps, np.asarray(ignored or [False] * overlaps.shape[1], bool))


def by_hand(pictures, threshold: float) -> float:
    """Ranks all detections together, then integrates the envelope over every recall that a hit reaches."""
    ranked = sorted(
        ((float(s), p, i) for p, pic in enumerate(pictures) for i, s in enumerate(pic.scores)), key=lambda row: -row[0]
    )
    taken, hits, curve = set(), 0, []
    labels = sum(len(pic.ignored) for pic in pictures)
    for seen, (_, p, i) in enumerate(ranked, start=1):
        options = [(o, j) for j, o in enumerate(pictures[p].overlaps[i]) if o >= threshold and (p, j) not in taken]
        if options:
            taken.add((p, max(options)[1]))
            hits += 1
        curve.append((hits / labels, hits / seen))
    levels = np.arange(1, labels + 1) / labels
    return float(np.mean([max((q for r, q in curve if r >= level - 1e-12), default=0.0) for level in levels]))


@pytest.mark.parametrize("threshold", [0.25, 0.5])
def test_average_precision_agrees_with_the_ranking_by_hand(rng, threshold):
    for _ in range(20):
        pictures = []
        for _ in range(5):
            n, m = (int(k) for k in rng.integers(1, 6, 2))
            overlaps = np.where(rng.uniform(size=(n, m)) < 0.5, 0.0, rng.uniform(size=(n, m)))
            pictures.append(picture(rng.uniform(size=n), overlaps))
        assert average_precision(pictures, threshold) == pytest.approx(by_hand(pictures, threshold))


def test_a_known_curve_has_its_area():
    # Right, false, right of 3 labels: precision 1 up to recall 1/3, then 2/3 up to 2/3.
    one = picture([0.9, 0.8], [[0.6, 0.0], [0.1, 0.1]])
    two = picture([0.7], [[0.9]])
    assert average_precision([one, two], 0.5) == pytest.approx(1 / 3 + 2 / 9)


def test_a_second_detection_of_one_object_is_false():
    twice = picture([0.9, 0.8, 0.7], [[0.6, 0.0], [0.9, 0.0], [0.0, 0.9]])
    assert matches(twice, 0.5).label_of.tolist() == [0, -1, 1]
    assert average_precision([twice], 0.5) == pytest.approx(0.5 + 0.5 * 2 / 3)


def test_what_need_not_be_found_is_neither_missed_nor_false():
    seen = picture([0.9, 0.8], [[0.0, 0.9], [0.9, 0.0]], [False, True])
    assert average_precision([seen], 0.5) == 1.0
    assert matches(seen, 0.5).left_out.tolist() == [True, False]
    assert np.isnan(average_precision([picture([0.9], [[0.9]], [True])], 0.5))


def test_a_missed_object_has_no_overlap():
    found, over_all = mean_overlap([picture([0.9], [[0.6, 0.1]]), picture([0.5], [[0.2]])], 0.25)
    assert found == pytest.approx(0.6)
    assert over_all == pytest.approx(0.2)


def test_nothing_found_is_zero():
    nothing = ImageOverlaps(np.zeros(0), np.zeros((0, 2)), np.zeros(2, bool))
    assert average_precision([nothing], 0.25) == 0.0
    assert mean_overlap([nothing], 0.25)[1] == 0.0
