"""Liquids in solids of any shape: a meniscus where the wall is round, a flat surface where it is not."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh, check_closed
from glassware.procedural.cavities.interior import interior_of
from glassware.procedural.description.bodies import MeshVessel, glass_solid, liquid_solid
from glassware.procedural.description.mesh_meniscus import inner_curve
from glassware.procedural.description.mesh_vessel import mesh_vessel, refilled_mesh, with_mesh_wall
from glassware.procedural.optics.capillary import GRAVITY
from glassware.procedural.optics.catalogue import glass_named
from glassware.procedural.optics.draw import liquid_named
from glassware.procedural.profiles.liquid_surface import surface_of_volume

GLASS, WATER = glass_named("borosilicate glass 3.3"), liquid_named("water")


def vessel_of(body: trimesh.Trimesh) -> MeshVessel:
    low, high = body.bounds
    solid = Mesh("v-solid", body.vertices - 0.5 * (low + high), body.faces)
    return mesh_vessel(solid, GLASS, id=2, name="v", category="mesh")


def closed(vessel: MeshVessel) -> MeshVessel:
    check_closed("glass", glass_solid(vessel))
    check_closed("liquid", liquid_solid(vessel))
    return vessel


def test_the_wall_carries_the_weight_of_what_climbs_it(own_shapes: ModuleType) -> None:
    sections = 96
    vessel = closed(refilled_mesh(vessel_of(own_shapes.beaker(sections)), WATER, 0.5))
    liquid, radius = vessel.liquid, own_shapes.RADIUS - own_shapes.WALL
    assert liquid is not None
    assert WATER.density is not None
    assert WATER.surface_tension is not None
    assert WATER.contact_angle is not None
    area = 0.5 * sections * np.sin(2.0 * np.pi / sections) * radius**2
    # The middle of so wide a vessel is flat: what stands above its height hangs on the wall.
    raised = liquid.volume - area * (liquid.centre - vessel.cavities[0].floor)
    force = 2.0 * np.pi * radius * WATER.surface_tension * np.cos(WATER.contact_angle)
    assert raised * WATER.density * GRAVITY == pytest.approx(force, rel=0.03)
    assert liquid.contact_angle == pytest.approx(WATER.contact_angle, abs=1e-3)
    assert liquid.centre < liquid.level < liquid.contact


def test_it_is_the_surface_of_a_vessel_of_revolution_wherever_the_axis_is(own_shapes: ModuleType) -> None:
    mug = trimesh.boolean.union([own_shapes.beaker(64), own_shapes.handle(reach=0.03)], engine="manifold")
    mug = trimesh.boolean.difference(
        [mug, trimesh.creation.cylinder(0.033, height=0.1, sections=64).apply_translation([0, 0, 0.052])],
        engine="manifold",
    )
    vessel = closed(refilled_mesh(vessel_of(mug), WATER, 0.4))
    assert not vessel.symmetric
    wall = interior_of(vessel.solid).walls[0]
    assert abs(wall.centres[100, 0]) > 0.005
    liquid = vessel.liquid
    assert liquid is not None
    surface = surface_of_volume(inner_curve(wall), liquid.volume, WATER, 15e-6, GLASS)
    assert liquid.contact == pytest.approx(surface.contact, abs=5e-5)
    assert liquid.contact - liquid.centre == pytest.approx(surface.contact - surface.centre, abs=5e-5)


def test_a_square_box_and_a_full_glass_have_flat_surfaces(own_shapes: ModuleType) -> None:
    box = trimesh.creation.box((0.06, 0.06, 0.08))
    box = trimesh.boolean.difference(
        [box, trimesh.creation.box((0.054, 0.054, 0.08)).apply_translation([0, 0, 0.004])], engine="manifold"
    )
    for vessel in (
        closed(refilled_mesh(vessel_of(box), WATER, 0.5)),
        closed(refilled_mesh(vessel_of(own_shapes.beaker(48)), WATER, 0.97)),
    ):
        assert vessel.liquid is not None
        assert vessel.liquid.centre == vessel.liquid.contact == vessel.liquid.level


def test_another_wall_changes_the_meniscus_and_keeps_the_volume(own_shapes: ModuleType) -> None:
    vessel = refilled_mesh(vessel_of(own_shapes.beaker(48)), WATER, 0.5)
    other = closed(with_mesh_wall(vessel, glass_named("acrylic"), None))
    assert vessel.liquid is not None
    assert other.liquid is not None
    assert other.liquid.volume == pytest.approx(vessel.liquid.volume, rel=1e-4)
    assert other.liquid.contact_angle == pytest.approx(np.radians(70.9), abs=1e-3)
    assert other.liquid.contact < vessel.liquid.contact
