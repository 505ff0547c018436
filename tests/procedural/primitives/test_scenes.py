from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball, box_mesh
from glassware.procedural.primitives.scenes import block, board, camera, matte, metered, scene
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import irradiance

GLASS = Medium(name="glass", eta=1.5)


def test_a_camera_sees_its_target_in_the_middle_and_up_as_up():
    made = camera((0.4, -0.3, 0.5), (0.1, 0.0, 0.05), width=64, height=48)
    for point, pixel in (((0.1, 0.0, 0.05), (31.5, 23.5)), ((0.1, 0.0, 0.15), (31.5, None))):
        local = np.linalg.inv(made.world_T_camera) @ [*point, 1.0]
        x, y = (made.K @ local[:3])[:2] / local[2]
        assert x == pytest.approx(pixel[0])
        assert y == pytest.approx(pixel[1]) if pixel[1] else y < 23.5


def test_a_constant_environment_has_one_radiance_and_the_irradiance_of_pi_of_it():
    environment = ConstantEnvironment(radiance=(1.0, 2.0, 0.5), strength=3.0)
    pixels = bake_environment(environment)
    assert (pixels == np.array([1.0, 2.0, 0.5], np.float32)).all()
    # Half a sphere by the cosine: pi.
    expected = 3.0 * np.pi * np.array([1.0, 2.0, 0.5])
    assert irradiance(pixels, environment.strength, ()) == pytest.approx(expected, rel=1e-6)
    with pytest.raises(ValidationError):
        ConstantEnvironment(radiance=(1.0, -1.0, 1.0))


def test_a_metered_scene_shows_a_grey_card_as_its_reflectance():
    made = metered(scene([ball(0.02, GLASS, (0.0, 0.0, 0.03))], [camera((0.0, 0.5, 0.5))]))
    # Under the radiance 1 a diffuse surface of reflectance R has the radiance R.
    assert made.cameras[0].exposure == pytest.approx(1.0, rel=1e-6)


def test_a_board_has_its_top_at_zero_and_a_block_its_place():
    table = board((0.5, 0.4, 0.02))
    assert table.mesh.bounds[1, 2] == 0.0
    assert table.mesh.uv is not None
    assert np.array_equal(table.mesh.uv, table.mesh.vertices[:, :2])
    prop = block(box_mesh((0.1, 0.1, 0.1), "cube", (0.0, 0.2, 0.06)), matte(), id=7)
    assert prop.mesh.bounds.mean(0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-8)
    assert prop.world_T_object[:3, 3] == pytest.approx([0.0, 0.2, 0.06], abs=1e-7)
