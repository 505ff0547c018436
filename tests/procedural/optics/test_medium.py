from __future__ import annotations

import pytest
from pydantic import ValidationError

from glassware.core.randomness import stream
from glassware.procedural.optics.catalogue import catalogue
from glassware.procedural.optics.draw import draw_liquid
from glassware.procedural.optics.medium import AIR, Medium


@pytest.mark.parametrize("eta", [0.99, -1.0, float("nan"), float("inf")])
def test_an_index_below_one_is_refused_by_name(eta):
    with pytest.raises(ValidationError, match="medium ghost: expected a refractive index of at least 1"):
        Medium(name="ghost", eta=eta)


@pytest.mark.parametrize("value", [-1e-9, float("nan")])
def test_a_negative_absorption_is_refused_by_name(value):
    with pytest.raises(ValidationError, match="medium glow: expected an absorption of at least 0"):
        Medium(name="glow", eta=1.3, sigma_a=(0.0, value, 0.0))


def test_a_medium_needs_only_a_name_and_an_index():
    assert Medium(name="plain", eta=1.5).sigma_a == (0.0, 0.0, 0.0)
    assert AIR.eta == 1.0


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_every_medium_of_the_catalogue_survives_json(name):
    medium = catalogue()[name]
    again = Medium.model_validate_json(medium.model_dump_json())
    assert again == medium
    assert hash(again) == hash(medium)


def test_a_drawn_medium_survives_json():
    rng = stream(3, 0, "liquids")
    for _ in range(20):
        medium = draw_liquid(rng)
        assert Medium.model_validate_json(medium.model_dump_json()) == medium


def test_a_medium_read_from_json_is_checked_too():
    with pytest.raises(ValidationError, match="medium ghost"):
        Medium.model_validate_json('{"name": "ghost", "eta": 0.5}')
