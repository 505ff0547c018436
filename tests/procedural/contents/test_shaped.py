"""What is in vessels that are no solids of revolution: apart from their glass, at rest, and in media that fit."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from glassware.core.mesh import check_closed, volume_of
from glassware.core.randomness import stream
from glassware.procedural.contents.draw import Drawn, draw_contents
from glassware.procedural.contents.room import MeshRoom, room_of
from glassware.procedural.contents.settings import ContentsSettings
from glassware.procedural.description.bodies import MeshVessel
from glassware.procedural.description.filling import VOLUME_ERROR
from glassware.procedural.description.mesh_vessel import mesh_vessel
from glassware.procedural.description.scene import content_solid, glass_solid, liquid_solid
from glassware.procedural.description.standing import standing_in
from glassware.procedural.optics.catalogue import soda_lime, water
from glassware.procedural.optics.medium import AIR
from glassware.procedural.primitives.bodies import vessel
from glassware.procedural.shaped_vessels.draw import SHAPERS, draw_shaped_vessel
from glassware.procedural.vessels.settings import VesselSettings

#: As good as always, but not a demand.
ALMOST_SURE = 1.0 - 1e-9
QUICK = [pytest.param(name, marks=() if name == "square glass" else pytest.mark.slow) for name in SHAPERS]
#: Least distance of bodies from the glass, and the farthest that what lies or leans is from it [m]: the gap of bodies
#: at rest is 0.1 mm, and the floor is known along lines half a millimetre apart.
NEAREST, TOUCHES = 1e-5, 6e-4


@lru_cache
def drawn(category: str) -> tuple[MeshVessel, Drawn]:
    chosen = {"categories": [category], "fill_probability": 1.0, "fill": (0.4, 0.6), "chord_error": 2e-4}
    settings, given = VesselSettings.model_validate(chosen), {"id": 2, "name": "vessel", "glass": soda_lime()}
    empty, _ = draw_shaped_vessel(stream(2, 0, "vessel"), settings, **given, liquid_medium=water())
    small = {"ice": ALMOST_SURE, "ice_edge": (0.01, 0.012), "ice_count": (1, 2), "beads": ALMOST_SURE, "turbid": 0.0}
    wanted = small | {"bead_count": (3, 3), "bubbles": ALMOST_SURE, "standing": ALMOST_SURE, "layered": 0.0}
    contents = ContentsSettings.model_validate(wanted)
    return empty, draw_contents(lambda kind: stream(2, 0, kind), contents, empty, may_stand=True)


def pieces_of(found: Drawn) -> list:
    return [piece for other in standing_in([found.vessel, *found.standing], found.vessel) for piece in other.pieces]


@pytest.mark.parametrize("category", QUICK)
def test_it_has_room_touches_where_it_lies_and_has_closed_surfaces(category):
    empty, found = drawn(category)
    room = room_of(empty)
    assert isinstance(room, MeshRoom)
    assert {content.kind for content in found.vessel.contents} == {"ice cube", "beads", "bubbles"}
    check_closed("glass", glass_solid(found.vessel))
    check_closed("liquid", liquid_solid(found.vessel, 0, pieces_of(found)))
    for number, content in enumerate(found.vessel.contents):
        body = content_solid(found.vessel, number)
        check_closed(content.kind, body)
        away = float(room.clearance(body.vertices.astype(np.float64)).min())
        assert away > NEAREST
        if content.kind == "beads":
            assert away < TOUCHES
    assert category == "teapot" or len(found.standing) == 1  # a spout is in the way of what would lean
    for other in standing_in([found.vessel, *found.standing], found.vessel):
        away = room.clearance(other.solid.vertices.astype(np.float64))
        assert NEAREST < away.min() < TOUCHES


@pytest.mark.parametrize("category", QUICK)
def test_the_liquid_is_level_keeps_its_volume_and_carries_the_ice(category):
    empty, found = drawn(category)
    assert empty.liquid is not None
    liquid = found.vessel.liquids[0]
    assert liquid.volume == pytest.approx(empty.liquid.volume, rel=VOLUME_ERROR)
    assert volume_of(liquid_solid(found.vessel, 0, pieces_of(found))) == pytest.approx(liquid.volume, rel=1e-5)
    surface = next(part.mesh for part in found.vessel.interfaces if part.part == "liquid_surface")
    assert np.ptp(surface.vertices[:, 2]) == 0.0
    assert liquid.level > empty.liquid.level  # what is in it displaces it
    for number, content in enumerate(found.vessel.contents):
        if content.kind == "ice cube":
            dry = [p.mesh for p in found.vessel.interfaces if p.content == number and p.front == AIR]
            above = sum(mesh.bounds[1, 2] for mesh in dry) - liquid.level
            assert 0.0 < above < 0.2 * content.size[2]  # a twelfth by volume, more by height of a rounded cube


@pytest.mark.parametrize("category", QUICK)
def test_media_alternate_along_random_rays(category, media_rays, rng):
    _, found = drawn(category)
    surfaces = [(part.mesh, part.front.name, part.back.name) for part in found.vessel.interfaces]
    surfaces += [(mesh, front.name, "inside") for mesh, front in pieces_of(found)]
    met = set()
    half = 0.5 * np.array(found.vessel.size)
    for _ in range(25):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        origin = half * rng.uniform(-0.7, 0.7, 3) - direction
        crossings = []
        for mesh, front, back in surfaces:
            for distance, from_front in zip(*media_rays.hits(mesh, origin, direction), strict=True):
                crossings.append((distance, (front, back) if from_front else (back, front)))
        now = "air"
        for _, (left, entered) in sorted(crossings, key=lambda crossing: crossing[0]):
            assert left == now
            now = entered
            met.add(now)
        assert now == "air"
    assert {"water", "soda-lime glass", "air"} < met


def test_a_round_cavity_is_the_same_room_by_its_mesh_as_by_its_profile(rng):
    made = vessel([(0.03, 0.0), (0.036, 0.12)], soda_lime())
    profile = room_of(made)
    solid = glass_solid(made)
    mesh = room_of(_as_mesh_vessel(solid))
    assert profile is not None
    assert mesh is not None
    assert mesh.floor == pytest.approx(profile.floor, abs=1e-4)
    assert mesh.narrowest(-0.04, 0.04) == pytest.approx(profile.narrowest(-0.04, 0.04), abs=1e-4)
    points = rng.uniform((-0.04, -0.04, -0.06), (0.04, 0.04, 0.06), (400, 3))
    wanted = profile.clearance(points)
    near = np.abs(wanted) < 3e-3
    np.testing.assert_allclose(mesh.clearance(points)[near], wanted[near], atol=1e-4)  # chords, float32
    np.testing.assert_array_equal(mesh.clearance(points)[~near] < 0.0, wanted[~near] < 0.0)


def _as_mesh_vessel(solid) -> MeshVessel:
    return mesh_vessel(replace(solid, name="round-solid"), soda_lime(), id=2, name="round", category="glass")
