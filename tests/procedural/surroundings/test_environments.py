"""Which surroundings a scene gets."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest

from glassware.core.errors import InputError
from glassware.procedural.description.surroundings import Environment, PictureEnvironment, RoomEnvironment
from glassware.procedural.surroundings.environments import bake_environment, draw_environment
from glassware.procedural.surroundings.photometry import photometry
from glassware.procedural.surroundings.room_map import bake_room
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.procedural.surroundings.sphere import solid_angles


def drawn(seed: int, **settings):
    return draw_environment(np.random.default_rng(seed), EnvironmentSettings(**settings))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for k in range(3):
        channels = {name: np.full((4, 8), k + 1.0, np.float32) for name in "RGB"}
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        with OpenEXR.File(header, channels) as file:
            file.write(str(tmp_path / f"{k}.exr"))
    return tmp_path


def _file(environment: Environment) -> str:
    assert isinstance(environment, PictureEnvironment)
    return environment.asset.source


def test_rooms_and_skies_come_in_their_shares():
    kinds = [drawn(seed).kind for seed in range(200)]
    # 0.7 of 200, four standard deviations of 6.5.
    assert abs(kinds.count("room") - 140) <= 26
    assert set(kinds) == {"room", "sky"}
    assert {drawn(seed, room_share=1.0).kind for seed in range(20)} == {"room"}


def test_a_folder_gives_its_files(folder):
    chosen = {_file(drawn(seed, hdri_dir=folder)) for seed in range(40)}
    assert chosen == {"0.exr", "1.exr", "2.exr"}
    mixed = {drawn(seed, hdri_dir=folder, hdri_share=0.5).kind for seed in range(40)}
    assert mixed == {"picture", "room", "sky"}


def test_a_file_is_baked_as_it_is(folder):
    environment = drawn(0, hdri_dir=folder)
    level = float(_file(environment)[0]) + 1.0
    np.testing.assert_array_equal(bake_environment(environment), np.full((4, 8, 3), level))


def test_a_file_of_unknown_unit_is_scaled_to_the_light_of_a_room(folder):
    # The maps are even: as bright below as above, so not outdoors. EN 12464-1: 200 to 1000 lx.
    environments = [drawn(seed, hdri_dir=folder) for seed in range(30)]
    levels = [photometry(environment, ()).illuminance for environment in environments]
    assert min(levels) >= 200.0 * (1 - 1e-6)
    assert max(levels) <= 1000.0 * (1 + 1e-6)
    assert max(levels) > 2.0 * min(levels)
    assert drawn(0, hdri_dir=folder, hdri_calibrated=True).strength == 1.0


def test_a_file_with_a_sky_is_scaled_to_daylight(tmp_path):
    sky = np.full((64, 128, 3), 0.1, np.float32)
    sky[:32] = 2.0
    sunny = sky.copy()
    sunny[10, 20] = 3e4
    for pixels, least, most in ((sky, 5e3, 25e3), (sunny, 45e3, 110e3)):
        assert cv2.imwrite(str(tmp_path / "sky.hdr"), pixels)
        levels = [photometry(drawn(seed, hdri_dir=tmp_path), ()).illuminance for seed in range(5)]
        assert least * (1 - 1e-6) <= min(levels) < max(levels) <= most * (1 + 1e-6)


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="a folder of environment maps"):
        drawn(0, hdri_dir=tmp_path / "none")


def test_rotation_and_strength_are_left_to_the_renderer():
    environment = drawn(0, room_share=1.0)
    changed = environment.model_copy(update={"rotation": 1.0, "strength": 3.0})
    baked = bake_environment(changed, 16)
    np.testing.assert_array_equal(baked, bake_environment(environment, 16))
    with pytest.raises(ValueError, match="read-only"):
        baked[0] = 0.0


def test_procedural_maps_are_softened_without_a_seam_and_keep_their_light():
    environment = drawn(0, room_share=1.0)
    assert isinstance(environment, RoomEnvironment)
    sharp, soft = bake_room(environment, 128), bake_environment(environment, 128)
    # The blur of a row that is turned is the turned blur: nothing happens at the seam.
    step = np.abs(np.diff(np.concatenate([soft, soft[:, :1]], axis=1), axis=1))
    assert step[:, -1].max() <= step[:, :-1].max()
    assert step.max() < np.abs(np.diff(sharp, axis=1)).max()
    # Only light that crosses from row to row, whose solid angles differ a little, changes the whole.
    weights = solid_angles(128)[:, None, None]
    np.testing.assert_allclose((weights * soft).sum((0, 1)), (weights * sharp).sum((0, 1)), rtol=2e-3)
