from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.mesh import as_trimesh
from glassware.procedural.description.scene import liquid_solid
from glassware.procedural.profiles.liquid import (
    RIM_MARGIN,
    brimful_volume,
    highest_contact,
    level_of_fill,
    level_of_volume,
    volume_below,
)

CYLINDER = np.array([[0.0, 0.01], [0.03, 0.01], [0.03, 0.11]])
CONE = np.array([[0.0, 0.0], [0.05, 0.1]])


def test_a_cylinder_holds_base_times_height():
    assert volume_below(CYLINDER, 0.06) == pytest.approx(np.pi * 0.03**2 * 0.05, rel=1e-12)
    assert brimful_volume(CYLINDER) == pytest.approx(np.pi * 0.03**2 * 0.1, rel=1e-12)
    assert volume_below(CYLINDER, 0.01) == 0.0
    assert volume_below(CYLINDER, 0.0) == 0.0


def test_a_cone_holds_a_third_of_base_times_height():
    assert volume_below(CONE, 0.04) == pytest.approx(np.pi * 0.02**2 * 0.04 / 3.0, rel=1e-12)
    # An eighth of a cone's volume reaches to half its height.
    assert level_of_fill(CONE, 0.125) == pytest.approx(0.05, abs=1e-10)


def test_a_hemisphere_holds_a_spherical_cap():
    angle = np.linspace(-np.pi / 2, 0.0, 4001)
    bowl = 0.06 * np.stack([np.cos(angle), 1.0 + np.sin(angle)], axis=-1)
    h = 0.02
    assert volume_below(bowl, h) == pytest.approx(np.pi * h**2 * (3 * 0.06 - h) / 3.0, rel=1e-5)


@pytest.mark.parametrize("fill", [0.01, 0.3, 0.77, 0.9])
def test_level_and_volume_are_each_others_inverse(fill):
    level = level_of_fill(CYLINDER, fill)
    assert level == pytest.approx(0.01 + 0.1 * fill, abs=1e-10)
    assert level_of_volume(CYLINDER, volume_below(CYLINDER, level)) == pytest.approx(level, abs=1e-10)


def test_a_liquid_above_the_rim_is_refused_in_one_line():
    assert highest_contact(CYLINDER) == pytest.approx(0.11 - RIM_MARGIN)
    with pytest.raises(InputError, match=r"liquid.fill: expected .*below the rim.*, found 0.99"):
        level_of_fill(CYLINDER, 0.99)
    with pytest.raises(InputError, match=r"liquid.volume: expected"):
        level_of_volume(CYLINDER, 1.0)
    with pytest.raises(InputError, match=r"liquid.volume: expected"):
        level_of_volume(CYLINDER, 0.0)


def test_the_liquids_mesh_has_the_volume_that_is_written_beside_it(full_vessels):
    for vessel in full_vessels:
        solid = as_trimesh(liquid_solid(vessel))
        assert solid.is_watertight
        top = vessel.interfaces[2].mesh.vertices
        rings = int((top[:, 2] == top[-1, 2]).sum())
        # A regular n-gon has n/(2 pi) sin(2 pi/n) of its circle's area, at every height alike.
        polygon = rings / (2.0 * np.pi) * np.sin(2.0 * np.pi / rings)
        # float32 positions: 4e-9 m of 1e-2 m, averaged over thousands of vertices.
        assert solid.volume == pytest.approx(vessel.liquid.volume * polygon, rel=1e-6)
        assert vessel.liquid.fill == pytest.approx(vessel.liquid.volume / brimful_volume(np.array(vessel.inner)))


def test_levels_lie_between_floor_and_rim(many_vessels):
    for vessel in many_vessels:
        if vessel.liquid is not None:
            inner = np.array(vessel.inner)
            assert inner[0, 1] + 3.9e-3 < vessel.liquid.level <= inner[-1, 1] - RIM_MARGIN + 1e-9


def test_a_liquid_with_a_meniscus_keeps_to_the_same_limits(full_vessels):
    for vessel in full_vessels:
        inner, liquid = np.array(vessel.inner), vessel.liquid
        assert inner[0, 1] < liquid.centre < liquid.level < liquid.contact <= inner[-1, 1] - RIM_MARGIN + 1e-9
        assert volume_below(inner, liquid.level) == pytest.approx(liquid.volume, rel=1e-9)
