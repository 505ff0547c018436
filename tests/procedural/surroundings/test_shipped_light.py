"""The environment maps of the package: real light in half of the scenes, and nothing else of them changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.core.randomness import stream
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.hdri import usable_hdris
from glassware.procedural.surroundings.photometry import photometry
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.procedural.surroundings.shipped_light import is_shipped_by_day, shipped_maps, with_shipped_light
from glassware.procedural.surroundings.skies import draw_sky

REPOSITORY = Path(__file__).resolve().parents[3]


def test_eight_maps_ship_with_their_licence_and_need_no_remark() -> None:
    maps = shipped_maps()
    assert len(maps) == 8
    good, findings = usable_hdris(maps[0].parent)
    assert (good, findings) == (maps, ())
    assert "CC0 1.0" in (maps[0].parent / "LICENSE.txt").read_text("utf-8")
    assert '"maps/*.exr", "maps/LICENSE.txt"' in (REPOSITORY / "pyproject.toml").read_text("utf-8")


def test_the_share_decides_and_a_file_of_the_user_stays() -> None:
    sky, settings = draw_sky(np.random.default_rng(0), 0.0047), EnvironmentSettings()
    drawn = [with_shipped_light(stream(1, i, "x"), settings, sky, shipped_maps()[:1]) for i in range(40)]
    found = [item for item in drawn if isinstance(item, PictureEnvironment)]
    assert 10 < len(found) < 30  # a share of a half: five standard deviations are 16
    assert {item.asset.licence for item in found} == {"CC0-1.0"}
    never = EnvironmentSettings(shipped_share=0.0)
    always = EnvironmentSettings(shipped_share=1.0)
    assert with_shipped_light(stream(1, 0, "x"), never, sky, shipped_maps()) is sky
    own = PictureEnvironment(asset=asset(shipped_maps()[0]))
    assert with_shipped_light(stream(1, 0, "x"), always, own, shipped_maps()) is own


@pytest.mark.parametrize("path", shipped_maps(), ids=lambda path: path.stem)
def test_maps_are_as_bright_as_the_places_that_they_show(path) -> None:
    sky = draw_sky(np.random.default_rng(0), 0.0047)
    environment = with_shipped_light(stream(2, 0, "x"), EnvironmentSettings(shipped_share=1.0), sky, (path,))
    klx = 1e-3 * photometry(environment, ()).environment_illuminance
    low, high = (0.2, 2.0) if path.stem in ("interior", "studio") else (0.005, 60.0)
    assert low <= klx <= high


def test_all_but_the_light_of_a_seed_stays_as_it_is() -> None:
    plain, lit = (
        draw_scene(
            SceneSettings(
                vessel_count=(2, 2),
                prop_count=(2, 2),
                environment=EnvironmentSettings(room_share=0.0, shipped_share=share),
            ),
            5,
            3,
        )
        for share in (0.0, 1.0)
    )
    assert isinstance(lit.environment, PictureEnvironment)
    assert plain.environment.kind == "sky"
    kept = {"table", "vessels", "props"}
    assert plain.model_dump_json(include=kept) == lit.model_dump_json(include=kept)
    for before, after in zip(plain.vessels, lit.vessels, strict=True):
        np.testing.assert_array_equal(before.interfaces[0].mesh.vertices, after.interfaces[0].mesh.vertices)
    for one, two in zip(plain.cameras, lit.cameras, strict=True):
        np.testing.assert_array_equal(one.world_T_camera, two.world_T_camera)


def test_maps_of_rooms_and_nights_are_not_by_day(tmp_path) -> None:
    by_day = {path.stem for path in shipped_maps() if is_shipped_by_day(PictureEnvironment(asset=asset(path)))}
    assert by_day == {"city", "courtyard", "forest", "sunrise", "sunset"}
    # A file of the user's own of the same name is none of them.
    own = tmp_path / "city.exr"
    own.write_bytes(shipped_maps()[0].read_bytes())
    assert not is_shipped_by_day(PictureEnvironment(asset=asset(own)))
