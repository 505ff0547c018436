"""Which object is in front of which follows from first surfaces and silhouettes."""

from __future__ import annotations

import numpy as np

from glassware.annotate.order import Occlusion, occlusion_order
from glassware.render.frame import Geometry


def _geometry(ids, crossed):
    ids, crossed = np.array([ids], np.uint16), np.array(crossed, bool)[:, None]
    empty = np.zeros(ids.shape, np.float32)
    return Geometry(empty, np.zeros((*ids.shape, 3)), ids, empty, ids, np.ones((*ids.shape, 3)), crossed, crossed)


def test_a_first_surface_is_in_front_of_all_that_its_ray_crosses_behind():
    # A spoon (3) stands in a glass (2): in one pixel it is in front, in three behind; (4) stands alone.
    seen = _geometry([3, 2, 2, 2, 4, 1], [[1, 1, 1, 1, 0, 0], [1, 1, 1, 1, 0, 0], [0, 0, 0, 0, 1, 0]])
    assert occlusion_order(seen, [2, 3, 4]) == (
        Occlusion(front=2, behind=3, pixels=3),
        Occlusion(front=3, behind=2, pixels=1),
    )


def test_nothing_is_in_front_of_nothing():
    assert occlusion_order(_geometry([0, 1], np.zeros((0, 2))), []) == ()
