from __future__ import annotations

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.dataset.depth_cameras.from_labels import BEHIND, MISSING, SUBPIXEL, painted
from glassware.dataset.depth_cameras.measure import HIDDEN, MEASURED, NO_MATCH, UNSEEN
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS
from glassware.render.frame import Geometry


def geometry(Z: np.ndarray, behind: np.ndarray) -> Geometry:
    ids, nothing = np.ones(Z.shape, np.uint16), np.zeros((0, *Z.shape), bool)
    ones = np.ones((*Z.shape, 3), np.float32)
    return Geometry(Z.astype(np.float32), ones, ids, behind.astype(np.float32), ids, ones, nothing, nothing)


def test_noise_on_a_wall_grows_with_the_square_of_its_distance(planes):
    device = DEPTH_CAMERAS["d435"].model_copy(update={"unit": 1e-4, "range": (0.17, 6.0)})
    fb = device.imager.focal * device.baseline
    colour = planes.colour_camera(planes.small())
    for z in (0.5, 2.0):
        Z = np.full((colour.height, colour.width), z)
        found, reason = painted(device, colour, geometry(Z, Z), np.zeros(Z.shape, bool), stream(1, 0, "test"))
        assert ((reason == MEASURED) == np.isfinite(found)).all()
        assert np.nanstd(found) == pytest.approx(z**2 * SUBPIXEL / fb, rel=0.2)
        assert abs(np.nanmean(found) - z) < 0.3 * z**2 * SUBPIXEL / fb


def test_glass_lacks_as_much_as_in_captures_and_shows_the_background_as_often(planes):
    device, colour = DEPTH_CAMERAS["d435"], planes.colour_camera(planes.small())
    Z, behind = np.full((colour.height, colour.width), 0.6), np.full((colour.height, colour.width), 0.7)
    glass = np.ones(Z.shape, bool)
    found, reason = painted(device, colour, geometry(Z, behind), glass, stream(1, 0, "test"))
    seen = (reason != HIDDEN) & (reason != UNSEEN)
    assert (reason == NO_MATCH)[seen].mean() == pytest.approx(MISSING, abs=0.04)
    has = found[np.isfinite(found)]
    assert (has > 0.65).mean() == pytest.approx(BEHIND, abs=0.06)
    assert ((np.abs(has - 0.6) < 0.01) | (np.abs(has - 0.7) < 0.01)).all()


def test_a_block_throws_a_shadow_to_its_left(planes):
    device, colour = DEPTH_CAMERAS["d435"], planes.colour_camera(planes.small())
    Z = np.full((colour.height, colour.width), 1.0)
    Z[30:90, 150:200] = 0.5
    found, _ = painted(device, colour, geometry(Z, Z), np.zeros(Z.shape, bool), stream(1, 0, "test"))
    row = np.isnan(found[60])
    # Seen from the right infrared camera, 65 mm to the right, the block hides more on its left.
    width = 430.0 * 0.065 * (1 / 0.5 - 1 / 1.0)
    left = row[int(150 - width) + 3 : 147]
    assert left.all()
    assert not row[203:300].any()
