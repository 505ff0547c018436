from __future__ import annotations

import numpy as np
import pytest

from glassware.learn.metrics.detection import average_precision, mean_overlap
from glassware.learn.metrics.instances import ImageMasks, image_masks, instance_precision, mask_overlaps

SIDE = 40


def drawn(rng, pictures: int) -> list[ImageMasks]:
    """Squares, and found ones that are shifted, missed, or not there at all."""
    made = []
    for _ in range(pictures):
        true, found, scores = [], [], []
        for x in (2, 15, 28):
            mask = np.zeros((SIDE, SIDE), bool)
            mask[x : x + 10, x : x + 10] = True
            true.append(mask)
            if rng.uniform() < 0.8:
                found.append(np.roll(mask, int(rng.integers(0, 4)), axis=1))
                scores.append(rng.uniform(0.3, 1.0))
        if rng.uniform() < 0.5:
            found.append(np.roll(true[0], 20, axis=1))
            scores.append(rng.uniform())
        none = np.zeros((0, SIDE, SIDE), bool)
        made.append(
            image_masks(np.array(scores), np.array(found) if found else none, np.array(true), np.zeros(3, bool))
        )
    return made


def test_coco_agrees_with_our_own_average_precision(rng):
    """COCO takes the envelope at 101 recalls, ours at every one: they differ by less than one step of 1/100."""
    pictures = drawn(rng, 20)
    precision = instance_precision(pictures)
    overlaps = [mask_overlaps(picture) for picture in pictures]
    assert precision.ap50 == pytest.approx(average_precision(overlaps, 0.5), abs=0.01)
    assert precision.ap75 == pytest.approx(average_precision(overlaps, 0.75), abs=0.01)
    thresholds = [average_precision(overlaps, t) for t in np.arange(50, 100, 5) / 100]
    assert precision.ap == pytest.approx(np.mean(thresholds), abs=0.01)
    assert 0.1 < precision.ap < precision.ap50 < 0.99


def test_the_overlap_of_masks_is_their_iou(rng):
    found, true = rng.uniform(size=(3, 8, 9)) < 0.5, rng.uniform(size=(2, 8, 9)) < 0.5
    overlaps = mask_overlaps(image_masks(np.ones(3), found, true, np.zeros(2, bool))).overlaps
    for i in range(3):
        for j in range(2):
            assert overlaps[i, j] == pytest.approx((found[i] & true[j]).sum() / (found[i] | true[j]).sum())


def test_perfect_masks_have_the_precision_one_and_none_zero(rng):
    (picture,) = drawn(rng, 1)
    perfect = ImageMasks(picture.size, np.array([0.9, 0.8, 0.7]), picture.true, picture.true, picture.ignored)
    assert instance_precision([perfect]).ap == pytest.approx(1.0)
    assert mean_overlap([mask_overlaps(perfect)], 0.5) == (1.0, 1.0)
    nothing = ImageMasks(picture.size, np.zeros(0), (), picture.true, picture.ignored)
    assert instance_precision([nothing]).ap == 0.0
    assert np.isnan(instance_precision([ImageMasks(picture.size, np.zeros(0), (), (), np.zeros(0, bool))]).ap)


def test_what_need_not_be_found_is_neither_missed_nor_false(rng):
    (picture,) = drawn(rng, 1)
    ignored = np.array([False, True, True])
    some = ImageMasks(picture.size, np.array([0.9, 0.8]), picture.true[:2], picture.true, ignored)
    assert instance_precision([some]).ap == pytest.approx(1.0)
