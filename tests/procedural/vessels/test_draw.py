from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.core.errors import InputError
from glassware.core.mesh import as_trimesh
from glassware.core.randomness import stream
from glassware.procedural.description.scene import Vessel, glass_solid
from glassware.procedural.optics.medium import Medium
from glassware.procedural.profiles.curve import MAX_TURN
from glassware.procedural.profiles.liquid import brimful_volume
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import CATEGORIES, REVOLVED, VesselSettings
from glassware.procedural.vessels.sizes import draw_size

GLASS = Medium(name="test glass", eta=1.52)
WATER = Medium(name="test water", eta=1.33)


def _draw(seed: int, liquid: Medium | None = WATER, **settings: Any) -> Vessel:
    rng = stream(5, seed, "vessels")
    settings = {"categories": REVOLVED} | settings
    return draw_vessel(rng, VesselSettings(**settings), id=2, name="vessel", glass=GLASS, liquid_medium=liquid)


def _segments(vessel: Vessel) -> int:
    """Vertices on the widest ring."""
    vertices = vessel.interfaces[0].mesh.vertices
    return int((vertices[:, 2] == vertices[np.argmax(vertices[:, 0]), 2]).sum())


def test_the_glass_is_watertight_and_has_the_volume_of_its_profile(many_vessels):
    for vessel in many_vessels[::7]:
        solid = as_trimesh(glass_solid(vessel))
        assert solid.is_watertight
        assert solid.is_winding_consistent
        outer, inner = np.array(vessel.outer), np.array(vessel.inner)
        exact = brimful_volume(outer) - brimful_volume(inner)
        n = _segments(vessel)
        # An n-gon's share of its circle's area; float32 positions are 4e-9 m off a wall of 1e-3 m.
        assert solid.volume == pytest.approx(exact * n / (2 * np.pi) * np.sin(2 * np.pi / n), rel=2e-5)
        assert exact > 0.0


def test_the_frame_is_the_centre_of_the_bounding_box(many_vessels):
    for vessel in many_vessels:
        bounds = np.stack([i.mesh.bounds for i in vessel.interfaces])
        low, high = bounds[:, 0].min(0), bounds[:, 1].max(0)
        np.testing.assert_allclose(high, 0.5 * np.array(vessel.size), atol=1e-8)
        np.testing.assert_allclose(low, -0.5 * np.array(vessel.size), atol=1e-8)
        np.testing.assert_array_equal(vessel.world_T_object, np.eye(4))


def test_sizes_are_those_of_glassware(many_vessels):
    for vessel in many_vessels:
        # Flared lips and rounded joints may pass the drawn size by little, or stay below.
        assert 0.039 <= vessel.size[2] <= 0.303
        assert 0.95 * 0.005 <= 0.5 * vessel.size[0] <= 0.082
        assert 0.0008 <= vessel.wall <= 0.004


def test_normals_are_unit_and_close_to_their_faces(full_vessels):
    for vessel in full_vessels:
        # A facet turns away by its share of the ring and by at most one step of the profile.
        limit = np.cos(MAX_TURN + np.pi / _segments(vessel))
        for interface in vessel.interfaces:
            mesh = interface.mesh
            assert mesh.normals is not None
            np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
            corners = mesh.vertices[mesh.faces].astype(np.float64)
            facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            facing /= np.linalg.norm(facing, axis=1)[:, None]
            assert np.einsum("fi,fci->fc", facing, mesh.normals[mesh.faces].astype(np.float64)).min() > limit - 1e-3


def test_meshes_are_fine_enough_and_not_wasteful(many_vessels):
    counts = [sum(len(i.mesh.vertices) for i in vessel.interfaces) for vessel in many_vessels]
    assert 8_000 < np.median(counts) < 20_000
    assert max(counts) < 60_000


def test_the_same_stream_gives_the_same_vessel():
    first, second = _draw(3), _draw(3)
    assert first.outer == second.outer
    assert first.liquid == second.liquid
    for a, b in zip(first.interfaces, second.interfaces, strict=True):
        np.testing.assert_array_equal(a.mesh.vertices, b.mesh.vertices)
    assert _draw(4).outer != first.outer


def test_the_shape_does_not_depend_on_the_filling():
    assert _draw(3, None).outer == _draw(3, fill_probability=1.0).outer == _draw(3, fill=(0.2, 0.2)).outer


def test_probabilities_and_ranges_are_followed():
    assert all(_draw(seed, fill_probability=1.0).liquid is not None for seed in range(6))
    assert all(_draw(seed, fill_probability=0.0).liquid is None for seed in range(6))
    assert all(_draw(seed, None, fill_probability=1.0).liquid is None for seed in range(6))
    assert all(_draw(seed, rough_probability=0.0).roughness == 0.0 for seed in range(6))
    rough = [_draw(seed, rough_probability=1.0, roughness=(0.1, 0.3)).roughness for seed in range(6)]
    assert 0.1 <= min(rough) < max(rough) <= 0.3
    filled = _draw(1, categories=("tumbler",), fill_probability=1.0, fill=(0.5, 0.5)).liquid
    assert filled is not None
    assert filled.fill == pytest.approx(0.5)


def test_most_vessels_are_smooth_and_all_categories_come(many_vessels):
    assert np.mean([vessel.roughness == 0.0 for vessel in many_vessels]) > 0.8
    drawn = {draw_size(stream(5, seed, "vessels"), VesselSettings())[0] for seed in range(300)}
    assert drawn == set(CATEGORIES)


@pytest.mark.parametrize("height", [0.04, 0.30])
@pytest.mark.parametrize("radius", [0.015, 0.08])
@pytest.mark.parametrize("wall", [0.001, 0.004])
def test_the_corners_of_the_allowed_sizes_can_be_built(height, radius, wall):
    settings: dict[str, Any] = {"height": (height, height), "radius": (radius, radius), "wall": (wall, wall)}
    try:
        vessels = [_draw(seed, **settings) for seed in range(3)]
    except InputError:
        # Nothing is 30 cm high and 1.5 cm in radius; the message is what a user gets.
        assert radius / height < 0.11 or radius / height > 1.3
        return
    for vessel in vessels:
        assert vessel.wall == wall
        # Rounding may take a little off the widest place, as the setting says.
        assert 0.95 * radius <= 0.5 * vessel.size[0] <= 1.02 * radius
        assert vessel.size[2] == pytest.approx(height, rel=0.03)
        assert as_trimesh(glass_solid(vessel)).is_watertight


def test_sizes_that_no_category_has_are_refused_in_one_line():
    with pytest.raises(InputError, match=r"vessels.categories: expected one that can be .* found bottle"):
        _draw(0, categories=("bottle",), height=(0.04, 0.05))


@pytest.mark.parametrize(
    ("field", "value"),
    [("height", (0.2, 0.1)), ("wall", (0.0, 0.001)), ("fill_probability", 1.5), ("categories", ()), ("colour", 1)],
)
def test_settings_out_of_range_are_refused_by_name(field, value):
    with pytest.raises(ValidationError, match=field):
        VesselSettings(**{field: value})
