from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.optics.catalogue import catalogue, sugar_solution, tinted_soda_lime, water
from glassware.procedural.optics.dyes import DYES, PIGMENTS
from glassware.procedural.optics.medium import AIR, Absorber
from glassware.procedural.optics.spectra import SPECTRA, Sampled, absorption, coefficient, from_extinction


def test_water_has_its_known_minimum_and_values():
    nm = np.arange(380.0, 727.6, 0.5)
    a = absorption(water(), nm)
    # Pope and Fry 1997, abstract: 0.0044 1/m at 418 nm.
    assert nm[np.argmin(a)] == pytest.approx(418.0, abs=2.5)
    assert a.min() == pytest.approx(0.0044, abs=0.0001)
    assert absorption(water(), 650.0) == pytest.approx(0.340)


def test_water_agrees_with_an_older_independent_measurement():
    # Hale and Querry 1973, doi:10.1364/AO.12.000555: k at 600-700 nm. In the red, where water absorbs
    # clearly, both agree within 20 %; in the blue the old samples were not pure.
    nm = np.array([600.0, 625.0, 650.0, 675.0, 700.0])
    k = np.array([1.09e-8, 1.39e-8, 1.64e-8, 2.23e-8, 3.35e-8])
    old = 4.0 * np.pi * k / (nm * 1e-9)
    assert absorption(water(), nm) == pytest.approx(old, rel=0.2)


def test_green_glass_transmits_as_its_published_extinction_says():
    # Rubin 1985: k = 1.169e-6 at 550 nm, so 6 mm transmit exp(-4 pi k L / lambda) = 85.2 % between the surfaces.
    inside = np.exp(-absorption(tinted_soda_lime("green"), 550.0) * 6e-3)
    assert inside == pytest.approx(0.852, abs=0.001)


@pytest.mark.parametrize("name", sorted(SPECTRA))
def test_no_spectrum_is_negative_or_empty(name):
    values = coefficient(SPECTRA[name], np.arange(360.0, 831.0))
    assert np.all(values >= 0.0)
    assert values.max() > 0.0
    assert SPECTRA[name].source


@pytest.mark.parametrize("name", sorted(DYES))
def test_a_dye_peaks_where_it_is_published_and_has_its_published_strength(name):
    dye = DYES[name]
    nm = np.arange(400.0, 781.0)
    values = coefficient(dye, nm)
    # Side bands may pull the peak of the sum a little; the regulation says "ca".
    assert nm[np.argmax(values)] == pytest.approx(dye.reference, abs=4.0)
    # 1 g/L in 1 cm has a tenth of E(1 %, 1 cm) as its decadic absorbance.
    decadic = coefficient(dye, dye.reference) * 0.01 / np.log(10.0)
    assert decadic == pytest.approx(dye.specific_absorbance / 10.0)


@pytest.mark.parametrize(
    # Molar mass [g/mol] and molar strength [1e3 L/(mol cm)] as the literature on each dye gives it, +-15 %.
    ("name", "mass", "molar"),
    [
        ("tartrazine", 534.4, 27.3),
        ("allura red AC", 496.4, 25.9),
        ("brilliant blue FCF", 792.9, 130.0),
        ("sunset yellow FCF", 452.4, 24.0),
    ],
)
def test_specific_and_molar_strengths_agree(name, mass, molar):
    assert DYES[name].specific_absorbance / 10.0 * mass / 1e3 == pytest.approx(molar, rel=0.15)


@pytest.mark.parametrize(
    ("name", "left", "spectrum"),
    [
        # E(1 %, 1 cm) in triolein: the peaks, then the flanks that decide the colour of the oil. What the fits leave:
        # the weak bands stand on one broad one, and lutein's three peaks and shoulder are four Gaussians.
        ("pheophytins", 25.0, {670: 683.0, 612: 109.4, 537: 130.5, 508: 144.8, 480: 50.0, 414: 1334.0, 430: 409.0}),
        ("carotenoids", 55.0, {455: 2330.0, 485: 2057.0, 470: 1656.0, 500: 894.0, 510: 264.0}),
    ],
)
def test_the_pigments_of_oil_have_the_spectra_measured_in_triolein(name, left, spectrum):
    pigment = PIGMENTS[name]
    decadic = [coefficient(pigment, nm) * 0.1 / np.log(10.0) for nm in spectrum]
    assert decadic == pytest.approx(list(spectrum.values()), abs=left)


def test_absorption_grows_in_proportion_to_the_concentration():
    def dye_only(amount):
        dyed = water(Absorber(spectrum="tartrazine", amount=amount))
        return absorption(dyed, 450.0) - absorption(water(), 450.0)

    assert dye_only(0.02) == pytest.approx(2.0 * dye_only(0.01))


def test_a_syrup_has_less_water_to_absorb():
    # 60 % sugar: 0.4 * 1286.5 / 998.2 of water.
    assert absorption(sugar_solution(0.6), 650.0) == pytest.approx(0.340 * 0.4 * 1286.5 / 998.2)


def test_a_wavelength_outside_a_spectrum_is_refused_by_the_mediums_name():
    with pytest.raises(InputError, match=r"absorption of water .*380-727\.5 nm, found 800 nm"):
        absorption(water(), 800.0)
    assert absorption(water(), 800.0, outside="hold") == absorption(water(), 727.5)


def test_a_medium_without_absorbers_absorbs_nothing():
    assert np.array_equal(absorption(AIR, [400.0, 700.0]), [0.0, 0.0])
    assert absorption(catalogue()["fused silica"], 500.0) == 0.0


def test_extinction_and_absorption_are_linked_by_four_pi_over_wavelength():
    spectrum = from_extinction([1.0, 1.0], 1e-7, [400.0, 800.0], "test")
    assert spectrum.values == pytest.approx((np.pi, np.pi / 2.0))


def test_a_sampled_spectrum_must_be_a_curve():
    with pytest.raises(ValueError, match="increasing wavelengths"):
        Sampled(wavelengths=(500.0, 400.0), values=(1.0, 1.0), source="test")
    with pytest.raises(ValueError, match="no negative absorption"):
        Sampled(wavelengths=(400.0, 500.0), values=(1.0, -1.0), source="test")


def test_an_unknown_spectrum_is_refused_by_name():
    with pytest.raises(InputError, match=r"expected one of water, .*, found unobtainium"):
        water(Absorber(spectrum="unobtainium", amount=1.0))
