from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.depth_cameras.measure import MEASURED, OUT_OF_RANGE
from glassware.dataset.depth_cameras.time_of_flight import NO_RETURN, WEAK, chosen, spread, timed
from glassware.procedural.sensors.time_of_flight import TIME_OF_FLIGHT_CAMERAS
from glassware.render.frame import Beams

L515 = TIME_OF_FLIGHT_CAMERAS["l515"]


def beams(planes, device, strength, path) -> Beams:
    """Three rays a pixel, a quarter, a half and a quarter of the beam, and the mirrored one."""
    colour = planes.colour_camera(planes.small())
    camera = device.scanner(colour)
    shape = (4, camera.height, camera.width)
    strength, path = (np.broadcast_to(np.array(x, np.float32)[:, None, None], shape) for x in (strength, path))
    weight = np.array([0.25, 0.5, 0.25, 1.0], np.float32)
    return Beams(camera, weight, strength, path, np.full(shape[1:], 1.0, np.float32))


@pytest.mark.parametrize(
    ("step", "returns", "expected"),
    [
        (0.1, "strongest", 1.0 + 0.1 * 0.25),  # one pulse: between the two surfaces, by their light
        (0.3, "strongest", 1.0),
        (0.1, "first", 1.0 + 0.1 * 0.25),
        (-0.3, "strongest", 1.0),
        (-0.3, "first", 0.7),
    ],
)
def test_returns_of_a_rim_are_mixed_within_a_pulse_and_told_apart_beyond(planes, step, returns, expected):
    device = L515.model_copy(update={"width": 16, "height": 16, "returns": returns})
    found = beams(planes, device, [0.5, 0.5, 0.5, 0.0], [1.0, 1.0, 1.0 + step, np.inf])
    strength, path = chosen(found, device)
    np.testing.assert_allclose(path, expected, rtol=1e-6)
    assert strength[0, 0] == pytest.approx(0.5 if abs(step) < 0.15 else 0.125 if path[0, 0] < 0.9 else 0.375)


def test_what_glass_mirrors_at_a_grazing_angle_outshines_what_is_behind_it(planes):
    device = L515.model_copy(update={"width": 16, "height": 16})
    found = beams(planes, device, [0.1, 0.1, 0.1, 0.3], [1.0, 1.0, 1.0, 2.0])
    np.testing.assert_allclose(chosen(found, device)[1], 2.0)


def test_noise_is_that_of_the_data_sheet_near_and_far(planes):
    assert spread(np.array(0.95), L515) == pytest.approx(0.0025, rel=0.01)
    assert spread(np.array(0.95 / 81), L515) == pytest.approx(0.0155)
    device = L515.model_copy(update={"width": 100, "height": 100, "place": 0.0})
    found = beams(planes, device, [0.95] * 3 + [0.0], [1.0, 1.0, 1.0, np.inf])
    Z = np.ones((120, 320), np.float32)
    report = timed(device, found, planes.colour_camera(planes.small()), Z, (1, 0, 0))
    rows, columns = np.indices(report.Z.shape)
    secant = np.sqrt(1 + ((rows - 49.5) ** 2 + (columns - 49.5) ** 2) / device.focal**2)
    assert (report.Z * secant).mean() == pytest.approx(1.0, abs=1e-4)
    assert (report.Z * secant).std() == pytest.approx(0.0025, rel=0.03)


@pytest.mark.parametrize(
    ("strength", "path", "reason"),
    [(0.5, 1.0, MEASURED), (0.0, np.inf, NO_RETURN), (0.005, 1.0, WEAK), (0.5, 0.1, OUT_OF_RANGE)],
)
def test_pixels_say_why_they_have_no_depth(planes, strength, path, reason):
    device = L515.model_copy(update={"width": 320, "height": 120, "place": 0.0})
    found = beams(planes, device, [strength] * 3 + [0.0], [path] * 3 + [np.inf])
    Z = np.ones((120, 320), np.float32)
    report = timed(device, found, planes.colour_camera(planes.small()), Z, (1, 0, 0))
    assert ((report.depth > 0) == (report.reason == MEASURED)).all()
    assert report.reason[60, 160] == reason
