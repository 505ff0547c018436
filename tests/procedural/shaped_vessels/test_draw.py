from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
import trimesh

from glassware.annotate.symmetries import symmetry_of
from glassware.core.mesh import as_trimesh, check_closed
from glassware.core.randomness import stream
from glassware.procedural.cavities.wall import thicknesses
from glassware.procedural.description.mesh_vessel import refilled_mesh
from glassware.procedural.description.scene import MeshVessel, glass_solid, liquid_solid
from glassware.procedural.optics.medium import Medium
from glassware.procedural.shaped_vessels.build import ShapedGlass
from glassware.procedural.shaped_vessels.draw import SHAPERS, draw_shaped_vessel
from glassware.procedural.vessels.settings import SHAPED, VesselSettings

GLASS, WATER = Medium(name="test glass", eta=1.52), Medium(name="test water", eta=1.33)
FAMILIES = sorted(SHAPED)
#: Those of the quick suite: a union of solids, another cross-section, a thin wall.
QUICK = [
    pytest.param(name, marks=() if name in ("mug", "square bottle", "plastic cup") else pytest.mark.slow)
    for name in FAMILIES
]
#: Lines of the Monte Carlo along each side [1].
LINES = 32
#: Largest deviation of the thinnest wall and of volumes [1], as the docs state them.
WALL, VOLUME = 0.05, 0.01


@lru_cache
def drawn(category: str, seed: int = 3) -> tuple[MeshVessel, ShapedGlass]:
    settings = VesselSettings(categories=(category,), fill_probability=1.0, fill=(0.3, 0.8))
    return draw_shaped_vessel(
        stream(seed, 0, "vessel"), settings, id=2, name="vessel", glass=GLASS, liquid_medium=WATER
    )


def crossings(corners: np.ndarray, origin: np.ndarray, towards: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances and faces that a ray crosses, in order (Moeller and Trumbore 1997)."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(towards, two)
    det = (one * p).sum(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - corners[:, 0]
        u = (s * p).sum(1) / det
        q = np.cross(s, one)
        v, t = (q @ towards) / det, (two * q).sum(1) / det
        hit = np.flatnonzero((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0))
    order = np.argsort(t[hit])
    return t[hit][order], hit[order]


def test_every_family_of_the_settings_has_a_shape():
    assert set(SHAPERS) == SHAPED


@pytest.mark.parametrize("category", FAMILIES)
def test_glass_and_liquid_are_closed(category):
    vessel, _ = drawn(category)
    check_closed("glass", glass_solid(vessel))
    check_closed("liquid", liquid_solid(vessel))
    assert [part.part for part in vessel.interfaces] == ["outside", "wet_wall", "liquid_surface"]


@pytest.mark.parametrize("category", QUICK)
def test_the_thinnest_wall_is_the_one_asked_for(category):
    vessel, made = drawn(category)
    assert vessel.wall is not None
    corners = made.mesh.vertices[made.mesh.faces].astype(np.float64)
    below = corners[..., 2].max(1) < made.cavity.brim - 2.0 * vessel.wall - 1e-3
    inner = made.cavity.inner
    if category == "double-walled glass":
        mesh = as_trimesh(made.mesh)
        labels = trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
        space = labels != labels[0]
        # The inner wall is between cavity and space, the outer one, which is the thinner, between space and outside.
        assert np.quantile(thicknesses(corners, inner & below, space), 0.01) > (1.0 - WALL) * vessel.wall
        inner = inner | space
        below &= space
    found = thicknesses(corners, inner & below, ~inner)
    # A hundredth of the wall may be thinner by the chords of the mesh.
    assert np.quantile(found, 0.01) == pytest.approx(vessel.wall, rel=WALL)


@pytest.mark.parametrize("category", QUICK)
def test_the_volume_is_that_of_an_independent_monte_carlo(category):
    vessel, _ = drawn(category)
    assert vessel.liquid is not None
    body = liquid_solid(vessel)
    corners = body.vertices[body.faces].astype(np.float64)
    low, high = body.bounds
    # Length in the liquid of vertical lines, one in each cell of a grid, at random in it.
    cell = (high - low)[:2] / LINES
    corner = np.stack(np.meshgrid(*[np.arange(LINES)] * 2), axis=-1).reshape(-1, 2)
    places = low[:2] + cell * (corner + np.random.default_rng(1).random((LINES**2, 2)))
    up = np.array([0.0, 0.0, 1.0])
    total = 0.0
    for place in places:
        distances, _ = crossings(corners, np.array([*place, low[2] - 0.01]), up)
        assert len(distances) % 2 == 0
        total += float((distances[1::2] - distances[::2]).sum())
    assert total * cell.prod() == pytest.approx(vessel.liquid.volume, rel=VOLUME)


@pytest.mark.parametrize("category", QUICK)
def test_what_was_known_of_the_cavity_is_what_is_found_in_the_mesh(category):
    vessel, made = drawn(category)
    again = refilled_mesh(vessel, WATER, 0.5)
    assert again.liquid is not None
    assert again.liquid.volume == pytest.approx(0.5 * made.brimful, rel=VOLUME)
    assert again.liquid.level == pytest.approx(made.cavity.level_of(0.5 * made.brimful), abs=5e-4)


@pytest.mark.parametrize("category", QUICK)
def test_media_alternate_along_random_rays(category):
    """Each ray leaves the medium that it is in: air, glass or liquid."""
    vessel, _ = drawn(category)
    media, some = [], []
    for part in vessel.interfaces:
        media += [(part.front.name, part.back.name)] * len(part.mesh.faces)
        some.append(part.mesh.vertices[part.mesh.faces].astype(np.float64))
    corners = np.concatenate(some)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rng = np.random.default_rng(2)
    wrong = crossed = 0
    for _ in range(60):
        origin = rng.normal(size=3)
        origin *= 0.5 / np.linalg.norm(origin)
        towards = 0.4 * np.array(vessel.size) * rng.uniform(-1.0, 1.0, 3) - origin
        inside = "air"
        for face in crossings(corners, origin, towards)[1]:
            front, back = media[face]
            before, after = (front, back) if normals[face] @ towards < 0.0 else (back, front)
            wrong += before != inside
            crossed += 1
            inside = after
        wrong += inside != "air"
    assert crossed > 100
    assert wrong == 0


def test_turns_of_regular_vessels_are_symmetries_and_handles_leave_none():
    folds = {category: len(symmetry_of(drawn(category)[0]).motions) for category in ("mug", "jug", "teapot")}
    assert folds == {"mug": 1, "jug": 1, "teapot": 1}
    for seed in range(12):
        vessel, made = drawn("square bottle", seed)
        assert made.fold in (2, 4)
        assert len(symmetry_of(vessel).motions) == made.fold
    vessel, made = drawn("fluted glass")
    assert len(symmetry_of(vessel).motions) == made.fold >= 10
    assert symmetry_of(drawn("double-walled glass")[0]).turns


def test_no_two_are_alike():
    for category in ("faceted glass", "mug"):
        sizes = {drawn(category, seed)[0].size for seed in range(6)}
        assert len(sizes) == 6


def test_shapes_do_not_depend_on_the_liquid():
    settings = VesselSettings(categories=("ribbed glass",))
    kwargs = {"id": 2, "name": "vessel", "glass": GLASS}
    empty, _ = draw_shaped_vessel(stream(1, 0, "vessel"), settings, **kwargs)
    full, _ = draw_shaped_vessel(stream(1, 0, "vessel"), settings, **kwargs, liquid_medium=WATER)
    np.testing.assert_array_equal(empty.solid.vertices, full.solid.vertices)
