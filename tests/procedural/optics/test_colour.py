from __future__ import annotations

import warnings

import numpy as np
import pytest

from glassware.procedural.optics.catalogue import catalogue, olive_oil, soda_lime, water
from glassware.procedural.optics.colour import (
    LIQUID_LENGTH,
    REFERENCE_TRANSMITTANCE,
    WALL_LENGTH,
    WAVELENGTHS,
    WEIGHTS,
    rgb_absorption,
    transmitted_rgb,
)
from glassware.procedural.optics.medium import Absorber
from glassware.procedural.optics.spectra import mixture

#: Luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# The stored weights have eight decimals, and there are 81 of them.
STORED_DIGITS = 1e-6


@pytest.fixture(scope="module")
def colour():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns that Matplotlib is missing
        return pytest.importorskip("colour", reason="colour-science is not installed")


def _by_colour_science(colour, transmittance):
    """Linear Rec.709 of a transmittance under D65, by colour-science's own integration at 1 nm."""
    nm = np.arange(380.0, 781.0)
    sd = colour.SpectralDistribution(transmittance(nm), nm)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        xyz = colour.sd_to_XYZ(
            sd,
            colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"],
            colour.SDS_ILLUMINANTS["D65"],
            method="Integration",
            shape=colour.SpectralShape(380, 780, 1),
        )
    return colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB @ (xyz / 100.0)


def test_the_stored_weights_are_those_of_colour_science(colour):
    shape = colour.SpectralShape(380, 780, 5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
        light = colour.SDS_ILLUMINANTS["D65"].copy().align(shape)
    weights = observer.values * light.values[:, None]
    rgb = weights @ colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB.T
    assert np.array_equal(shape.range(), WAVELENGTHS)
    assert np.abs(rgb / rgb.sum(axis=0) - WEIGHTS).max() < STORED_DIGITS


@pytest.mark.parametrize("length", [0.002, 0.01, 0.05])
@pytest.mark.parametrize(
    "absorbers",
    [
        (("water", 1.0),),
        (("soda-lime, green", 1.0),),
        (("water", 1.0), ("tartrazine", 0.01)),
        (("water", 1.0), ("erythrosine", 0.002)),
        (("water", 1.0), ("brilliant blue FCF", 0.002)),
    ],
)
def test_a_colour_is_the_one_that_colour_science_integrates(colour, absorbers, length):
    parts = tuple(Absorber(spectrum=name, amount=amount) for name, amount in absorbers)
    expected = _by_colour_science(colour, lambda nm: np.exp(-mixture(parts, nm) * length))
    # 5 nm against 1 nm, and 3e-4 of difference between the illuminant's and the space's white.
    assert transmitted_rgb(parts, length) == pytest.approx(expected, abs=2e-3)


def test_a_clear_medium_is_white():
    assert transmitted_rgb((), 1.0) == pytest.approx([1.0, 1.0, 1.0], abs=STORED_DIGITS)
    assert rgb_absorption((), LIQUID_LENGTH) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", sorted(n for n, m in catalogue().items() if m.absorbers))
def test_the_stored_rgb_gives_the_spectral_colour_at_the_reference_length(name):
    medium = catalogue()[name]
    longest = WALL_LENGTH if medium.surface_tension is None else LIQUID_LENGTH
    spectral = transmitted_rgb(medium.absorbers, longest)
    for channel, sigma in zip(spectral, medium.sigma_a, strict=True):
        if channel >= REFERENCE_TRANSMITTANCE:
            assert np.exp(-sigma * longest) == pytest.approx(min(channel, 1.0), abs=1e-9)
        else:
            own = -np.log(REFERENCE_TRANSMITTANCE) / sigma
            assert own < longest
            c = medium.sigma_a.index(sigma)
            assert transmitted_rgb(medium.absorbers, own)[c] == pytest.approx(REFERENCE_TRANSMITTANCE, abs=1e-6)


def test_deep_water_is_blue_green():
    red, green, blue = transmitted_rgb((Absorber(spectrum="water", amount=1.0),), 5.0)
    assert blue > green > 2.0 * red


def test_a_glass_of_water_is_colourless_to_the_eye():
    # One 8-bit step near white is 0.9 % in linear light.
    assert transmitted_rgb((Absorber(spectrum="water", amount=1.0),), 0.03) == pytest.approx([1.0] * 3, abs=0.01)


def test_window_glass_is_greenish_on_its_edge():
    red, green, blue = np.exp(-np.array(soda_lime(1.0).sigma_a) * 0.3)
    assert green > blue > red
    assert green > 1.5 * red


def test_low_iron_glass_is_clearer_than_window_glass():
    assert max(soda_lime(0.0).sigma_a) < 0.4 * max(soda_lime(1.0).sigma_a)


@pytest.mark.parametrize(
    # The channel that each dye takes away, at a concentration that leaves a clear colour in 20 mm.
    ("dye", "amount", "taken"),
    [
        ("tartrazine", 0.02, 2),
        ("sunset yellow FCF", 0.02, 2),
        ("azorubine", 0.02, 1),
        ("allura red AC", 0.02, 1),
        ("erythrosine", 0.004, 1),
        ("brilliant blue FCF", 0.003, 0),
        ("patent blue V", 0.003, 0),
    ],
)
def test_a_dye_takes_away_its_complement(dye, amount, taken):
    rgb = transmitted_rgb((Absorber(spectrum=dye, amount=amount),), 0.02)
    assert 1.8 * rgb[taken] < min(np.delete(rgb, taken)) or rgb[taken] < 0.0


def test_tartrazine_is_yellow_and_allura_red_is_red():
    yellow = transmitted_rgb((Absorber(spectrum="tartrazine", amount=0.02),), 0.02)
    red = transmitted_rgb((Absorber(spectrum="allura red AC", amount=0.05),), 0.02)
    assert yellow[1] > 0.6
    assert yellow[2] < 0.1
    assert red[1] < 0.1 * red[0]


def test_yellow_and_blue_dye_make_green():
    red, green, blue = transmitted_rgb(
        (Absorber(spectrum="tartrazine", amount=0.03), Absorber(spectrum="brilliant blue FCF", amount=0.003)), 0.02
    )
    assert green > 2.0 * max(red, blue)


def test_olive_oil_is_yellow_and_holds_back_blue():
    red, green, blue = np.exp(-np.array(olive_oil().sigma_a) * 0.02)
    assert red > green > 0.5
    assert blue < 0.1


def test_a_colour_outside_rec709_gets_finite_absorption():
    deep = water(Absorber(spectrum="tartrazine", amount=0.1))
    assert transmitted_rgb(deep.absorbers, 0.02)[2] < 0.0
    assert deep.sigma_a[0] == 0.0
    assert np.isfinite(deep.sigma_a).all()
    assert deep.sigma_a[2] > deep.sigma_a[1]


@pytest.mark.parametrize("name", ["water", "soda-lime glass", "green soda-lime glass", "lead crystal", "PET"])
def test_rgb_absorption_errs_little_between_one_and_ten_centimetres_of_pale_media(name):
    # docs/media.md states at most 0.050, the red of green glass: broad, weak absorption is nearly one law a channel.
    medium = catalogue()[name]
    for length in np.linspace(0.01, 0.1, 10):
        spectral = transmitted_rgb(medium.absorbers, length)
        assert np.abs(np.exp(-np.array(medium.sigma_a) * length) - spectral).max() < 0.05


def test_the_luminance_weights_are_those_of_the_table():
    # The luminance of Rec.709 from the integrated RGB is the integral with the observer's y, so a grey stays grey.
    assert (np.full(81, 0.5) @ WEIGHTS) @ LUMINANCE == pytest.approx(0.5, abs=1e-6)
