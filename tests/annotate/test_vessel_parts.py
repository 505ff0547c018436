"""Parts of vessels are what straight rays cross before anything opaque."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from glassware.annotate.vessel_parts import PART_BITS, part_bits, polygon_mask, vessel_parts
from glassware.render.frame import Layers


def _layers(rays):
    """Layers of rays in a row, each a list of (id, part)."""
    depth = max(map(len, rays))
    Z = np.full((depth, 1, len(rays)), np.inf, np.float32)
    ids, parts = np.zeros(Z.shape, np.uint16), np.zeros(Z.shape, np.uint8)
    for column, ray in enumerate(rays):
        for row, (number, part) in enumerate(ray):
            Z[row, 0, column], ids[row, 0, column], parts[row, 0, column] = 1 + row, number, part
    count = np.array([[len(ray) for ray in rays]], np.uint16)
    return Layers(Z, np.zeros((*Z.shape, 3), np.float16), ids, parts, ids, parts > 9, count)


def test_each_part_counts_up_to_the_first_opaque_surface(analytic):
    camera = analytic.camera(0)
    wall, wet, top = (2, 1), (2, 2), (2, 3)
    rays = [[wall, wet, wet, wall], [top, wet, wall], [wall, wall], [(4, 0), wall, wet], [(3, 1), wall], []]
    parts = vessel_parts(_layers(rays), 2, [], camera)
    assert parts.glass.tolist() == [[True, True, True, False, True, False]]
    assert parts.wet_wall.tolist() == [[True, True, False, False, False, False]]
    assert parts.liquid_surface.tolist() == [[False, True, False, False, False, False]]
    assert parts.content.tolist() == [[True, True, False, False, False, False]]
    assert not parts.opening.any()
    bits = part_bits([parts], (1, 6))
    assert bits[0, 1] == PART_BITS["glass"] | PART_BITS["wet_wall"] | PART_BITS["liquid_surface"] | PART_BITS["content"]


def test_contents_count_and_the_surface_of_a_turbid_liquid_hides_what_is_behind_it(analytic):
    milk, wall, wet, top, ice = 5, (2, 1), (2, 2), (2, 3), (2, 5)
    layers = _layers([[ice, wall], [wall, wet, wet, wall], [top, wet, wall]])
    layers = replace(layers, material=np.zeros_like(layers.id))
    clear = vessel_parts(layers, 2, [], analytic.camera(0), turbid=[milk])
    assert clear.content.tolist() == [[True, True, True]]
    assert clear.wet_wall.tolist() == [[False, True, True]]
    layers.material[0, 0, 2] = milk  # seen from above
    turbid = vessel_parts(layers, 2, [], analytic.camera(0), turbid=[milk])
    assert turbid.liquid_surface.tolist() == [[False, False, True]]
    assert turbid.wet_wall.tolist() == [[False, True, False]]
    assert turbid.glass.tolist() == [[True, True, False]]


def test_the_inside_of_a_polygon_is_opencvs(rng):
    for _ in range(20):
        corners = rng.uniform(-10, 70, (7, 2))
        corners = corners[np.argsort(np.arctan2(*(corners - corners.mean(axis=0)).T))]
        outline = corners.astype(np.float32)[:, None]
        grid = [[cv2.pointPolygonTest(outline, (u, v), True) for u in range(60)] for v in range(40)]
        away = np.array(grid)
        mask = polygon_mask(corners, (40, 60))
        sure = np.abs(away) > 1e-3
        np.testing.assert_array_equal(mask[sure], (away > 0)[sure])


def test_a_polygon_that_reaches_behind_the_camera_has_no_inside():
    assert not polygon_mask(np.array([[0.0, 0.0], [np.nan, np.nan], [5.0, 5.0]]), (6, 6)).any()
