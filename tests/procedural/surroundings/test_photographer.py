"""Exposure keeps the highlights of the table."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.images import KNEE
from glassware.core.pose import aimed_frame
from glassware.procedural.description.surroundings import AreaLight, ConstantEnvironment
from glassware.procedural.primitives import scenes
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import exposure
from glassware.procedural.surroundings.photographer import camera_exposure

EVEN = ConstantEnvironment(radiance=(1.0, 1.0, 1.0))


@pytest.mark.parametrize(("reflectance", "shown"), [(0.18, 0.18), (0.6, 0.6), (0.95, KNEE)])
def test_a_table_in_even_light_is_shown_as_its_reflectance_up_to_the_knee(reflectance: float, shown: float) -> None:
    board = scenes.board((1.0, 1.0, 0.02), scenes.matte((reflectance, reflectance, reflectance)))
    found, light = camera_exposure(board, EVEN, bake_environment(EVEN), ())
    assert found * reflectance * light[0] / np.pi == pytest.approx(shown, rel=1e-3)


def test_a_lamp_over_the_table_s_edge_lowers_the_exposure_of_a_pale_table_alone() -> None:
    pose = aimed_frame(np.array([0.4, 0.0, 0.5]), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0]), 0.0)
    lamp = AreaLight(world_T_light=pose, size=(0.1, 0.1), radiance=(60.0, 60.0, 60.0))
    for reflectance, lower in ((0.05, False), (0.6, True)):
        board = scenes.board((1.0, 1.0, 0.02), scenes.matte((reflectance, reflectance, reflectance)))
        found, light = camera_exposure(board, EVEN, bake_environment(EVEN), (lamp,))
        assert (found < 0.99 * exposure(light)) == lower
