from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.optimize import linprog

from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.procedural.placement.placement import PlacementSettings, apart, draw_positions, footprint
from glassware.procedural.placement.resting import turn_about_z

BOARD = np.array([[-0.5, -0.4], [0.5, -0.4], [0.5, 0.4], [-0.5, 0.4]])
#: float64 distances of decimetres.
ROUNDING = 1e-12


def _polygon(rng: np.random.Generator, radius: float) -> np.ndarray:
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 9))
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _distance(a: np.ndarray, b: np.ndarray) -> float:
    """Least distance of two convex polygons: from each corner to each edge, or 0 where they share a point."""
    weights = linprog(
        np.zeros(len(a) + len(b)),
        A_eq=np.block([[a.T, -b.T], [np.ones(len(a)), np.zeros(len(b))], [np.zeros(len(a)), np.ones(len(b))]]),
        b_eq=[0.0, 0.0, 1.0, 1.0],
    )
    if weights.success:
        return 0.0
    least = np.inf
    for points, polygon in ((a, b), (b, a)):
        for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            along = np.clip((points - start) @ (end - start) / ((end - start) ** 2).sum(), 0.0, 1.0)
            least = min(least, np.linalg.norm(points - start - along[:, None] * (end - start), axis=1).min())
    return float(least)


def test_objects_lie_on_the_board_and_apart(rng):
    settings = PlacementSettings(gap=0.01, edge=0.02)
    for trial in range(5):
        outlines = [_polygon(rng, radius) for radius in rng.uniform(0.02, 0.09, 12)]
        shifts = draw_positions(outlines, BOARD, settings, np.random.default_rng(trial))
        placed = [outline + shift for outline, shift in zip(outlines, shifts, strict=True)]
        for i, a in enumerate(placed):
            assert (np.abs(a) <= np.array([0.5, 0.4]) - settings.edge + ROUNDING).all()
            for b in placed[:i]:
                assert _distance(a, b) >= settings.gap - ROUNDING


def test_what_is_called_apart_is_apart(rng):
    told = []
    for _ in range(300):
        a, b = _polygon(rng, 0.1), _polygon(rng, 0.1) + rng.uniform(-0.3, 0.3, 2)
        told.append(apart(a, b, 0.02))
        distance = _distance(a, b)
        # The strip may not be found between two corners, whose own line no edge runs along: then a placement is only
        # refused. What is told apart has to be.
        assert not told[-1] or distance >= 0.02 - ROUNDING
        assert told[-1] or distance < 0.02 * np.sqrt(2.0) + 0.02
    assert 50 < sum(told) < 250


def test_a_footprint_is_the_outline_seen_from_above(rng):
    box = trimesh.creation.box(extents=(0.2, 0.1, 0.3))
    pose = turn_about_z(0.5)
    pose[:3, 3] = [0.1, -0.2, 0.7]
    outline = footprint(Mesh("box", box.vertices, box.faces), pose)
    area = 0.5 * np.abs(
        np.cross(np.pad(outline, ((0, 0), (0, 1))), np.pad(np.roll(outline, -1, 0), ((0, 0), (0, 1))))[:, 2].sum()
    )
    assert area == pytest.approx(0.02, rel=1e-6)  # float32 corners
    np.testing.assert_allclose(outline.mean(0), [0.1, -0.2], atol=1e-7)


def test_objects_stay_in_the_disc_while_they_fit():
    outlines = [0.02 * _polygon(np.random.default_rng(i), 1.0) for i in range(3)]
    settings = PlacementSettings(radius=0.16)
    shifts = draw_positions(outlines, BOARD, settings, np.random.default_rng(3))
    assert (np.linalg.norm(shifts, axis=1) <= 0.16).all()


def test_the_disc_grows_for_a_crowd():
    outlines = [_polygon(np.random.default_rng(i), 0.08) for i in range(8)]
    shifts = draw_positions(outlines, BOARD, PlacementSettings(radius=0.02), np.random.default_rng(3))
    assert np.linalg.norm(shifts, axis=1).max() > 0.1


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match="vessel_count, prop_count: expected objects that fit on the table of "):
        draw_positions(
            [_polygon(np.random.default_rng(i), 0.39) for i in range(3)],
            BOARD,
            PlacementSettings(),
            np.random.default_rng(0),
        )


def test_the_same_draws_give_the_same_places():
    outlines = [_polygon(np.random.default_rng(i), 0.05) for i in range(5)]
    one, two = (draw_positions(outlines, BOARD, PlacementSettings(), np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one, two)
