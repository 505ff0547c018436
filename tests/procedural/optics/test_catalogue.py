from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.optics.catalogue import (
    BOROSILICATE,
    PET,
    catalogue,
    glasses,
    liquids,
    olive_oil,
    soda_lime,
    sodium_index,
    sugar_solution,
    tinted_soda_lime,
    water,
)
from glassware.procedural.optics.dispersion import index

# Published n_d with the spread that the source itself gives or that its digits leave; none of these is the paper that
# the formula comes from, except for the Schott glasses, whose n_d is printed apart from the coefficients.
N_D = {
    "soda-lime glass": (1.52, 0.005),  # EN 572-1: 1.5 (float glass); Pilkington 1.52
    "borosilicate glass 3.3": (1.473, 0.002),  # DURAN (ISO 3585): n_d 1.473; BOROFLOAT 33: 1.4714
    "fused silica": (1.45846, 1e-5),  # Heraeus Suprasil data sheet, 20 degC
    "lead crystal": (1.54814, 1e-5),
    "heavy lead crystal": (1.58144, 1e-5),
    "acrylic": (1.491, 0.002),  # Sultanova et al. 2009
    "polycarbonate": (1.586, 0.002),  # Makrolon data sheets, ISO 489
    "PET": (1.575, 0.01),  # amorphous, ISO 489; rises with crystallinity
}
V_D = {
    "fused silica": (67.8, 0.1),
    "borosilicate glass 3.3": (65.4, 0.3),  # BOROFLOAT 33 data sheet, V_e
    "lead crystal": (45.75, 0.01),
    "heavy lead crystal": (40.85, 0.01),
    "acrylic": (58.0, 2.0),  # handbooks: 57.2-59.2
    "polycarbonate": (29.5, 2.0),  # handbooks: 29-30; the one-term fit has 27.9
    "water": (55.7, 0.2),  # from the handbook's n_C, n_D, n_F
}
# n_D at 20 degC of liquids.
N_SODIUM = {
    "water": (1.33299, 3e-5),
    "ethanol": (1.3611, 6e-4),  # CRC Handbook; 0.3 % of water changes it by 3e-4
    "glycerol": (1.4722, 1.2e-3),  # Rheims et al. 1997, 25 degC; 1 % of water lowers it by 1.5e-3
    "olive oil": (1.4691, 1.4e-3),  # Codex CXS 33-1981
}


@pytest.mark.parametrize("name", sorted(N_D))
def test_a_solid_has_the_published_index(name):
    value, tolerance = N_D[name]
    assert catalogue()[name].eta == pytest.approx(value, abs=tolerance)


@pytest.mark.parametrize("name", sorted(V_D))
def test_a_medium_has_the_published_abbe_number(name):
    value, tolerance = V_D[name]
    assert catalogue()[name].abbe == pytest.approx(value, abs=tolerance)


@pytest.mark.parametrize("name", sorted(N_SODIUM))
def test_a_liquid_has_the_published_index_at_the_sodium_line(name):
    value, tolerance = N_SODIUM[name]
    assert sodium_index(catalogue()[name]) == pytest.approx(value, abs=tolerance)


def test_the_fit_of_borosilicate_passes_through_the_data_sheet():
    # BOROFLOAT 33: n_g, n_F', n_e, n_D, n_C', n_C; and the principal dispersion, which it prints apart.
    nm = [435.8, 479.9, 546.1, 589.3, 643.8, 656.3]
    n = index(BOROSILICATE, nm)
    assert np.abs(n - [1.48015, 1.47676, 1.47311, 1.47133, 1.46953, 1.46916]).max() < 1.2e-5
    n_f, n_c = index(BOROSILICATE, [486.13, 656.27])
    assert n_f - n_c == pytest.approx(71.4e-4, abs=1e-4)
    assert (n[2] - 1.0) / (n[1] - n[4]) == pytest.approx(65.41, abs=0.2)


def test_the_fit_of_pet_passes_through_the_measured_indices():
    # Zhang et al. 2020 at 400, 450, ... 800 nm; the fit states 9.4e-4 as its largest residual.
    measured = [1.61027, 1.59247, 1.58111, 1.57333, 1.56811, 1.56368, 1.56052, 1.55817, 1.55533]
    assert np.abs(index(PET, np.arange(400.0, 801.0, 50.0)) - measured).max() < 9.5e-4


@pytest.mark.parametrize(
    # ICUMSA's table at whole tens is what the formula is built from; these lie between its points and test the
    # interpolation: 5, 15, 25 and 45 % (density from NBS Circular 440).
    ("sugar", "n_sodium", "density"),
    [(0.05, 1.34026, 1017.8), (0.15, 1.35568, 1059.2), (0.25, 1.37233, 1103.5), (0.45, 1.40987, 1202.4)],
)
def test_a_sugar_solution_follows_the_international_table(sugar, n_sodium, density):
    medium = sugar_solution(sugar)
    assert sodium_index(medium) == pytest.approx(n_sodium, abs=3e-4)
    assert medium.density == pytest.approx(density, abs=1.0)


def test_a_sugar_solution_without_sugar_is_water():
    empty, pure = sugar_solution(0.0), water()
    assert empty.eta == pytest.approx(pure.eta, abs=2e-6)
    assert empty.sigma_a == pytest.approx(pure.sigma_a)


@pytest.mark.parametrize("sugar", [-0.01, 0.61, float("nan")])
def test_more_sugar_than_the_table_has_is_refused(sugar):
    with pytest.raises(InputError, match="sugar solution"):
        sugar_solution(sugar)


def test_iron_and_tints_outside_the_data_are_refused():
    with pytest.raises(InputError, match="iron"):
        soda_lime(1.5)
    with pytest.raises(InputError, match="green, bronze or grey"):
        tinted_soda_lime("pink")


def test_every_medium_states_its_source_and_density():
    for medium in (*glasses(), *liquids()):
        assert medium.source
        assert medium.dispersion is not None
        assert medium.dispersion.source
        assert medium.density is not None
        assert 700.0 < medium.density < 4000.0


def test_every_liquid_has_what_its_meniscus_needs():
    for medium in liquids():
        assert medium.surface_tension is not None
        assert 0.02 < medium.surface_tension < 0.08
        assert medium.contact_angle is not None
        assert 0.0 <= medium.contact_angle < np.pi / 2


def test_names_in_the_catalogue_are_unique():
    assert len(catalogue()) == len(glasses()) + len(liquids())


def test_more_pigment_makes_an_oil_darker():
    pale, deep = olive_oil(0.002, 0.002), olive_oil(0.02, 0.012)
    assert all(d > p for d, p in zip(deep.sigma_a, pale.sigma_a, strict=True))
