"""The first look at a scene shows what the first view will, in small."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.camera import Camera
from glassware.render.cache.draft import smaller


def _camera(width: int, height: int) -> Camera:
    return Camera(
        width=width,
        height=height,
        focal=500.0,
        focal_y=510.0,
        centre=(0.48 * width, 0.53 * height),
        world_T_camera=np.eye(4),
        baseline=0.06,
        exposure=1.0,
        grid_index=None,
    )


def _borders(camera: Camera) -> np.ndarray:
    """Return the slopes x/z and y/z of the rays through the picture's left, upper, right and lower border."""
    cx, cy = camera.centre
    x = (np.array([-0.5, camera.width - 0.5]) - cx) / camera.fx
    y = (np.array([-0.5, camera.height - 0.5]) - cy) / camera.fy
    return np.concatenate([x, y])


@pytest.mark.parametrize(("width", "height"), [(640, 480), (1920, 1080), (333, 777)])
def test_a_smaller_camera_has_the_same_field_of_view(width, height):
    camera = _camera(width, height)
    small = smaller(camera, 160 * 120)
    assert 0.95 * 160 * 120 < small.width * small.height <= 160 * 120
    np.testing.assert_allclose(_borders(small), _borders(camera), rtol=1e-12)


def test_a_camera_that_is_small_enough_stays():
    camera = _camera(48, 36)
    small = smaller(camera, 160 * 120)
    assert (small.width, small.height) == (48, 36)
    np.testing.assert_allclose(small.K, camera.K, rtol=1e-12)
