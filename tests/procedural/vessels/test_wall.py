from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from glassware.procedural.vessels.outline import Outline, linear
from glassware.procedural.vessels.settings import VesselSettings
from glassware.procedural.vessels.wall import WallShape, glass_section

#: Spacing of the points that thickness is measured between [m]; at a wall of 1 mm the nearest pair of points is
#: farther apart than the curves by at most SPACING^2 / (8 * 1 mm) = 0.3 um.
SPACING = 5e-5
SPACING_ERROR = 0.4e-6
#: Glass that may be there beyond the wall: what `glass_section` adds for chords, and the polygon's own chords [m].
SURPLUS = 5.0 * VesselSettings().chord_error


def _fine(points: np.ndarray) -> np.ndarray:
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, lengths[-1], int(lengths[-1] / SPACING) + 2)
    return np.stack([np.interp(at, lengths, column) for column in points.T], axis=-1)


def _below_rim(points: np.ndarray, crown: np.ndarray, wall: float) -> np.ndarray:
    """Without the rounded rim, which ends at most a wall's thickness from its crown."""
    return points[np.hypot(*(points - crown).T) > wall + SURPLUS]


def _crossings(points: np.ndarray) -> int:
    """Number of pairs of segments of a closed polygon that cross, neighbours left out."""
    a, b = points, np.roll(points, -1, axis=0)

    def side(p: np.ndarray, q: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (q[:, None, 0] - p[:, None, 0]) * (x[None, :, 1] - p[:, None, 1]) - (q[:, None, 1] - p[:, None, 1]) * (
            x[None, :, 0] - p[:, None, 0]
        )

    parted = side(a, b, a) * side(a, b, b) < 0.0
    crossing = parted & parted.T
    index = np.arange(len(points))
    apart = np.abs(index[:, None] - index[None, :])
    return int((crossing & (apart > 1) & (apart < len(points) - 1)).sum())


def test_the_crossing_counter_sees_a_bow_tie():
    assert _crossings(np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])) > 0


def test_a_vessel_is_never_thinner_than_its_wall(many_vessels):
    for vessel in many_vessels:
        outer, inner = np.array(vessel.outer), np.array(vessel.inner)
        outside, inside = (_below_rim(_fine(curve), outer[-1], vessel.wall) for curve in (outer, inner))
        thinnest = cKDTree(outside).query(inside)[0].min()
        assert thinnest >= vessel.wall - SPACING_ERROR, f"{vessel.name} ({vessel.category})"
        assert thinnest <= vessel.wall + SURPLUS, f"{vessel.name} ({vessel.category})"


def test_a_profile_never_crosses_itself(many_vessels):
    for vessel in many_vessels:
        outer, inner = np.array(vessel.outer), np.array(vessel.inner)
        assert outer[-1].tolist() == inner[-1].tolist()
        polygon = np.concatenate([outer, inner[-2::-1]])
        assert (polygon >= [0.0, -np.inf]).all()
        assert _crossings(polygon) == 0, f"{vessel.name} ({vessel.category})"


def test_both_profiles_begin_on_the_axis_and_only_there(many_vessels):
    for vessel in many_vessels:
        for profile in (np.array(vessel.outer), np.array(vessel.inner)):
            assert profile[0, 0] == 0.0
            assert (profile[1:, 0] > 0.0).all()
        assert (np.diff(np.array(vessel.inner)[:, 1]) >= 0.0).all()


def test_a_vessel_stands_on_a_flat_ring(many_vessels):
    for vessel in many_vessels:
        outer = np.array(vessel.outer)
        standing = outer[outer[:, 1] <= -0.5 * vessel.size[2] + 1e-12]
        if vessel.category in ("test tube", "round flask"):  # round at the bottom: a stand holds them, or they lie
            assert len(standing) == 1
            continue
        assert len(standing) >= 2
        assert np.ptp(standing[:, 0]) > 1e-3


def _cone(top: float) -> Outline:
    return Outline((linear(0.0, 0.1, 0.03, top),), ())


SHAPE = WallShape(thickness=0.003, taper=0.0, base=0.006, fillet=0.002, corner=0.004, punt=0.0)


@pytest.mark.parametrize("top", [0.03, 0.045, 0.022])
def test_the_rim_is_a_half_circle_tangent_to_both_sides(top):
    section = glass_section(_cone(top), SHAPE, 15e-6)
    tilt = np.arctan2(top - 0.03, 0.1)
    across, along = np.array([np.cos(tilt), -np.sin(tilt)]), np.array([np.sin(tilt), np.cos(tilt)])
    assert section.rim_radius == pytest.approx(0.5 * (SHAPE.thickness + 33e-6), abs=1e-9)
    for curve, side in ((section.outer, 1.0), (section.inner, -1.0)):
        offset = curve.points - section.rim_centre
        rim = offset @ along > 1e-9
        np.testing.assert_allclose(np.hypot(*offset[rim].T), section.rim_radius, atol=1e-9)
        np.testing.assert_allclose(curve.normals[rim], offset[rim] / section.rim_radius, atol=1e-6)
        wall = (~rim) & (curve.points[:, 1] > 0.02)
        np.testing.assert_allclose(curve.normals[wall], np.tile(side * across, (wall.sum(), 1)), atol=1e-6)
    np.testing.assert_allclose(
        section.outer.points[-1], section.rim_centre + np.array([0.0, section.rim_radius]), atol=1e-12
    )


def test_a_base_has_its_thickness_over_the_crown_of_its_punt():
    shape = WallShape(thickness=0.002, taper=0.001, base=0.005, fillet=0.002, corner=0.004, punt=0.0015)
    section = glass_section(_cone(0.04), shape, 15e-6)
    np.testing.assert_allclose(section.outer.points[0], [0.0, 0.0015], atol=1e-12)
    np.testing.assert_allclose(section.inner.points[0], [0.0, 0.0065], atol=1e-12)


def test_the_normals_of_a_section_point_out_of_the_glass():
    section = glass_section(_cone(0.04), SHAPE, 15e-6)
    for curve, sign in ((section.outer, 1.0), (section.inner, -1.0)):
        step = np.diff(curve.points, axis=0)
        right = np.stack([step[:, 1], -step[:, 0]], axis=-1)
        middle = 0.5 * (curve.normals[1:] + curve.normals[:-1])
        assert (sign * (right * middle).sum(1) > 0.0).all()
        np.testing.assert_allclose(np.hypot(*curve.normals.T), 1.0, atol=1e-12)


def test_no_segment_runs_from_the_wall_into_the_rim():
    # It would lean the interpolated normals of the straight wall below the rim.
    outline = Outline((linear(0.0, 0.1, 0.03, 0.03),), ())
    section = glass_section(outline, WallShape(0.0015, 0.0, 0.004, 0.002, 0.003, 0.0), VesselSettings().chord_error)
    for curve in (section.outer, section.inner):
        above = curve.points[:, 1] > 0.05
        upright = np.abs(curve.normals[above, 1]) < 1e-9
        # Up to the height of the rim's centre the wall is straight and upright, and its last vertex is there.
        assert curve.points[above][upright][:, 1].max() == pytest.approx(section.rim_centre[1], abs=1e-9)
        assert np.array_equal(upright, curve.points[above, 1] <= section.rim_centre[1] + 1e-9)
