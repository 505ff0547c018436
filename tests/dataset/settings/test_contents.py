from __future__ import annotations

from glassware.dataset.settings.contents import catalogue
from glassware.procedural.optics.draw import liquid_names
from glassware.procedural.vessels.settings import CATEGORIES, VesselSettings


def test_the_catalogue_has_what_settings_can_name():
    found = catalogue()
    VesselSettings.model_validate(
        {
            "categories": list(found.families),
            "glasses": list(found.glasses),
            "liquids": [*found.liquids, *found.mixtures],
            "dyes": list(found.dyes),
        }
    )
    assert tuple(found.families) == CATEGORIES
    assert {*found.liquids, *found.mixtures} == set(liquid_names())
    assert found.glasses["lead crystal"].eta > found.glasses["fused silica"].eta
    assert found.presets == ("fast", "standard", "syn-todd")


def test_the_catalogue_prints_every_name_with_its_figures():
    text = str(catalogue())
    for name in (*catalogue().glasses, *catalogue().dyes, *CATEGORIES, *catalogue().presets, "olive oil"):
        assert name in text
    assert "  water                     1.3330" in text.splitlines()
