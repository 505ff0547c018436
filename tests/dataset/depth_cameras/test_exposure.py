from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.dataset.depth_cameras.exposure import exposed, in_region, infrared_pictures
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS

#: Planck's constant [J s], speed of light [m/s].
h, c = 6.62607015e-34, 299792458.0


def test_mean_and_variance_of_a_ramp_are_those_of_photons_and_read_noise(planes):
    device = planes.small()
    imager = device.imager.model_copy(update={"exposure": (1e-3, 1e-3), "gain": 1.0, "bits": 16, "blur": 0.0})
    device = device.model_copy(update={"imager": imager})
    ramp = np.repeat(np.array([0.1, 0.3, 1.0, 2.0], np.float32), 80)[None].repeat(120, axis=0)  # W/(m^2 sr)
    nothing = np.zeros_like(ramp)
    infrared = replace(planes.plane(device, 1.0), dots=(ramp, ramp), ambient=(nothing, nothing))
    pictures = infrared_pictures(infrared, device, stream(1, 0, "test"))
    assert (pictures.exposure, pictures.gain) == (1e-3, 1.0)
    watts = ramp * math.pi / (4 * imager.aperture**2) * imager.pitch**2
    electrons = watts * 1e-3 / (h * c / (device.projector.wavelength * 1e-9)) * imager.efficiency
    steps = 65535 / imager.full_well
    for column in range(0, 320, 80):
        found = pictures.left[:, column : column + 80].astype(float) / steps
        expected = electrons[0, column]
        assert expected < imager.full_well
        assert found.mean() == pytest.approx(expected, abs=5 * math.sqrt(expected + 16) / math.sqrt(9600) + 0.1)
        assert found.var() == pytest.approx(expected + imager.read_noise**2, rel=0.06)


def test_exposure_brings_the_mean_to_its_target_with_white_pixels_as_white():
    imager = DEPTH_CAMERAS["d435"].imager
    even = np.full((40, 40), 1e6)
    time, gain = exposed(even, imager)
    assert gain == pytest.approx(1.0)
    assert time * 1e6 / imager.full_well == pytest.approx(imager.target)
    sunlit = even.copy()
    sunlit[16:20] *= 1e4  # a fifth of the region's rows
    time, gain = exposed(sunlit, imager)
    # 0.2 + 0.8 x = target, however bright that fifth is.
    assert time * 1e6 / imager.full_well == pytest.approx((imager.target - 0.2) / 0.8)
    sunlit[16:20] *= 10.0
    assert exposed(sunlit, imager)[0] == pytest.approx(time)
    time, gain = exposed(even * 1e-2, imager)  # dark: the longest time, and gain
    assert time == imager.exposure[1]
    assert time * gain * 1e4 / imager.full_well == pytest.approx(imager.target)
    assert exposed(even * 0.0, imager) == pytest.approx((imager.exposure[1], imager.gain))
    assert exposed(even * 1e9, imager)[0] == pytest.approx(imager.exposure[0])


def test_a_bright_background_outside_the_region_changes_no_exposure():
    imager = DEPTH_CAMERAS["d435"].imager
    table = np.full((40, 80), 1e6)
    yard = table.copy()
    yard[:8] *= 100.0
    assert exposed(yard, imager) == exposed(table, imager)
    whole = imager.model_copy(update={"region": (0.0, 0.0, 1.0, 1.0)})
    assert exposed(yard, whole)[0] < 0.6 * exposed(table, whole)[0]
    # A region that no pixel's centre is in has the pixel that it lies in.
    assert in_region(np.arange(12.0).reshape(3, 4), (0.5, 0.99, 0.51, 1.0)).tolist() == [[10.0]]


def test_daylight_is_more_power_for_its_luminance_than_the_light_of_lamps(planes):
    device = planes.small()
    imager = device.imager.model_copy(update={"exposure": (1e-3, 1e-3), "gain": 1.0, "bits": 16, "blur": 0.0})
    device = device.model_copy(update={"imager": imager})
    nothing = np.zeros((120, 320), np.float32)
    lamps = replace(planes.plane(device, 1.0, ambient=0.1), dots=(nothing, nothing))
    means = [
        infrared_pictures(one, device, stream(1, 0, "test")).left.mean()
        for one in (lamps, replace(lamps, daylight=True))
    ]
    assert means[1] / means[0] == pytest.approx(imager.efficacy / imager.daylight_efficacy, rel=0.01)
