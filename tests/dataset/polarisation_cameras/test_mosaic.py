from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.polarisation_cameras.mosaic import (
    filtered_light,
    pixel_axes,
    pixel_channels,
    reported,
    reported_variance,
    signal_of,
    stokes_of_mosaic,
)
from glassware.procedural.sensors.polarisation_cameras import POLARISATION_CAMERAS

MONO, COLOUR = POLARISATION_CAMERAS["imx250mzr"], POLARISATION_CAMERAS["imx250myr"]


def field(shape: tuple[int, int], slope: float) -> np.ndarray:
    """Partly polarised light, other in each colour, that changes linearly over the picture, (H, W, 4, 3)."""
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    ramp = 1.0 + slope * (u + 2.0 * v)
    vectors = np.array([[1.0, 0.8, 0.5], [0.3, -0.1, 0.2], [-0.4, 0.25, 0.1], [0.1, 0.0, -0.1]])
    return ramp[..., None, None] * vectors


def test_cells_of_the_mono_sensor_are_sonys():
    np.testing.assert_allclose(
        np.degrees(pixel_axes(MONO, (3, 4))), [[90, 45, 90, 45], [135, 0, 135, 0], [90, 45, 90, 45]]
    )
    assert not pixel_channels(MONO, (3, 4)).any()


def test_each_colour_of_the_bayer_mosaic_has_a_whole_cell():
    channels = pixel_channels(COLOUR, (4, 6))
    np.testing.assert_array_equal(channels, [[0, 0, 1, 1, 0, 0]] * 2 + [[1, 1, 2, 2, 1, 1]] * 2)
    for colour in range(3):
        axes = np.degrees(pixel_axes(COLOUR, (4, 4)))[channels[:, :4] == colour]
        assert sorted(set(axes)) == [0.0, 45.0, 90.0, 135.0]


@pytest.mark.parametrize("ratio", [10.0, 300.0])
@pytest.mark.parametrize(("device", "slope"), [(MONO, 0.0), (MONO, 0.02), (COLOUR, 0.0)])
def test_a_mosaic_gives_its_stokes_vectors_and_these_the_mosaic(device, slope, ratio):
    device = device.model_copy(update={"extinction_ratio": ratio})
    stokes = field((24, 32), slope)
    mosaic = filtered_light(device, stokes)
    found = stokes_of_mosaic(device, mosaic)
    expected = stokes[..., :3, :] if device.colour else stokes[..., :3, :] @ np.array([0.2126, 0.7152, 0.0722])[:, None]
    inside = (slice(2, -2), slice(2, -2)) if slope else ()  # a ramp is not extrapolated
    np.testing.assert_allclose(found[inside], expected[inside], atol=3e-6)
    colours = found if device.colour else np.repeat(found, 3, axis=-1)
    again = filtered_light(device, np.concatenate([colours, np.zeros_like(colours[..., :1, :])], axis=2))
    np.testing.assert_allclose(again[inside], mosaic[inside], atol=3e-6)


def test_the_sensor_adds_noise_of_its_photon_transfer_and_no_bias(rng):
    levels = np.linspace(0.05, 0.9, 8)
    stokes = np.zeros((8, 40_000, 4, 3))
    stokes[..., 0, :] = levels[:, None, None]
    light = filtered_light(MONO, stokes)
    signal = signal_of(reported(MONO, stokes, 1.0, rng), MONO.bits, MONO.black_level)
    variance = reported_variance(MONO, light[:, 0])
    error = np.sqrt(variance / 40_000)
    assert (np.abs(signal.mean(1) - light[:, 0]) < 5 * error).all()
    # A variance of n values has the relative error sqrt(2 / n).
    np.testing.assert_allclose(signal.var(1), variance, rtol=5 * np.sqrt(2 / 40_000))


def test_light_beyond_the_full_well_is_saturated(rng):
    stokes = np.zeros((2, 2, 4, 3))
    stokes[..., 0, :] = 9.0
    assert (reported(MONO, stokes, 1.0, rng) == 4095).all()


def test_the_degree_of_a_wholly_polarised_light_is_wrong_where_the_extinction_ratio_is_not_corrected():
    """(r - 1) / (r + 1): what a user of other software, who takes filters for ideal, finds."""
    stokes = np.zeros((8, 8, 4, 3))
    stokes[..., :2, :] = 1.0
    device = MONO.model_copy(update={"extinction_ratio": 20.0})
    mosaic = filtered_light(device, stokes)
    naive = stokes_of_mosaic(device.model_copy(update={"extinction_ratio": 1e9}), mosaic)[4, 4, :, 0]
    assert naive[1] / naive[0] == pytest.approx(19 / 21, abs=1e-6)
