from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.keypoints import keypoints
from glassware.annotate.symmetries import symmetry_of
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh, turned, volume_of
from glassware.procedural.description.scene import GlassBody, Vessel
from glassware.procedural.optics.medium import AIR, Medium
from glassware.procedural.primitives.bodies import ball, box_mesh, glass_body, prism, slab, vessel
from glassware.procedural.primitives.scenes import camera, scene
from glassware.procedural.scene.scene_file import load_scene, save_scene
from glassware.procedural.scene.validate import check_scene

GLASS = Medium(name="glass", eta=1.5)
WATER = Medium(name="water", eta=1.33, density=998.2, surface_tension=0.07274, contact_angle=0.436)
BOTTLE = [(0.035, 0.0), (0.036, 0.10), (0.016, 0.14), (0.016, 0.18)]


def _outside(body: GlassBody) -> Mesh:
    return body.interfaces[0].mesh


def test_a_ball_has_its_volume_and_exact_normals():
    body = ball(0.03, GLASS, (0.1, 0.2, 0.3), chord_error=5e-6)
    mesh = _outside(body)
    # Facets lie within the chord error of the sphere, so the volume within 3 e / r of it.
    assert volume_of(mesh) == pytest.approx(4.0 / 3.0 * np.pi * 0.03**3, rel=3 * 5e-6 / 0.03)
    assert mesh.normals == pytest.approx(mesh.vertices / 0.03, abs=1e-6)
    assert body.world_T_object[:3, 3] == pytest.approx([0.1, 0.2, 0.3])
    assert body.size == pytest.approx((0.06,) * 3, abs=1e-5)


@pytest.mark.parametrize("error", [1e-3, 1e-4, 1e-5])
def test_a_balls_facets_lie_within_the_chord_error(error):
    mesh = _outside(ball(0.05, GLASS, chord_error=error))
    middles = mesh.vertices.astype(float)[mesh.faces].mean(1)
    depth = 0.05 - np.linalg.norm(middles, axis=1)
    assert 0.0 < depth.max() <= error


def test_a_slab_and_a_prism_have_their_volumes_and_places():
    body = slab((0.1, 0.2, 0.02), GLASS, (0.0, 0.0, 0.5))
    assert volume_of(_outside(body)) == pytest.approx(0.1 * 0.2 * 0.02, rel=1e-6)
    assert body.world_T_object[2, 3] == 0.5
    for corners in ([(0.0, 0.1), (0.04, 0.1), (0.0, 0.13)], [(0.0, 0.13), (0.04, 0.1), (0.0, 0.1)]):
        body = prism(corners, 0.05, GLASS)
        assert volume_of(_outside(body)) == pytest.approx(0.5 * 0.04 * 0.03 * 0.05, rel=1e-6)
        assert body.world_T_object[:3, 3] == pytest.approx([0.02, 0.0, 0.115])


def test_a_vessel_stands_on_the_table_with_its_wall_and_liquid():
    empty, full = vessel(BOTTLE, GLASS, wall=2e-3), vessel(BOTTLE, GLASS, liquid=WATER, fill=0.4)
    for body in (empty, full):
        lowest = _outside(body).bounds[0, 2] + body.world_T_object[2, 3]
        # Not in optical contact with the table: two surfaces in one place have no order.
        assert lowest == pytest.approx(1e-4, abs=1e-8)
        assert body.size[:2] == pytest.approx((0.072, 0.072), abs=1e-3)
    assert full.liquid is not None
    assert full.liquid.fill == pytest.approx(0.4, rel=1e-6)
    assert [part.part for part in full.interfaces] == ["outside", "wet_wall", "liquid_surface"]
    # On the straight part of the body the wall is as thick across as was asked for, up to the chord errors it adds.
    gaps = [np.hypot(*np.subtract(point, full.outer).T).min() for point in full.inner if -0.04 < point[1] < 0.0]
    assert min(gaps) >= 2e-3


def test_bodies_by_hand_make_a_scene_that_is_checked_saved_and_read_back(tmp_path):
    bodies = (
        ball(0.02, GLASS, (0.0, 0.0, 0.021), id=2),
        slab((0.03, 0.03, 0.03), GLASS, (0.1, 0.0, 0.016), id=3),
        prism([(0.0, 0.001), (0.03, 0.001), (0.0, 0.03)], 0.02, GLASS, id=4).model_copy(
            update={"world_T_object": _shifted((-0.1, 0.1, 0.02))}
        ),
        vessel(BOTTLE, GLASS, liquid=WATER, place=(0.0, 0.2), id=5),
    )
    made = scene(bodies, [camera((0.3, -0.4, 0.3), width=32, height=24)])
    check_scene(made)
    assert repr(made) == "Scene(seed 0/0: 4 vessels, 0 props, constant, 1 camera 32x24)"
    save_scene(made, tmp_path / "scene.json")
    back = load_scene(tmp_path / "scene.json")
    assert [type(body) for body in back.vessels] == [GlassBody, GlassBody, GlassBody, Vessel]
    assert [body.symmetric for body in back.vessels] == [True, False, False, True]
    assert back.environment == made.environment
    for one, two in zip(made.vessels, back.vessels, strict=True):
        assert np.array_equal(_outside(one).vertices, _outside(two).vertices)


def _shifted(place: tuple[float, float, float]) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def test_bodies_by_hand_have_keypoints_and_symmetries():
    wedge = prism([(0.0, 0.0), (0.03, 0.0), (0.0, 0.02)], 0.02, GLASS)
    for body in (ball(0.02, GLASS), slab((0.03, 0.02, 0.01), GLASS), wedge, vessel(BOTTLE, GLASS)):
        points = keypoints(body)
        assert points.shape == (8, 3)
        assert len(np.unique(points, axis=0)) == 8
        assert (np.abs(points) <= np.array(body.size) / 2 + 1e-6).all()
    assert symmetry_of(ball(0.02, GLASS)).ball
    assert len(symmetry_of(slab((0.03, 0.02, 0.01), GLASS)).motions) == 4  # half turns about the three axes
    assert len(symmetry_of(wedge).motions) == 1  # a right triangle of unequal legs: none but the identity
    assert symmetry_of(vessel(BOTTLE, GLASS)).turns


def test_reprs_are_one_line_without_arrays():
    body = ball(0.02, GLASS)
    assert repr(body) == str(body) == "GlassBody(2 'ball': ball of glass, 40x40x40 mm)"
    full = vessel(BOTTLE, GLASS, liquid=WATER)
    assert repr(full).startswith("Vessel(2 'vessel': vessel of glass with water, 72x72x")
    mesh = _outside(body)
    assert repr(mesh) == f"Mesh('ball': {len(mesh.vertices)} vertices, {len(mesh.faces)} faces)"
    assert "\n" not in repr(body.interfaces)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: ball(0.0, GLASS), r"ball, radius: expected a positive number"),
        (lambda: ball(float("nan"), GLASS), r"ball, radius: expected a positive number"),
        (lambda: slab((0.1, -0.1, 0.1), GLASS), r"slab, size y: expected a positive number"),
        (lambda: prism([(0, 0), (1, 0)], 0.1, GLASS), r"prism, corners: expected at least 3 rows"),
        (lambda: prism([(0, 0), (1, 0), (0.2, 0.2), (0, 1)], 0.1, GLASS), r"prism, corners: expected a convex polygon"),
        (lambda: prism([(0, 0), (1, 0), (0, 1)], 0.0, GLASS), r"prism, depth: expected a positive number"),
        (lambda: vessel([(0.03, 0.01), (0.03, 0.1)], GLASS), r"vessel, profile: expected heights that rise from 0"),
        (lambda: vessel([(0.004, 0.0), (0.03, 0.1)], GLASS), r"vessel, profile: expected radii above 5 mm"),
        (lambda: vessel(BOTTLE, GLASS, liquid=WATER, fill=1.0), r"liquid.volume: expected"),
        (
            lambda: glass_body(turned(box_mesh((0.1, 0.1, 0.1))), GLASS),
            r"body, mesh box: expected normals that point out",
        ),
        (lambda: glass_body(_torn(), GLASS), r"body, mesh box: expected a closed surface"),
        (lambda: camera((0.0, 0.0, 1.0), (0.0, 0.0, 1.0)), r"camera, target: expected a point away from the eye"),
        (lambda: scene([], []), r"scene, cameras: expected at least one, found none"),
    ],
)
def test_what_cannot_be_made_is_refused_in_one_line(make, says):
    with pytest.raises(InputError, match=says) as error:
        make()
    assert "\n" not in str(error.value)


def _torn() -> Mesh:
    box = box_mesh((0.1, 0.1, 0.1))
    return Mesh("box", box.vertices, box.faces[:-1])


def test_a_body_of_air_is_refused_by_the_check():
    with pytest.raises(InputError, match=r"ball, outside: expected two media"):
        check_scene(scene([ball(0.02, AIR, (0.0, 0.0, 0.03))], [camera((0.0, 0.5, 0.5))]))
