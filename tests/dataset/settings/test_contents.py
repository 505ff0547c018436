from __future__ import annotations

from glassware.dataset.settings.contents import catalogue
from glassware.procedural.optics.draw import liquid_names
from glassware.procedural.props.draw import PropSettings
from glassware.procedural.props.kinds import PROP_KINDS
from glassware.procedural.surroundings.table import TableSettings
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
    PropSettings.model_validate({"kinds": list(found.props)})
    TableSettings.model_validate({"kinds": list(found.tables)})
    assert {*found.liquids, *found.mixtures} == set(liquid_names())
    assert found.glasses["lead crystal"].eta > found.glasses["fused silica"].eta
    assert found.presets == ("fast", "keypose", "standard", "syn-todd", "train")


def test_the_catalogue_prints_every_name_with_its_figures():
    text = str(catalogue())
    for name in (*catalogue().glasses, *catalogue().dyes, *CATEGORIES, *catalogue().presets, "olive oil", *PROP_KINDS):
        assert name in text
    assert "  water                     1.3330" in text.splitlines()


def test_own_media_are_in_the_catalogue_of_their_file(tmp_path):
    path = tmp_path / "media.yaml"
    path.write_text("syrup: {index: 1.43}\n", "utf-8")
    found = catalogue(path)
    assert found.own["syrup"].eta == 1.43
    assert "  syrup                     1.4300" in str(found).splitlines()
    assert not catalogue().own
