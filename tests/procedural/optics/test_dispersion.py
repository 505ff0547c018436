from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.optics.catalogue import FUSED_SILICA, LEAD_CRYSTAL, catalogue, water
from glassware.procedural.optics.dispersion import C_LINE, D_LINE, F_LINE, Scaled, abbe_number, index
from glassware.procedural.optics.medium import AIR, Medium, eta

# Malitson 1965 and the Schott data sheets print five decimals.
FIVE_DECIMALS = 0.6e-5


@pytest.mark.parametrize(
    ("wavelength", "published"),
    # Malitson 1965, table I, computed column.
    [(404.6563, 1.46962), (486.1327, 1.46313), (546.0740, 1.46008), (656.2725, 1.45637), (1060.0, 1.44968)],
)
def test_fused_silica_has_the_indices_of_malitsons_table(wavelength, published):
    assert index(FUSED_SILICA, wavelength) == pytest.approx(published, abs=FIVE_DECIMALS)


@pytest.mark.parametrize(
    # CRC Handbook, against air at 20 degC; the formula comes from another laboratory.
    ("wavelength", "published"),
    [(656.2725, 1.33115), (589.29, 1.33299), (486.1327, 1.33712)],
)
def test_water_has_the_handbooks_indices_against_air(wavelength, published):
    assert eta(water(), wavelength) == pytest.approx(published, abs=5e-5)


def test_an_array_of_wavelengths_keeps_its_shape_and_order():
    nm = np.array([[450.0, 550.0], [600.0, 650.0]])
    result = eta(water(), nm)
    assert result.shape == nm.shape
    assert result[0, 0] == eta(water(), 450.0)
    assert np.all(np.diff(result.ravel()) < 0.0)


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_the_index_falls_with_the_wavelength_over_all_of_the_visible_range(name):
    medium = catalogue()[name]
    assert medium.dispersion is not None
    low, high = medium.dispersion.valid
    nm = np.linspace(max(low, 380.0), min(high, 780.0), 200)
    values = eta(medium, nm)
    assert np.all(np.diff(values) < 0.0)
    assert np.all((values > 1.3) & (values < 1.65))


@pytest.mark.parametrize("name", sorted(catalogue()))
@pytest.mark.parametrize("side", [0, 1])
def test_a_wavelength_outside_the_valid_range_is_refused_by_name(name, side):
    medium = catalogue()[name]
    assert medium.dispersion is not None
    outside = medium.dispersion.valid[side] + (-1.0, 1.0)[side]
    with pytest.raises(InputError, match=f"index of {name}.*expected a wavelength in"):
        eta(medium, [550.0, outside])


def test_not_a_number_is_not_a_wavelength():
    with pytest.raises(InputError, match="water"):
        eta(water(), float("nan"))


def test_holding_uses_the_nearest_valid_wavelength():
    medium = catalogue()["ethanol"]
    assert eta(medium, 360.0, outside="hold") == eta(medium, 476.5)
    assert eta(medium, 550.0, outside="hold") == eta(medium, 550.0)


def test_a_medium_without_a_formula_has_one_index():
    assert np.array_equal(eta(AIR, [400.0, 5000.0]), [1.0, 1.0])


def test_the_abbe_number_is_that_of_the_data_sheet():
    # LLF1: n_d 1.54814, V_d 45.75.
    assert abbe_number(LEAD_CRYSTAL) == pytest.approx(45.75, abs=0.006)
    n_d, n_f, n_c = index(LEAD_CRYSTAL, [D_LINE, F_LINE, C_LINE])
    assert n_d == pytest.approx(1.54814, abs=FIVE_DECIMALS)
    assert abbe_number(LEAD_CRYSTAL) == pytest.approx((n_d - 1.0) / (n_f - n_c))


def test_a_scaled_formula_keeps_the_abbe_number_of_its_base():
    scaled = Scaled(base=FUSED_SILICA, factor=1.2, source="test")
    assert abbe_number(scaled) == pytest.approx(abbe_number(FUSED_SILICA))
    assert index(scaled, 600.0) - 1.0 == pytest.approx(1.2 * (index(FUSED_SILICA, 600.0) - 1.0))


def test_a_medium_whose_index_contradicts_its_formula_is_refused():
    with pytest.raises(ValueError, match=r"medium odd: expected the index of its formula at the d line, 1\.458"):
        Medium(name="odd", eta=1.5, dispersion=FUSED_SILICA)
