from __future__ import annotations

from collections import Counter

import pytest
from pydantic import ValidationError

from glassware.core.errors import InputError
from glassware.core.randomness import stream
from glassware.procedural.optics.dyes import DYES
from glassware.procedural.vessels.media import draw_media, own_media
from glassware.procedural.vessels.settings import VesselSettings

#: Draws per case, and how far a frequency may be from its weight: four standard deviations of 400 draws at one half.
DRAWS, DEVIATION = 400, 0.1


def _drawn(**settings):
    chosen = VesselSettings.model_validate(settings)
    own = own_media(chosen)
    return [draw_media(stream(5, number, "media"), chosen, "tumbler", own) for number in range(DRAWS)]


def test_glasses_and_liquids_are_drawn_by_their_weights():
    drawn = _drawn(glasses={"lead crystal": 3, "acrylic": 1}, liquids={"olive oil": 1, "30 % sugar solution": 1})
    glasses = Counter(glass.name for glass, _ in drawn)
    liquids = Counter(liquid.name for _, liquid in drawn)
    assert set(glasses) == {"lead crystal", "acrylic"}
    assert glasses["lead crystal"] / DRAWS == pytest.approx(0.75, abs=DEVIATION)
    assert set(liquids) == {"olive oil", "30 % sugar solution"}
    assert liquids["olive oil"] / DRAWS == pytest.approx(0.5, abs=DEVIATION)


def test_dyes_colour_each_liquid_but_oil_within_their_concentrations():
    drawn = _drawn(
        liquids=["water", "dyed water", "olive oil"], dyes=["erythrosine", "none"], dye_concentration=(0.01, 0.02)
    )
    for _, liquid in drawn:
        dyes = [part for part in liquid.absorbers if part.spectrum in DYES]
        assert not (dyes and liquid.name == "olive oil")
        assert all(part.spectrum == "erythrosine" and 0.01 <= part.amount <= 0.02 for part in dyes)
    coloured = sum(any(part.spectrum in DYES for part in liquid.absorbers) for _, liquid in drawn)
    assert coloured / DRAWS == pytest.approx(2 / 3 * 1 / 2, abs=DEVIATION)


def test_other_dyes_change_no_glass():
    plain, blue = (_drawn(dyes=dyes) for dyes in (None, ["brilliant blue FCF"]))
    assert [glass for glass, _ in plain] == [glass for glass, _ in blue]


def test_own_media_are_drawn_by_their_names(tmp_path):
    path = tmp_path / "media.yaml"
    path.write_text("syrup: {index: 1.43}\nmy glass: {index: 1.6}\n", "utf-8")
    drawn = _drawn(media=path, glasses="my glass", liquids={"syrup": 1, "water": 1})
    assert {glass.eta for glass, _ in drawn} == {1.6}
    assert {liquid.name for _, liquid in drawn} == {"syrup", "water"}
    wrong = VesselSettings.model_validate({"media": path, "liquids": ["sirup", "watr"]})
    line = r"^vessels.liquids: expected one of syrup, .*'sirup' \(is it syrup\?\), 'watr' \(is it water\?\)$"
    with pytest.raises(InputError, match=line):
        own_media(wrong)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"glasses": ["led crystal", "glas"]}, "found 'led crystal' (is it lead crystal?), 'glas'"),
        ({"liquids": {"watr": 2, "glycerin": 1}}, "found 'watr' (is it water?), 'glycerin' (is it glycerol?)"),
        ({"dyes": ["tartrazin"]}, "found 'tartrazin' (is it tartrazine?)"),
        ({"dyes": ["tartrazine"], "liquids": ["olive oil"]}, "dyes: expected a liquid that dissolves them"),
        ({"dye_concentration": (0.1, 0.2)}, "dye_concentration: expected dyes with it, found none"),
        ({"categories": {"stm glass": 2, "beker": 1}}, "'stm glass' (is it stem glass?), 'beker' (is it beaker?)"),
        ({"categories": "Wine glass"}, "found 'Wine glass' (is it stem glass?)"),
        ({"glasses": ["pyrex", "PMMA"]}, "'pyrex' (is it borosilicate glass 3.3?), 'PMMA' (is it acrylic?)"),
        ({"liquids": "70 % sugar solution"}, "found '70 % sugar solution'"),
    ],
)
def test_what_is_not_known_is_refused_before_anything_is_drawn(settings, words):
    with pytest.raises(ValidationError) as error:
        VesselSettings.model_validate(settings)
    assert words in str(error.value)
