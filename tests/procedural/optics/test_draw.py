from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chisquare

from glassware.core.randomness import stream
from glassware.procedural.optics.catalogue import glasses
from glassware.procedural.optics.draw import LIQUID_WEIGHTS, draw_dyes, draw_glass, draw_liquid
from glassware.procedural.optics.dyes import DYES

DRAWS = 800
#: Every medium of walls, equally likely.
GLASS_WEIGHTS = {medium.name: 1.0 / len(glasses()) for medium in glasses()}
# A right sampler fails a chi-square test at this level once in a thousand seeds; the seed is fixed.
SIGNIFICANCE = 1e-3


@pytest.fixture(scope="module")
def drawn_glasses():
    rng = stream(11, 0, "vessels")
    return [draw_glass(rng, GLASS_WEIGHTS) for _ in range(DRAWS)]


@pytest.fixture(scope="module")
def drawn_liquids():
    rng = stream(11, 0, "liquids")
    return [draw_liquid(rng) for _ in range(DRAWS)]


def test_the_same_stream_draws_the_same_media():
    first = [draw_liquid(stream(5, s, "liquids")) for s in range(10)]
    assert first == [draw_liquid(stream(5, s, "liquids")) for s in range(10)]
    assert len({m.name for m in first}) > 1


def test_glasses_come_as_often_as_their_weights_say(drawn_glasses):
    counts = [sum(m.name == name for m in drawn_glasses) for name in GLASS_WEIGHTS]
    expected = np.array(list(GLASS_WEIGHTS.values())) * DRAWS
    assert sum(counts) == DRAWS
    assert chisquare(counts, expected).pvalue > SIGNIFICANCE


def test_liquids_come_as_often_as_their_weights_say(drawn_liquids):
    def kind(medium):
        dyed = "dyed " if any(a.spectrum in DYES for a in medium.absorbers) else ""
        return dyed + ("sugar solution" if "sugar" in medium.name else medium.name.split(" with ")[0])

    counts = [sum(kind(m) == name for m in drawn_liquids) for name in LIQUID_WEIGHTS]
    assert sum(counts) == DRAWS
    assert chisquare(counts, np.array(list(LIQUID_WEIGHTS.values())) * DRAWS).pvalue > SIGNIFICANCE


def test_the_weights_of_liquids_are_shares():
    assert sum(LIQUID_WEIGHTS.values()) == pytest.approx(1.0)


def test_every_drawn_medium_is_physical(drawn_glasses, drawn_liquids):
    for medium in (*drawn_glasses, *drawn_liquids):
        assert 1.32 < medium.eta < 1.60
        assert 25.0 < medium.abbe < 70.0
        assert np.isfinite(medium.sigma_a).all()
        assert min(medium.sigma_a) >= 0.0
        assert medium.source


def test_every_drawn_liquid_can_have_a_meniscus(drawn_liquids):
    assert all(m.surface_tension and m.density and m.contact_angle is not None for m in drawn_liquids)


def test_dyes_stay_within_the_legal_limit():
    rng = stream(2, 0, "dyes")
    for _ in range(300):
        dyes = draw_dyes(rng)
        assert len({d.spectrum for d in dyes}) == len(dyes)
        for dye in dyes:
            low, high = DYES[dye.spectrum].concentrations
            assert low <= dye.amount <= high <= 0.1  # 100 mg/L, Regulation (EU) 1129/2011


def test_colours_vary(drawn_liquids):
    dyed = np.array([m.sigma_a for m in drawn_liquids if "mg/L" in m.name])
    strongest = np.bincount(np.argmax(dyed, axis=1), minlength=3)
    assert np.all(strongest > 0.05 * len(dyed))
