from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import Mesh, check_closed, joined, volume_of
from glassware.procedural.contents.draw import body_of
from glassware.procedural.contents.shapes import balls, rod, rounded_box
from glassware.procedural.description.filling import Body, Filled, fill_vessel
from glassware.procedural.description.mesh_vessel import mesh_vessel
from glassware.procedural.description.scene import Vessel, content_solid, glass_solid, liquid_solid
from glassware.procedural.description.stack import Pour
from glassware.procedural.description.tilted import poured_in_pose
from glassware.procedural.optics.capillary import GRAVITY
from glassware.procedural.optics.catalogue import catalogue, ice
from glassware.procedural.optics.interfacial import OIL_WATER_TENSION
from glassware.procedural.optics.medium import AIR, Medium
from glassware.procedural.optics.turbid import INTO_AIR, diffuse_reflectance, turbid_medium
from glassware.procedural.primitives.bodies import vessel
from glassware.procedural.profiles.liquid import volume_below

MEDIA = catalogue()
WATER, OIL, GLASS = MEDIA["water"], MEDIA["olive oil"], MEDIA["soda-lime glass"]
#: Facets of the meshes take part of a liquid's volume: chord errors of 15 um on 35 mm.
FACETS = 2e-3
#: An opaque body along a ray.
OPAQUE = Medium(name="opaque", eta=1.0)


def _cup() -> Vessel:
    return vessel([(0.03, 0.0), (0.036, 0.12)], GLASS)


def _filled(pours: list[Pour], *bodies: Body) -> Vessel:
    found = fill_vessel(_cup(), pours, bodies).vessel
    assert isinstance(found, Vessel)
    return found


def _cube(x: float, y: float, edge: float = 0.018, rounding: float = 0.15) -> Body:
    mesh = rounded_box((edge, edge, edge), rounding * edge, np.zeros((1, 5)), "ice")
    return body_of("ice cube", Mesh("ice", mesh.vertices + np.array([x, y, 0.0]), mesh.faces, mesh.normals), ice())


def _leaning_rod() -> Body:
    mesh = rod(0.003, 0.15, "rod")
    c, s = np.cos(0.25), np.sin(0.25)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return Body(Mesh("rod", mesh.vertices @ turn.T + np.array([-0.012, 0.016, -0.05]), mesh.faces))


@pytest.fixture(scope="module")
def drink() -> Filled:
    """Oil on water with two ice cubes, two beads, bubbles, and a rod that leans in it."""
    beads = balls(np.array([[0.0, 0.0, -0.048], [0.014, 0.0, -0.048]]), np.full(2, 0.006), "beads")
    bubbles = balls(np.array([[0.0, -0.01, -0.035], [-0.01, -0.012, -0.03]]), np.full(2, 0.001), "bubbles")
    bodies = [_cube(0.0105, -0.008), _cube(-0.0105, -0.008)]
    bodies += [body_of("beads", beads, GLASS, 2), body_of("bubbles", bubbles, AIR, 2), _leaning_rod()]
    return fill_vessel(_cup(), [Pour(OIL, 4e-5), Pour(WATER, 1.1e-4)], bodies)


def test_every_surface_has_its_two_media_along_random_rays_by_winding_numbers(drink, media_rays, rng):
    cup = drink.vessel
    pieces = [(mesh, front) for front, mesh in drink.standing[0]]
    solids = {f"content {k}": (content_solid(cup, k), content.medium) for k, content in enumerate(cup.contents)}
    solids |= {f"liquid {k}": (liquid_solid(cup, k, pieces), liquid.medium) for k, liquid in enumerate(cup.liquids)}
    solids |= {"glass": (glass_solid(cup), GLASS), "rod": (joined([mesh for mesh, _ in pieces], "rod"), OPAQUE)}
    for name, (mesh, _) in solids.items():
        check_closed(name, mesh)
    surfaces = [(part.mesh, part.front, part.back) for part in cup.interfaces]
    surfaces += [(mesh, front, OPAQUE) for mesh, front in pieces]
    met = set()
    for _ in range(25):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        origin = rng.uniform((-0.03, -0.03, -0.055), (0.03, 0.03, 0.04)) - direction
        crossings = []
        for mesh, front, back in surfaces:
            for distance, from_front in zip(*media_rays.hits(mesh, origin, direction), strict=True):
                crossings.append((distance, (front, back) if from_front else (back, front)))
        crossings.sort(key=lambda crossing: crossing[0])
        media = [AIR]
        for _, (left, entered) in crossings:
            assert media[-1].name == left.name
            media.append(entered)
        assert media[-1] == AIR
        ends = np.array([distance for distance, _ in crossings])
        long = np.flatnonzero(np.diff(ends) > 1e-5)
        points = origin + (0.5 * (ends[1:] + ends[:-1]))[long, None] * direction
        inside = {name: media_rays.winding(mesh, points) for name, (mesh, _) in solids.items()}
        for row, k in enumerate(long):
            found = [solids[name][1].name for name, values in inside.items() if values[row] == 1.0]
            assert found == ([] if media[k + 1] == AIR and not found else [media[k + 1].name])
            met.add(media[k + 1].name)
    assert met == {"air", "water", "olive oil", "ice", "soda-lime glass", "opaque"}


def test_liquids_have_their_volume_whatever_is_in_them(drink):
    cup = drink.vessel
    pieces = [(mesh, front) for front, mesh in drink.standing[0]]
    for number, (liquid, wanted) in enumerate(zip(cup.liquids, (1.1e-4, 4e-5), strict=True)):
        assert liquid.volume == wanted
        assert volume_of(liquid_solid(cup, number, pieces)) == pytest.approx(wanted, rel=FACETS)


def test_what_floats_takes_its_own_weight_of_water_and_raises_the_level():
    sharp = _cube(0.0, 0.0, rounding=0.02)
    alone, with_ice = _filled([Pour(WATER, 1.5e-4)]), _filled([Pour(WATER, 1.5e-4)], sharp)
    cube = with_ice.contents[0]
    parts = [part.mesh for part in with_ice.interfaces if part.content == 0 and part.front == AIR]
    dry = max(mesh.bounds[1, 2] for mesh in parts) - with_ice.liquids[0].centre
    # The part of a box above the water is that of the densities (Archimedes).
    assert dry / cube.size[2] == pytest.approx(1.0 - 916.7 / 998.2, abs=0.004)
    inner = np.array(alone.inner)
    risen = volume_below(inner, with_ice.liquids[0].level) - volume_below(inner, alone.liquids[0].level)
    assert risen == pytest.approx(cube.volume * 916.7 / 998.2, rel=0.02)


def test_ice_sinks_in_oil_and_stops_where_water_begins():
    in_oil = _filled([Pour(OIL, 1.5e-4)], _cube(0.0, 0.0))
    assert in_oil.contents[0].centre[2] - 0.009 - in_oil.inner[0][1] < 3e-3
    both = _filled([Pour(OIL, 6e-5), Pour(WATER, 1e-4)], _cube(0.0, 0.0))
    # 916.7 lies between 911.4 and 998.2: nearly all of it is in the oil.
    assert both.contents[0].centre[2] - both.liquids[0].centre == pytest.approx(0.009, abs=1.5e-3)


def test_oil_on_water_meets_the_wall_in_a_capillary_surface_of_its_own():
    wide = vessel([(0.075, 0.0), (0.075, 0.09)], GLASS)
    cup = fill_vessel(wide, [Pour(OIL, 3e-4), Pour(WATER, 5e-4)]).vessel
    water, oil = cup.liquids
    # Water pulls 65.9 mN/m up the glass, oil 30.1: more than the 24.5 of their interface, so water spreads under oil.
    angle = np.radians(10.0)
    length = np.sqrt(OIL_WATER_TENSION / ((998.2 - 911.4) * GRAVITY))
    # On a flat wall a surface climbs by this (de Gennes et al. 2004, eq. 2.17); a wall of 73 mm hardly curves.
    assert water.contact_angle == pytest.approx(angle)
    assert water.contact - water.centre == pytest.approx(length * np.sqrt(2.0 * (1.0 - np.sin(angle))), rel=0.05)
    assert oil.contact - oil.centre < 0.5 * (water.contact - water.centre)


def test_glycerol_under_oil_is_level_as_their_tension_is_not_known():
    cup = fill_vessel(_cup(), [Pour(OIL, 6e-5), Pour(MEDIA["glycerol"], 1e-4)]).vessel
    assert cup.liquids[0].contact == cup.liquids[0].centre


@pytest.mark.parametrize(
    ("pours", "line"),
    [
        ([Pour(WATER, 5e-5), Pour(MEDIA["ethanol"], 5e-5)], "liquids that do not mix, such as water and olive oil"),
        ([Pour(WATER, 9e-5), Pour(OIL, 1e-6)], "found 1ml"),
        ([Pour(WATER, 3e-4), Pour(OIL, 3e-4)], "below the rim"),
        ([Pour(WATER, 5e-5), Pour(Medium(name="own", eta=1.4), 5e-5)], "expected a density of each, found none of own"),
    ],
)
def test_liquids_that_cannot_lie_on_each_other_are_refused(pours, line):
    with pytest.raises(InputError, match="vessel, liquids: expected") as error:
        fill_vessel(_cup(), pours)
    assert line in str(error.value)


def test_a_leaning_vessel_has_level_liquids_of_the_same_volume():
    pose, tilt = np.eye(4), np.radians(25.0)
    pose[:3, :3] = [[np.cos(tilt), 0.0, np.sin(tilt)], [0.0, 1.0, 0.0], [-np.sin(tilt), 0.0, np.cos(tilt)]]
    cup = poured_in_pose(_cup(), pose, [Pour(WATER, 1e-4), Pour(OIL, 3e-5)])
    tops = [part.mesh for part in cup.interfaces if part.part in ("liquid_interface", "liquid_surface")]
    for number, (liquid, top) in enumerate(zip(cup.liquids, tops, strict=True)):
        solid = liquid_solid(cup, number)
        check_closed("liquid", solid)
        assert volume_of(solid) == pytest.approx(liquid.volume, rel=FACETS)
        heights = top.vertices.astype(float) @ pose[:3, :3].T @ np.array([0.0, 0.0, 1.0])
        np.testing.assert_allclose(heights, liquid.level, atol=1e-7)
    check_closed("glass", glass_solid(cup))


def test_a_lying_cup_holds_nothing():
    pose = np.eye(4)
    pose[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    with pytest.raises(InputError, match="vessel, liquids: expected none in this pose, as all flows out, found 50ml"):
        poured_in_pose(_cup(), pose, [Pour(WATER, 5e-5)])
    assert poured_in_pose(_cup(), pose, []).liquid is None


def test_milk_reflects_as_was_measured():
    # Jensen et al. 2001, figure 5: diffuse reflectance of whole and skimmed milk in air.
    for name, measured in (("milk", (0.91, 0.88, 0.76)), ("skimmed milk", (0.81, 0.81, 0.69))):
        np.testing.assert_allclose(diffuse_reflectance(name, INTO_AIR), measured, atol=0.02)


def test_turbid_liquids_are_opaque_from_the_glass_and_from_the_air():
    cup = fill_vessel(_cup(), [Pour(turbid_medium("milk"), 1e-4)]).vessel
    assert cup.liquids[0].turbid
    looks = {part.part: (part.opaque is not None, part.seen_from_back) for part in cup.interfaces}
    assert looks == {"outside": (False, False), "wet_wall": (True, True), "liquid_surface": (True, False)}


def test_thin_layers_have_the_volume_that_is_recorded_where_levels_keep_away_from_vertices():
    """A wall with a vertex every 30 um: each level moves up to 15 um, a percent of a layer of 1.2 mm."""
    heights = np.arange(0.003, 0.012, 3e-5)
    wall = [(0.0, 0.002), *((0.03, z) for z in heights), (0.03, 0.06), (0.034, 0.06), (0.034, 0.0), (0.0, 0.0)]
    body = trimesh.creation.revolve(np.array(wall)[::-1], sections=16)
    assert body.is_watertight
    assert body.volume > 0.0
    shape = Mesh("v-solid", body.vertices - 0.5 * body.bounds.sum(0), body.faces)
    own = mesh_vessel(shape, GLASS, id=2, name="v", category="mesh")
    made = fill_vessel(own, [Pour(WATER, 1.2e-5), Pour(OIL, 3.3e-6)]).vessel
    for number, (liquid, asked) in enumerate(zip(made.liquids, (1.2e-5, 3.3e-6), strict=True)):
        assert liquid.volume == pytest.approx(volume_of(liquid_solid(made, number)), rel=1e-5)
        assert liquid.volume == pytest.approx(asked, rel=0.02)
        assert liquid.fill == pytest.approx(liquid.volume / own.cavities[0].volume)
