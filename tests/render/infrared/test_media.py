"""Media at the wavelength of a depth camera's projector, against measurements that reach there."""

from __future__ import annotations

import math

import pytest

from glassware.procedural.optics.catalogue import catalogue, dyed, soda_lime, water
from glassware.procedural.optics.medium import eta
from glassware.render.infrared.media import infrared_absorption, infrared_index

NM, UM2 = 850.0, 0.85**2


@pytest.mark.parametrize(
    ("name", "expected", "apart"),
    [
        # Rheims et al. 1997, Meas. Sci. Technol. 8, 601, 20 degC, measured up to 1050 nm.
        ("glycerol", 1.45797 + 0.00598 / UM2 - 0.00036 / UM2**2, 3e-4),
        # Corning 7740 has 1.465 at 850 nm (CVI Melles Griot, material properties).
        ("borosilicate glass 3.3", 1.465, 1e-3),
        # Malitson 1965, by its formula.
        ("fused silica", 1.4525, 1e-4),
    ],
)
def test_indices_follow_their_formulas_past_the_visible_range(name, expected, apart):
    assert infrared_index(catalogue()[name], NM) == pytest.approx(expected, abs=apart)


def test_indices_fall_towards_the_infrared_and_are_those_of_the_formula_within_its_range():
    for medium in catalogue().values():
        falls = medium.eta - infrared_index(medium, NM)
        assert 0.003 < falls < 0.02
        if medium.dispersion is not None and medium.dispersion.valid[1] >= NM:
            assert infrared_index(medium, NM) == pytest.approx(float(eta(medium, NM)), rel=1e-9)


def test_water_and_the_iron_in_glass_absorb_and_dyes_do_not():
    assert infrared_absorption(water(), NM) == pytest.approx(4.33)
    for dye in ("tartrazine", "allura red AC", "brilliant blue FCF"):
        assert infrared_absorption(dyed(water(), dye, 0.01), NM) == pytest.approx(4.33, abs=0.01)
    # Window glass has k = 3.15e-6 there, low-iron glass 7.1e-7 (Rubin 1985).
    for iron, k in ((1.0, 3.15e-6), (0.0, 7.099e-7), (0.5, 0.5 * (3.15e-6 + 7.099e-7))):
        assert infrared_absorption(soda_lime(iron), NM) == pytest.approx(4 * math.pi * k / (NM * 1e-9), rel=1e-3)
    # Continuous where the tables meet.
    for medium in (water(), soda_lime(1.0)):
        steps = [infrared_absorption(medium, nm) for nm in (779.9, 780.1)]
        assert max(steps) / min(steps) < 1.005
