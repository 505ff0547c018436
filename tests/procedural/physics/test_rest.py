"""What counts as rest: not the moment at which something turns, nor slow rolling."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from glassware.core.mesh import Mesh
from glassware.procedural.physics.bodies import Mechanics
from glassware.procedural.physics.mass import solid_mass
from glassware.procedural.physics.parts import BodyParts
from glassware.procedural.physics.rest import STILL_DISTANCE, comes_to_rest, moved
from glassware.procedural.physics.world import RigidBody, World, advance, build_world, contacts, let_go, poses

BOARD = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
#: Largest gap between bodies that touch, and most that they may overlap [m].
GAP, OVERLAP = 2.5e-4, 1e-4


def _body(shape: trimesh.Trimesh, pose: np.ndarray) -> RigidBody:
    whole = solid_mass(Mesh("shape", shape.vertices, shape.faces), 700.0)
    return RigidBody(
        BodyParts(np.array(shape.vertices), ()),
        Mechanics(whole=whole, density=700.0, friction=0.4, source="test"),
        pose,
    )


def _at(height: float, turn: Rotation | None = None, x: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = (turn or Rotation.identity()).as_matrix()
    pose[:3, 3] = (x, 0.0, height)
    return pose


def _world(*bodies: RigidBody) -> World:
    world = build_world(bodies, BOARD, 0.4)
    for number in range(len(bodies)):
        let_go(world, number)
    return world


def _rests(world: World, seconds: float = 8.0) -> bool:
    every = np.ones(len(world.radii), dtype=bool)
    return comes_to_rest(world, every, seconds, lambda now: False)[0]


def test_three_boxes_fall_onto_each_other_and_stay_as_a_stack():
    box = trimesh.creation.box((0.10, 0.08, 0.04))
    world = _world(*(_body(box, _at(0.03 + 0.06 * level)) for level in range(3)))
    assert _rests(world)
    heights = poses(world)[:, 2, 3]
    bottoms = heights - 0.02
    np.testing.assert_array_less(-OVERLAP, bottoms - [0.0, *(heights[:2] + 0.02)])
    np.testing.assert_array_less(bottoms - [0.0, *(heights[:2] + 0.02)], GAP)
    assert contacts(world) == {(-1, 0), (0, 1), (1, 2)}


def test_a_slab_on_its_edge_out_of_balance_by_two_degrees_is_not_at_rest_before_it_lies():
    slab = trimesh.creation.box((0.10, 0.02, 0.15))
    world = _world(_body(slab, _at(0.0755, Rotation.from_euler("x", 9.6, degrees=True))))
    assert _rests(world)
    assert abs(poses(world)[0, 2, 2]) < 0.05


def test_a_cylinder_rolls_until_it_stops_and_then_stays():
    rod = trimesh.creation.cylinder(0.03, 0.1, sections=96)
    world = _world(_body(rod, _at(0.0302, Rotation.from_euler("x", 90, degrees=True))))
    world.data.qvel[:6] = [0.1, 0.0, 0.0, 0.0, 0.0, -0.1 / 0.03]
    assert not _rests(world, 0.9)
    assert _rests(world)
    before = poses(world)
    assert before[0, 0, 3] > 0.005
    advance(world, 3.0)
    assert moved(before, poses(world), world.radii).max() < 3.0 * STILL_DISTANCE


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_movement_is_that_of_the_farthest_point(angle):
    turned = np.eye(4)
    turned[:3, :3] = Rotation.from_euler("z", angle).as_matrix()
    turned[0, 3] = 0.01
    found = moved(np.eye(4)[None], turned[None], np.array([0.2]))
    assert found == pytest.approx(0.01 + 0.2 * 2.0 * np.sin(angle / 2.0))
