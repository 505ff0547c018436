"""Distances from triangles, however narrow these are."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.verification.solids import worst_distance

#: Of the bottom of a cocktail glass's cone, whose tip is on the axis [m].
FAN = np.array(
    [[0.91554847e-3, 0.0, 18.68239418e-3], [0.91457152e-3, 0.04228319e-3, 18.68239418e-3], [0.0, 0.0, 18.66564713e-3]]
)


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("narrow", [1.0, 1e-3, 0.0])
def test_the_distance_is_that_of_the_nearest_point(scale, narrow):
    """Against the nearest of many points of each triangle, which is at most a step of them farther."""
    rng, steps = np.random.default_rng(4), 60
    i, k = np.divmod(np.arange((steps + 1) ** 2), steps + 1)
    weights = np.stack([i, k, steps - i - k], axis=1)[i + k <= steps] / steps
    for _ in range(50):
        triangle = rng.normal(size=(3, 3))
        triangle[2] = triangle[0] + 0.4 * (triangle[1] - triangle[0]) + narrow * (triangle[2] - triangle[0])
        triangle, point = scale * triangle, scale * rng.normal(size=3)
        found = worst_distance(triangle[None], point[None], 0.0)
        sampled = np.linalg.norm(weights @ triangle - point, axis=1).min()
        assert found <= sampled * (1.0 + 1e-9)
        assert found >= sampled - scale * 5.0 / steps


def test_a_corner_is_on_its_triangle():
    """trimesh's own closest point says that the tip of this triangle is 0.9 mm beside it."""
    for corner in FAN:
        assert worst_distance(FAN[None], corner[None], 1e-6) < 1e-12
