from __future__ import annotations

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.dataset.depth_cameras.exposure import InfraredPictures, infrared_pictures
from glassware.dataset.depth_cameras.matching import matched
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS

#: Sub-pixel error that the vendor states for real scenes [px].
SUBPIXEL = 0.08


def depths(device, infrared) -> np.ndarray:
    disparity = matched(infrared_pictures(infrared, device, stream(1, 0, "test")), device.matching)
    return device.imager.focal * device.baseline / disparity


@pytest.mark.parametrize("z", [0.3, 0.7, 2.0])
def test_a_wall_is_found_at_its_depth_with_the_spread_of_the_device(planes, z):
    device = planes.small()
    fb = device.imager.focal * device.baseline
    found = depths(device, planes.plane(device, z))[8:-8, int(fb / z) + 8 : -8]
    error = found - z
    spread = z**2 * SUBPIXEL / fb
    assert np.isfinite(found).mean() > (0.99 if z < 1.0 else 0.8)
    assert abs(np.nanmedian(error)) < 0.5 * spread
    quartiles = np.nanpercentile(error, [25, 75])
    # Near walls are better than real ones, which have speckle and a calibration; far ones are noisy.
    assert np.ptp(quartiles) / 1.349 < (1.0 if z < 1.0 else 2.5) * spread


def test_a_slanted_plane_is_found_in_its_place(planes):
    device, normal = planes.small(), (0.35, 0.2, 1.0)
    infrared = planes.plane(device, 0.6, normal)
    found = depths(device, infrared)
    inner = (slice(8, -8), slice(48, -8))
    error = (found - infrared.Z)[inner]
    assert np.isfinite(error).mean() > 0.97
    fb = device.imager.focal * device.baseline
    as_pixels = np.abs(fb / found[inner] - fb / infrared.Z[inner])
    assert np.nanmedian(as_pixels) < SUBPIXEL
    assert abs(np.nanmedian(error)) < 0.5e-3


def test_a_white_wall_has_depth_by_its_pattern_alone(planes):
    device = planes.small()
    dark = device.model_copy(update={"projector": device.projector.model_copy(update={"power": 0.0})})
    with_dots, without = (depths(one, planes.plane(one, 0.6))[:, 48:] for one in (device, dark))
    assert np.isfinite(with_dots).mean() > 0.98
    right = np.abs(without - 0.6) < 0.01
    assert right.mean() < 0.02


def test_fractions_of_a_pixel_are_found_without_a_preference_for_whole_ones(rng):
    picture = rng.uniform(0.0, 1.0, (80, 260))
    spectrum = np.fft.rfft2(picture)
    fy, fx = np.fft.fftfreq(80)[:, None], np.fft.rfftfreq(260)
    spectrum *= np.exp(-0.5 * (2 * np.pi * 1.3) ** 2 * (fx**2 + fy**2))  # dots of three pixels
    for shift in (20.0, 20.25, 20.5, 20.75):
        moved = spectrum * np.exp(2j * np.pi * fx * shift)
        left, right = (np.fft.irfft2(one, s=(80, 260)) for one in (spectrum, moved))
        low, high = left.min(), left.max()
        seen, other = (
            np.clip((one - low) / (high - low) * 255, 0, 255).round().astype(np.uint16) for one in (left, right)
        )
        pictures = InfraredPictures(seen, other, 255, np.ones((80, 260), np.float32), 1.0, 1.0)
        found = matched(pictures, DEPTH_CAMERAS["d435"].matching)[12:-12, 40:-30]
        assert np.isfinite(found).mean() > 0.95
        assert np.nanmedian(found) == pytest.approx(shift, abs=0.035)


def test_a_ball_is_found_on_its_surface_and_its_shadows_have_no_right_match(planes):
    device = planes.small()
    infrared = planes.ball_before_wall(device, radius=0.07, near=0.55, wall=0.9)
    found = depths(device, infrared)
    Z, fb = infrared.Z, device.imager.focal * device.baseline
    rows, columns = np.indices(Z.shape)
    x, y = (columns - device.centre[0]) / device.imager.focal * Z, (rows - device.centre[1]) / device.imager.focal * Z
    ball = (Z < 0.89) & (np.hypot(x, y) < 0.05)
    assert ball.sum() > 2000
    assert np.isfinite(found[ball]).mean() > 0.95
    off = (fb / found - fb / Z)[ball]
    assert abs(np.nanmedian(off)) < 0.1
    assert np.nanmedian(np.abs(off)) < 0.2
    # The projector stands to the right: what it does not light is to the left of the ball, as what the right camera
    # does not see is.
    wall = Z > 0.89
    for hidden in (wall & ~infrared.lit, wall & ~infrared.shared):
        assert np.median(columns[hidden]) < device.centre[0] - 0.05 * device.imager.focal / 0.62
    dark = wall & ~infrared.lit & ~infrared.shared & (columns > fb / 0.9)
    assert (np.abs(found - Z)[dark] < 0.01).mean() < 0.3
