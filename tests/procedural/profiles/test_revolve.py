from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import as_trimesh
from glassware.procedural.profiles.curve import Curve, arc
from glassware.procedural.profiles.revolve import revolved, segments_for, unit_circle


def _closed(curve: Curve) -> Curve:
    """The curve with its ends put exactly onto the axis."""
    curve.points[[0, -1], 0] = 0.0
    curve.normals[[0, -1], 0] = 0.0
    return curve


def test_a_half_circle_becomes_a_sphere_with_radial_normals():
    radius = 0.04
    mesh = revolved(_closed(arc(np.zeros(2), radius, -np.pi / 2, np.pi / 2)), 128, "sphere")
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, mesh.vertices / radius, atol=1e-6)
    solid = as_trimesh(mesh)
    assert solid.is_watertight
    # An inscribed polyhedron of 128 x 90 facets lacks about (2/3) (pi/128)^2 + (2/3)(pi/180)^2 of the volume.
    assert solid.volume == pytest.approx(4.0 / 3.0 * np.pi * radius**3, rel=1e-3)
    assert solid.volume < 4.0 / 3.0 * np.pi * radius**3


def test_faces_follow_the_normals_whichever_way_the_curve_runs():
    curve = _closed(arc(np.zeros(2), 0.04, -np.pi / 2, np.pi / 2))
    volumes = [
        as_trimesh(revolved(Curve(points, normals), 64, "sphere")).volume
        for points, normals in (
            (curve.points, curve.normals),
            (curve.points[::-1], curve.normals[::-1]),
            (curve.points, -curve.normals),
        )
    ]
    assert volumes[0] > 0.0
    np.testing.assert_allclose(volumes, [volumes[0], volumes[0], -volumes[0]], rtol=1e-12)


def test_a_crease_has_two_rings_in_one_place_and_the_solid_is_closed():
    r, h, n = 0.03, 0.1, 64
    points = np.array([[0, 0], [r, 0], [r, 0], [r, h], [r, h], [0, h]], dtype=float)
    normals = np.array([[0, -1], [0, -1], [1, 0], [1, 0], [0, 1], [0, 1]], dtype=float)
    mesh = revolved(Curve(points, normals), n, "cylinder")
    assert len(mesh.vertices) == 4 * n + 2
    assert len(mesh.faces) == 4 * n
    solid = as_trimesh(mesh)
    assert solid.is_watertight
    assert solid.volume == pytest.approx(0.5 * n * np.sin(2 * np.pi / n) * r**2 * h, rel=1e-6)
    corners = mesh.vertices[mesh.faces].astype(float)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing /= np.linalg.norm(facing, axis=1)[:, None]
    assert mesh.normals is not None
    cosine = np.einsum("fi,fci->fc", facing, mesh.normals[mesh.faces])
    np.testing.assert_allclose(cosine.min(), np.cos(np.pi / n), atol=1e-5)


@pytest.mark.parametrize("radius", [0.015, 0.04, 0.08])
@pytest.mark.parametrize("error", [5e-6, 15e-6])
def test_chords_stay_within_the_error_with_no_more_segments_than_needed(radius, error):
    n = segments_for(radius, error)
    assert n % 8 == 0
    assert radius * (1.0 - np.cos(np.pi / n)) <= error
    assert radius * (1.0 - np.cos(np.pi / (n - 8))) > error


def test_the_circle_is_the_circle_and_exactly_symmetric():
    n = 120
    circle = unit_circle(n)
    angles = 2.0 * np.pi * np.arange(n) / n
    np.testing.assert_allclose(circle, np.stack([np.cos(angles), np.sin(angles)], -1), atol=1e-15)
    np.testing.assert_array_equal(circle[[0, 30, 60, 90]], [[1, 0], [0, 1], [-1, 0], [0, -1]])
    np.testing.assert_array_equal(circle[60:], -circle[:60])


def test_a_curve_that_crosses_the_axis_in_its_middle_is_refused():
    points = np.array([[0.01, 0.0], [0.0, 0.01], [0.01, 0.02]])
    with pytest.raises(ValueError, match="only its ends"):
        revolved(Curve(points, np.tile([0.0, 1.0], (3, 1))), 64, "waist")
