"""The random area lights."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.lights import draw_lights
from glassware.procedural.surroundings.metering import irradiance
from glassware.procedural.surroundings.settings import LightSettings

SETTINGS = LightSettings()
REACH, AMBIENT = 1.1, 3.0
DARK = np.zeros((4, 8, 3), dtype=np.float32)
MANY = [draw_lights(np.random.default_rng(seed), SETTINGS, REACH, AMBIENT) for seed in range(100)]
LIGHTS = [light for drawn in MANY for light in drawn]


def test_scenes_have_none_to_three_lights():
    assert {len(drawn) for drawn in MANY} == {0, 1, 2, 3}


def test_no_point_of_a_light_is_within_the_cameras_reach():
    for light in LIGHTS:
        steps = np.linspace(-0.5, 0.5, 9)
        local = np.array([[u * light.size[0], v * light.size[1], 0.0, 1.0] for u in steps for v in steps])
        points = (local @ light.world_T_light.T)[:, :3]
        assert np.linalg.norm(points, axis=1).min() >= REACH + SETTINGS.margin
        assert points[:, 2].min() > 0.0


def test_lights_have_rigid_poses_and_look_near_the_centre():
    for light in LIGHTS:
        rotation, centre = light.world_T_light[:3, :3], light.world_T_light[:3, 3]
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) > 0.0
        hit = centre - rotation[:, 2] * centre[2] / rotation[2, 2]
        assert np.linalg.norm(hit) <= SETTINGS.aim + 1e-9


def test_each_light_adds_its_share_of_the_ambient_light():
    shares = [float(luminance(irradiance(DARK, 1.0, (light,)))) / AMBIENT for light in LIGHTS]
    # The luminance of a black body's colour is 1 to the digits of the colour matrix.
    assert min(shares) >= SETTINGS.share[0] * 0.999
    assert max(shares) <= SETTINGS.share[1] * 1.001
    assert max(shares) > 0.5
    assert min(shares) < 0.2


def test_lights_are_warm_to_white():
    for light in LIGHTS:
        red, _, blue = light.radiance
        assert 0.0 < blue / red < 1.1


def test_no_lights_can_be_asked_for():
    assert draw_lights(np.random.default_rng(0), LightSettings(max_count=0), REACH, AMBIENT) == ()


@pytest.mark.parametrize("bad", [{"max_count": -1}, {"temperature": (100.0, 3000.0)}, {"size": (0.0, 0.1)}])
def test_settings_out_of_range_name_the_field(bad):
    with pytest.raises(ValidationError, match=next(iter(bad))):
        LightSettings(**bad)
