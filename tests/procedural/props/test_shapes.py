"""Made shapes are closed solids of the right volume, with normals that look outwards."""

from __future__ import annotations

from math import gamma

import numpy as np
import pytest
from scipy.spatial import cKDTree

from glassware.core.mesh import Mesh, as_trimesh
from glassware.procedural.props.blocks import extrusion, rounded_box, superellipsoid
from glassware.procedural.props.revolution import SEGMENTS, arc, revolve, rounded
from glassware.procedural.props.shapes import SHAPES, draw_shape

#: Least cosine between a shading normal and its face: faces turn by up to 7.5 degrees along an arc, 10 with the
#: strongest bend of the sphere-like ones.
LEAST_COSINE = np.cos(np.radians(10.5))
#: Inscribed polygons lose volume: a circle of n chords has the area (n / 2 pi) sin(2 pi / n) of the disc's.
DISC = SEGMENTS / (2 * np.pi) * np.sin(2 * np.pi / SEGMENTS)
#: Float32 positions: 2^-24 of the extent each way, summed over thousands of faces.
ROUNDING = 1e-5
#: An arc of steps of 7.5 degrees loses at most (7.5 deg)^2 / 6 of the area between it and its chord's centre.
ARC_LOSS = np.radians(7.5) ** 2 / 6


def _volume(mesh: Mesh) -> float:
    return as_trimesh(mesh).volume


@pytest.mark.parametrize("category", SHAPES)
@pytest.mark.parametrize("longest", [0.03, 0.2])
def test_a_shape_is_a_centred_closed_solid_of_the_size_asked_for(category: str, longest: float) -> None:
    for seed in range(5):
        shape = SHAPES[category](np.random.default_rng(seed), longest, "shape")
        solid = as_trimesh(shape.mesh)
        assert solid.is_watertight
        assert solid.is_winding_consistent
        assert solid.volume > 0
        assert solid.body_count == 1
        # Rounding may cut a blunt cone's or a slanted cup's corner: 10 % at most.
        assert 0.9 * longest < np.ptp(shape.mesh.bounds, axis=0).max() < longest * (1 + ROUNDING)
        assert np.abs(shape.mesh.bounds.sum(axis=0)).max() < longest * ROUNDING


@pytest.mark.parametrize("category", SHAPES)
def test_a_shape_has_unit_normals_that_follow_its_faces_and_finite_texture_coordinates(category: str) -> None:
    for seed in range(5):
        mesh = SHAPES[category](np.random.default_rng(seed), 0.1, "shape").mesh
        corners = mesh.vertices[mesh.faces].astype(float)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        face = cross / np.linalg.norm(cross, axis=1, keepdims=True)
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
        assert np.einsum("fi,fci->fc", face, mesh.normals[mesh.faces]).min() > LEAST_COSINE
        assert np.isfinite(mesh.uv).all()


#: Solids of revolution.
ROUND = ("cylinder", "plain can", "ball", "cone", "ring", "capsule", "cup")


@pytest.mark.parametrize("category", ROUND)
def test_a_shape_called_symmetric_is_the_same_after_a_step_about_its_axis(category: str) -> None:
    shape = SHAPES[category](np.random.default_rng(1), 0.1, "shape")
    assert shape.symmetric
    x, y, z = np.unique(shape.mesh.vertices, axis=0).T.astype(float)
    step = 2 * np.pi / SEGMENTS
    turned = np.stack([np.cos(step) * x - np.sin(step) * y, np.sin(step) * x + np.cos(step) * y, z], 1)
    distance, _ = cKDTree(np.stack([x, y, z], 1)).query(turned)
    assert distance.max() < 0.1 * ROUNDING


def test_shapes_that_differ_round_the_axis_are_not_called_symmetric() -> None:
    others = [category for category in SHAPES if category not in ROUND]
    assert not any(SHAPES[category](np.random.default_rng(1), 0.1, "shape").symmetric for category in others)


def test_shapes_are_drawn_from_the_generator_alone() -> None:
    first, again = (draw_shape(np.random.default_rng(9), 0.1, "a") for _ in range(2))
    assert first.category == again.category
    assert np.array_equal(first.mesh.vertices, again.mesh.vertices)
    rng = np.random.default_rng(1)
    assert {draw_shape(rng, 0.1, "a").category for _ in range(150)} == set(SHAPES)


def test_a_cylinder_has_the_volume_of_its_prism() -> None:
    mesh, unit = revolve("a", rounded([(0, 0), (0.03, 0), (0.03, 0.1), (0, 0.1)], [0, 0]))
    assert _volume(mesh) == pytest.approx(np.pi * 0.03**2 * 0.1 * DISC, rel=ROUNDING)
    assert unit == pytest.approx(2 * np.pi * 0.03)


def test_a_cone_has_the_volume_of_its_frustum() -> None:
    mesh, _ = revolve("a", rounded([(0, 0), (0.05, 0), (0.02, 0.09), (0, 0.09)], [0, 0]))
    frustum = np.pi * 0.09 / 3 * (0.05**2 + 0.05 * 0.02 + 0.02**2)
    assert _volume(mesh) == pytest.approx(frustum * DISC, rel=ROUNDING)


def test_a_sphere_and_a_torus_have_their_volumes() -> None:
    ball, _ = revolve("a", [arc((0.0, 0.0), 0.05, -np.pi / 2, np.pi / 2)])
    exact = 4 / 3 * np.pi * 0.05**3
    assert exact * DISC * (1 - 2 * ARC_LOSS) < _volume(ball) < exact * DISC
    torus, _ = revolve("a", [arc((0.05, 0.0), 0.02, -np.pi, np.pi)], closed=True)
    # Pappus: area of the polygon of 48 chords times the way of its centroid.
    polygon = 0.5 * 48 * np.sin(2 * np.pi / 48) * 0.02**2
    assert _volume(torus) == pytest.approx(polygon * 2 * np.pi * 0.05 * DISC, rel=ROUNDING)


def test_a_rounded_box_has_the_volume_of_its_parts() -> None:
    sides, radius = np.array([0.1, 0.06, 0.03]), 0.01
    mesh, _ = rounded_box("a", tuple(sides), radius)
    inner = sides - 2 * radius
    core = inner.prod() + 2 * radius * (inner[0] * inner[1] + inner[1] * inner[2] + inner[2] * inner[0])
    edges, corners = np.pi * radius**2 * inner.sum(), 4 / 3 * np.pi * radius**3
    assert core + (1 - 2 * ARC_LOSS) * (edges + corners) < _volume(mesh) < core + edges + corners
    assert np.allclose(mesh.bounds, [-sides / 2, sides / 2], atol=1e-8)


@pytest.mark.parametrize("power", [2.0, 3.5, 5.0])
def test_a_superellipsoid_has_the_volume_of_dirichlets_integral(power: float) -> None:
    a, b, c = 0.05, 0.04, 0.03
    mesh, _ = superellipsoid("a", (2 * a, 2 * b, 2 * c), power)
    exact = 8 * a * b * c * gamma(1 + 1 / power) ** 3 / gamma(1 + 3 / power)
    # Steps of 90/32 degrees both ways lose (step)^2 / 6 each on a sphere; edges of boxier ones bend a few times more.
    assert exact * (1 - 5e-3) < _volume(mesh) < exact


def test_a_prism_has_the_volume_of_its_outline_times_its_height() -> None:
    turn = 2 * np.pi * np.arange(6) / 6
    mesh, _ = extrusion("a", 0.04 * np.stack([np.cos(turn), np.sin(turn)], 1), 0.07)
    assert _volume(mesh) == pytest.approx(1.5 * np.sqrt(3) * 0.04**2 * 0.07, rel=ROUNDING)
    # Every edge is sharp: a corner has three normals, so no normal is shared between sides.
    assert len(np.unique(np.round(mesh.normals, 5), axis=0)) == 8


def test_an_arc_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="radius that fits"):
        rounded([(0, 0), (0.03, 0), (0.03, 0.1), (0, 0.1)], [0.06, 0.06])


def test_a_rounded_corner_leaves_its_lines_without_a_kink() -> None:
    pieces = rounded([(0, 0), (0.03, 0), (0.03, 0.1), (0, 0.1)], [0.005, 0.0])
    corner = pieces[1]
    assert np.allclose(np.linalg.norm(corner.points - [0.025, 0.005], axis=1), 0.005, atol=1e-12)
    assert np.allclose(pieces[0].normals[-1], corner.normals[0], atol=1e-9)
    assert np.allclose(corner.normals[-1], pieces[2].normals[0], atol=1e-9)
