"""Lengths, angles and volumes with their units."""

from __future__ import annotations

import math
from typing import Annotated

import pytest
from pydantic import Field, ValidationError

from glassware.core.model import Model, Ordered
from glassware.core.units import ANGLE, Angle, Length, angle, degrees, dimension_of, length, volume, volume_text


@pytest.mark.parametrize(
    ("text", "metres"),
    [("0.4m", 0.4), ("12cm", 0.12), ("55mm", 0.055), ("35 mm", 0.035), ("15um", 15e-6), ("1e-1m", 0.1), (".5m", 0.5)],
)
def test_a_length_is_the_number_that_is_written_in_metres(text, metres):
    assert length(text) == metres


@pytest.mark.parametrize(
    ("text", "radians"), [("90deg", math.pi / 2), ("180 deg", math.pi), ("30°", math.radians(30)), ("0.5rad", 0.5)]
)
def test_an_angle_is_in_radians(text, radians):
    assert angle(text) == pytest.approx(radians, rel=1e-15)
    assert angle("-90deg") == -math.pi / 2


@pytest.mark.parametrize("value", [0.4, 3, "0.4", "1e-4", "12", "1e5", "nan", "", "wide", None, [1]])
def test_what_has_no_unit_is_left_to_others(value):
    assert length(value) is value
    assert angle(value) is value


@pytest.mark.parametrize("text", ["12ft", "0x10", "3,5m", "1 2m", "12CM", "1e9999m", "30deg"])
def test_an_unknown_unit_is_named_with_those_that_are_known(text):
    with pytest.raises(ValueError, match=r"expected a length in m, cm or mm, such as 0\.4m.*, found '"):
        length(text)


def test_a_unit_of_something_else_says_of_what():
    with pytest.raises(ValueError, match="found '30deg', an angle"):
        length("30deg")
    with pytest.raises(ValueError, match=r"expected an angle in deg or rad, .* found '5cm', a length"):
        angle("5cm")


class _Sizes(Model):
    plain: float = 1.0
    side: Length = Field(default=0.1, gt=0.0, le=1.0)
    turn: Annotated[tuple[Annotated[float, Field(le=math.pi), ANGLE], Angle], Ordered] | None = None


def test_fields_know_what_they_measure():
    found = {name: dimension_of(field) for name, field in _Sizes.model_fields.items()}
    assert found == {"plain": None, "side": "length", "turn": "angle"}


def test_limits_hold_in_the_unit_of_the_settings():
    made = _Sizes.model_validate({"side": "5cm", "turn": ["30deg", 1]})
    assert made.side == 0.05
    assert made.turn == (pytest.approx(math.pi / 6), 1.0)
    with pytest.raises(ValidationError, match="expected less than or equal to 1 m, found '120cm'"):
        _Sizes.model_validate({"side": "120cm"})
    with pytest.raises(ValidationError, match="found '5cm', a length"):
        _Sizes.model_validate({"turn": ["5cm", 1]})


def test_a_limit_that_is_broken_is_said_with_its_unit():
    with pytest.raises(ValidationError, match=r"expected less than or equal to 3\.14159 rad \(180deg\), found 45 rad"):
        _Sizes(turn=(45.0, 50.0))
    with pytest.raises(ValidationError, match="expected greater than 0 m, found -1 m"):
        _Sizes(side=-1.0)
    with pytest.raises(ValidationError, match="finite number"):
        _Sizes(side=math.inf)
    with pytest.raises(ValidationError, match="valid number"):
        _Sizes.model_validate({"side": "wide"})


def test_angles_are_shown_in_degrees():
    assert degrees(math.pi / 6) == "30deg"
    assert degrees(0.01) == "0.573deg"


@pytest.mark.parametrize(
    ("text", "cubic_metres"),
    [("150ml", 1.5e-4), ("15 cl", 1.5e-4), ("1.5dl", 1.5e-4), ("0.15l", 1.5e-4), (".5L", 5e-4), ("1e3mL", 1e-3)],
)
def test_a_volume_has_its_unit_behind_it(text, cubic_metres):
    assert volume(text) == cubic_metres


@pytest.mark.parametrize(
    "value", ["150", "ml", "-1ml", "0ml", "1 gallon", "1ml2", "", "1,5l", "nanml", 150, None, "5cm"]
)
def test_what_is_no_volume_is_refused(value):
    with pytest.raises(ValueError, match=r"^expected a volume in ml, cl or l, such as 150ml or 0.5l, found "):
        volume(value)


@pytest.mark.parametrize(
    ("cubic_metres", "text"), [(2.5e-4, "250ml"), (1.5e-3, "1.5l"), (1e-3, "1l"), (3.14159e-5, "31.42ml")]
)
def test_a_volume_is_shown_in_four_digits(cubic_metres, text):
    assert volume_text(cubic_metres) == text
    assert volume(text) == pytest.approx(cubic_metres, rel=1e-3)
