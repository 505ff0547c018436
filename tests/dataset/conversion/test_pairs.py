"""A right picture that is not that of the stated camera is seen by the depth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.dataset.conversion.pairs import pair_agreement
from glassware.dataset.readers.source_view import SourceCamera, SourceView

K = np.array([[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]])


@pytest.fixture
def view(makers) -> SourceView:
    """A plane at 0.9 m: with 60 px and 0.12 m it moves by 8 px."""
    left = makers.picture()
    Z = np.full(left.shape[:2], 0.9, np.float32)
    return SourceView(left, np.roll(left, -8, axis=1), SourceCamera(K, None, 0.12), Z=Z)


def test_a_pair_is_alike_by_its_depth_alone(view):
    found = pair_agreement(view)
    assert found is not None
    by_depth, unmoved = found
    assert by_depth > 0.99
    assert unmoved < 0.3


def test_a_right_picture_that_is_the_left_one_is_alike_without_depth(view):
    found = pair_agreement(replace(view, right=view.picture))
    assert found is not None
    by_depth, unmoved = found
    assert by_depth < 0.3
    assert unmoved == pytest.approx(1.0)


def test_nothing_is_said_of_views_without_a_pair_or_depth(view):
    assert pair_agreement(replace(view, right=None)) is None
    assert pair_agreement(replace(view, Z=None)) is None
    assert pair_agreement(replace(view, Z=np.full_like(view.Z, np.nan))) is None
