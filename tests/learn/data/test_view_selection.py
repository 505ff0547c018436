from __future__ import annotations

import numpy as np
import pytest

from glassware.learn.data.view_selection import LAST_REFERENCE, grid_neighbours, nearest_cameras
from glassware.procedural.surroundings.camera_poses import GRID_VIEWS, grid_directions


def test_neighbours_are_next_to_each_other_on_the_sphere():
    """By the angles of the directions: one ring or none up or down, one step or none round."""
    x, y, z = grid_directions(np.radians(10.0)).T
    elevation, azimuth = np.degrees(np.arcsin(z)), np.degrees(np.arctan2(y, x))
    for one in range(1, GRID_VIEWS):
        found = grid_neighbours(one)
        for other in range(1, GRID_VIEWS):
            round_ = abs((azimuth[one] - azimuth[other] + 180.0) % 360.0 - 180.0)
            near = abs(elevation[one] - elevation[other]) < 21.0 and round_ < 360.0 / 14 + 1.0
            assert (other in found) == (near and other != one)
        assert (0 in found) == (elevation[one] > 69.0)
    assert grid_neighbours(0) == set(range(1, 15))


def test_views_along_the_table_are_no_reference():
    elevation = np.degrees(np.arcsin(grid_directions(np.radians(10.0))[:, 2]))
    assert np.flatnonzero(elevation > 11.0).tolist() == list(range(LAST_REFERENCE + 1))


@pytest.mark.parametrize("count", [1, 3, 9])
def test_the_nearest_cameras_come_first(rng, count):
    positions = rng.standard_normal((6, 3))
    away = sorted((float(np.linalg.norm(positions[i] - positions[2])), i) for i in range(6) if i != 2)
    assert nearest_cameras(positions, 2, count).tolist() == [i for _, i in away[:count]]
