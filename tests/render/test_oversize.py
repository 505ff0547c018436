"""Pictures with a margin: a black board from above, whose edges lie outside of the frame, in light of radiance 1."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.margin import in_frame
from glassware.procedural.description.picture import Picture
from glassware.procedural.primitives.scenes import board, camera, matte, scene
from glassware.render.renderer import Renderer

#: Width, height and margin [px]: left, top, right, bottom.
WIDTH, HEIGHT, MARGIN = 24, 24, (3, 4, 5, 4)
#: Height of the camera [m], and where the board ends: 2.25 px beyond the middle of the frame's last pixels.
ABOVE, BEYOND = 0.5, 2.25


@pytest.fixture(scope="module")
def frames(backend):
    """The view without and with a margin."""
    side = 2 * ABOVE * ((WIDTH - 1) / 2 + BEYOND) / WIDTH
    table = board((side, side, 0.03), matte((0.0, 0.0, 0.0)))
    view = camera((0.0, 0.0, ABOVE), width=WIDTH, height=HEIGHT)
    picture = Picture(spp=4, light="path", layers=0, refraction=False)
    renderer = Renderer(scene([], [view], table=table, picture=picture))
    with pytest.raises(InputError, match=r"margin: expected .*, found -1"):
        renderer.frame(0, (-1, 0, 0, 0))
    return renderer.frame(0), renderer.frame(0, MARGIN)


def test_a_margin_changes_nothing_of_the_frame(frames) -> None:
    alone, with_margin = frames
    assert alone.oversize is None
    wide = with_margin.oversize
    for eye in ("left", "right"):
        assert np.array_equal(getattr(alone, eye), getattr(with_margin, eye))
        assert np.array_equal(in_frame(getattr(wide, eye), MARGIN), getattr(alone, eye))
    assert np.array_equal(with_margin.geometry.Z, alone.geometry.Z)


def test_the_margin_shows_what_lies_beyond_the_frame(frames) -> None:
    wide = frames[1].oversize
    left, top, right, bottom = MARGIN
    assert wide.left.shape == (HEIGHT + top + bottom, WIDTH + left + right, 3)
    u, v = np.meshgrid(np.arange(-left, WIDTH + right), np.arange(-top, HEIGHT + bottom))
    beyond = np.maximum(np.abs(u - (WIDTH - 1) / 2), np.abs(v - (HEIGHT - 1) / 2)) - (WIDTH - 1) / 2
    on, off = beyond <= 1, beyond >= 3  # the second pixel beyond the frame shows the edge
    assert on.sum() > WIDTH * HEIGHT
    assert off.any()
    assert (wide.left[on] < 0.1).all()  # what its surface mirrors
    np.testing.assert_allclose(wide.left[off], 1.0, rtol=1e-5)
    np.testing.assert_allclose(wide.Z[beyond <= 2], ABOVE, rtol=1e-5)
    assert np.isinf(wide.Z[off]).all()
