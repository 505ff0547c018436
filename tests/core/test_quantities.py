from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glassware.core.quantities import parsed_volume, volume_text


@pytest.mark.parametrize(
    ("text", "volume"),
    [("150ml", 1.5e-4), ("15 cl", 1.5e-4), ("1.5dl", 1.5e-4), ("0.15l", 1.5e-4), (".5L", 5e-4), ("1e3ml", 1e-3)],
)
def test_a_volume_has_its_unit_behind_it(text, volume):
    assert parsed_volume(text) == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["150", "ml", "-1ml", "0ml", "1 gallon", "1ml2", "", "1,5l", "nanml", 150, None, "9e999l"]
)
def test_what_is_no_volume_is_refused(text):
    with pytest.raises(ValueError, match=r"^expected a volume such as 150ml, 15cl or 0.5l, found "):
        parsed_volume(text)


@given(st.floats(1e-6, 1.0))
def test_a_shown_volume_reads_back_to_four_digits(volume):
    assert parsed_volume(volume_text(volume)) == pytest.approx(volume, rel=1e-3)
