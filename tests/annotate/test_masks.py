from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pycocotools import mask as coco

from glassware.annotate.masks import Pixels, count_pixels, decode_mask, encode_mask, fractions


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.97, 1.0])
def test_a_mask_comes_back_from_its_encoding_bit_by_bit(rng, share):
    mask = rng.random((37, 53)) < share
    np.testing.assert_array_equal(decode_mask(encode_mask(mask), mask.shape), mask)


def test_our_reader_of_masks_agrees_with_pycocotools(rng):
    mask = rng.random((300, 41)) < 0.01
    mask[40:250, 7:30] = True
    text = encode_mask(mask)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # pycocotools' own, about NumPy 2
        theirs = coco.decode({"size": list(mask.shape), "counts": text.encode()})
    np.testing.assert_array_equal(decode_mask(text, mask.shape), theirs.astype(bool))
    assert coco.area({"size": list(mask.shape), "counts": text.encode()}) == mask.sum()


@pytest.mark.parametrize("text", ["", "ppppp", "1", "0e", "\x00", "~", "o" * 40, "PPP0P"])
def test_a_damaged_mask_is_refused(text):
    with pytest.raises(ValueError, match="mask: expected"):
        decode_mask(text, (7, 5))


@given(st.integers(0, 400_000), st.integers(0, 400_000), st.integers(0, 400_000))
def test_fractions_sum_to_exactly_one_in_any_order(visible, seen_through, occluded):
    whole = visible + seen_through + occluded
    found = fractions(Pixels(silhouette=whole, visible=visible, seen_through=seen_through, occluded=occluded))
    if found is None:
        assert whole == 0
        return
    values = a, b, c = found.visible, found.seen_through, found.occluded
    assert a + b + c == b + c + a == c + a + b == 1.0
    # A fraction is a multiple of 2^-40; the last one takes the rounding of the two others.
    np.testing.assert_allclose(values, [visible / whole, seen_through / whole, occluded / whole], atol=2.0**-39)
    assert [value == 0.0 for value in values] == [visible == 0, seen_through == 0, occluded == 0]


def test_the_pixels_of_a_silhouette_are_visible_behind_glass_or_occluded(analytic):
    scene = analytic.scene()
    # From this side the block stands before the ball.
    camera = analytic.camera(1).model_copy(update={"world_T_camera": _from_the_right(analytic)})
    geometry = analytic.geometry(scene, camera)
    counts = [count_pixels(geometry, i, item.id) for i, item in enumerate(scene.objects)]
    assert [c.silhouette for c in counts] == geometry.crossed.sum(axis=(1, 2)).tolist()
    ball = counts[1]
    assert ball.occluded > 0
    assert ball.occluded == int((geometry.crossed[1] & (geometry.background_id != 3)).sum())
    assert ball.visible == int((geometry.id == 3).sum())


def _from_the_right(analytic):
    ball, block = np.array([-0.09, 0.06, 0.045]), np.array([0.08, 0.05, 0.05])
    eye = block + 2.5 * (block - ball) + [0.0, 0.02, 0.05]
    forward = (ball - eye) / np.linalg.norm(ball - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    matrix[:3, 3] = eye
    return matrix
