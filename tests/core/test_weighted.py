from __future__ import annotations

import pytest
from pydantic import TypeAdapter, ValidationError

from glassware.core.weighted import Weighted, check_names, weights_of

ADAPTER = TypeAdapter(Weighted)


@pytest.mark.parametrize(
    ("given", "weights"),
    [
        ("water", {"water": 1.0}),
        (["water", "olive oil"], {"water": 1.0, "olive oil": 1.0}),
        ({"water": 3, "olive oil": 0.5}, {"water": 3.0, "olive oil": 0.5}),
        (("water=3", "olive oil = 0.5"), {"water": 3.0, "olive oil": 0.5}),
    ],
)
def test_a_list_a_mapping_and_a_command_line_say_the_same(given, weights):
    assert weights_of(ADAPTER.validate_python(given)) == weights


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ({"water": 0}, "expected a weight above 0 for water, found '0'"),
        ({"water": "much"}, "expected a number as the weight of 'water', found 'much'"),
        ({"water": True}, "expected a number as the weight of 'water', found True"),
        (["water=inf"], "expected a weight above 0 for water, found 'inf'"),
        (["water", "water=2"], "expected each name once, found 'water' twice"),
        ([], "expected at least 1 item, found 0"),
        ({}, "expected at least 1 item, found 0"),
        ([3], "Input should be a valid string"),
    ],
)
def test_weights_that_are_none_are_refused(given, line):
    with pytest.raises(ValidationError) as error:
        ADAPTER.validate_python(given)
    assert line in str(error.value)


def test_all_unknown_names_are_said_with_the_nearest_known_ones():
    line = r"^expected one of water, ethanol, found 'watr' \(is it water\?\), 'mud', 'ethanoll' \(is it ethanol\?\)$"
    with pytest.raises(ValueError, match=line):
        check_names(["watr", "water", "mud", "ethanoll"], ["water", "ethanol"])
    check_names(["water"], ["water", "ethanol"])
