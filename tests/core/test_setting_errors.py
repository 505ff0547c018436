from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.dataset.commands.render_scene import RenderScene
from glassware.dataset.settings.config import parse_request, validated
from glassware.procedural.scene.settings import SceneSettings


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"hdri_dir": "x"}, "draw: expected known settings (is it environment.hdri_dir?), found hdri_dir"),
        ({"views": 2}, "draw: expected known settings (is it cameras.views?), found views"),
        ({"sppp": 2}, "draw: expected known settings (is it picture.spp?), found sppp"),
        ({"vessels": {"catgories": ()}}, "draw: expected known settings (is it vessels.categories?), found vessels."),
        ({"placement": {"zz": 1}}, "draw: expected known settings, found placement.zz"),
        ({"vessel_count": 3}, "draw: vessel_count: expected a pair (smallest, largest), found 3"),
        ({"vessel_count": (3,)}, "draw: vessel_count: expected a pair (smallest, largest), found (3,)"),
        ({"cameras": {"slack": "ab"}}, "draw: cameras.slack: expected a pair (smallest, largest), found 'ab'"),
        ({"cameras": {"views": 2.5}}, "draw: cameras.views: expected a whole number, found 2.5"),
        (
            {"picture": {"noise": "0,05"}},
            "draw: picture.noise: expected a number, found '0,05' (with a decimal point: 0.05)",
        ),
        (
            {"cameras": {"distance": ("40,5cm", "1m")}},
            "draw: cameras.distance.0: expected a length in m, cm or mm, such as 0.4m, 12cm or 55mm, "
            "found '40,5cm' (with a decimal point: 40.5cm)",
        ),
        (
            {"vessels": {"categories": {"tumbler": "1,5"}}},
            "draw: vessels.categories: expected a number as the weight of 'tumbler', found '1,5' (with a decimal point",
        ),
        ({"cameras": 3}, "draw: cameras: expected named values (a dict), found 3"),
        ({"vessels": {"categories": ()}}, "draw: vessels.categories: expected at least 1 item, found 0"),
        ({"picture": {"denoise": "perhaps"}}, "draw: picture.denoise: expected yes or no (True or False), found "),
    ],
)
def test_a_wrong_setting_is_said_in_plain_words(settings, line):
    with pytest.raises(InputError) as error:
        validated(SceneSettings, settings, "draw")
    assert str(error.value).startswith(line)


@pytest.mark.parametrize(
    ("option", "line"),
    [
        ("--noise 0,05", "render-scene: picture.noise: expected FLOAT, found '0,05' (with a decimal point: 0.05)"),
        ("--vessel-count 1,3", "render-scene: vessel_count: expected two numbers (INT INT), found fewer values"),
        (
            "--vew 3",
            "(see --help) (is it --views?), found --vew 3",
        ),
        ("--fill-probability 1", "(is it --vessels.fill-probability?)"),
        ("--sed 1", "(is it --seed?)"),
        ("--views abc", "render-scene: cameras.views: expected INT, found 'abc'"),
        ("--vessel-count a b --views 2", "render-scene: vessel_count: expected two numbers (INT INT), found 'a b'"),
        ("--seed=1.5", "render-scene: seed: expected INT, found '1.5'"),
    ],
)
def test_a_wrong_option_is_said_with_what_was_typed(option, line):
    with pytest.raises(InputError) as error:
        parse_request(RenderScene, option.split(), "render-scene", "")
    assert line in str(error.value)


def test_all_unknown_names_are_said_at_once_with_the_nearest_known_ones():
    vessels = {"liquids": ["watr"], "dyes": ["tartrazin"], "glasses": ["glas"]}
    with pytest.raises(InputError) as error:
        validated(SceneSettings, {"vessels": vessels, "picture": {"light": "paht"}}, "draw")
    line = str(error.value)
    assert line.count("expected one of ") == 3
    for words in ("vessels.liquids: ", "'watr' (is it water?)", "'tartrazin' (is it tartrazine?)", "(is it path?)"):
        assert words in line
    with pytest.raises(InputError) as error:
        validated(SceneSettings, {"vessls": {}, "cameras": {"viewz": 2}}, "draw")
    said = str(error.value)
    assert "cameras.viewz (is it cameras.views?)" in said
    assert "vessls (is it vessels?)" in said
    with pytest.raises(InputError) as error:
        parse_request(RenderScene, ["--veiws", "3", "--colour", "blue"], "render-scene", "")
    assert str(error.value).endswith("found --veiws (is it --views?), --colour")
