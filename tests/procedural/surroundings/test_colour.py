"""Colours of black bodies, against published figures."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.surroundings.colour import black_body, black_body_chromaticity, luminance, rgb_of_xyy

# The fitted observer moves a chromaticity by some thousandths.
FIT = 0.004


@pytest.mark.parametrize(
    ("temperature", "chromaticity"),
    [(2000, (0.5267, 0.4133)), (2856, (0.4476, 0.4074)), (4000, (0.3805, 0.3768)), (6500, (0.3135, 0.3237))],
)
def test_a_black_body_lies_on_the_planckian_locus(temperature, chromaticity):
    # CIE 15, table of the Planckian locus; 2856 K is standard illuminant A.
    np.testing.assert_allclose(black_body_chromaticity(temperature), chromaticity, atol=FIT)


@pytest.mark.filterwarnings("ignore")  # of colour-science's import: optional packages that are missing
def test_black_bodies_agree_with_colour_science():
    colour = pytest.importorskip("colour", reason="colour-science is not installed")
    shape = colour.SpectralShape(360, 830, 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    for temperature in (2000.0, 2700.0, 4000.0, 6500.0, 20000.0):
        spectrum = colour.sd_blackbody(temperature, shape)
        xyz = colour.sd_to_XYZ(spectrum, observer, colour.sd_ones(shape), method="Integration")
        np.testing.assert_allclose(black_body_chromaticity(temperature), colour.XYZ_to_xy(xyz), atol=FIT)


def test_6500_kelvin_is_near_the_white_of_rec709():
    # D65 lies 0.005 above the locus in y.
    np.testing.assert_allclose(black_body_chromaticity(6500.0), (0.3127, 0.3290), atol=0.008)
    np.testing.assert_allclose(black_body(6500.0), 1.0, atol=0.08)


def test_d65_white_is_one_in_all_primaries():
    # The matrix is given to four digits.
    np.testing.assert_allclose(rgb_of_xyy(np.array([0.3127, 0.3290, 1.0])), 1.0, atol=1e-3)


def test_black_bodies_have_luminance_one_and_grow_bluer():
    colours = np.array([black_body(t) for t in (2000.0, 2700.0, 4000.0, 6500.0, 20000.0)])
    np.testing.assert_allclose(luminance(colours), 1.0, atol=1e-3)
    assert (colours > 0.0).all()
    assert (np.diff(colours[:, 2] / colours[:, 0]) > 0.0).all()


def test_a_temperature_outside_the_gamut_is_refused():
    with pytest.raises(ValueError, match="2000 to 20000"):
        black_body(1000.0)
