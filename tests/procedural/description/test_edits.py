"""Changed copies of scenes: what a picture shows and what a label says stay the same thing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glassware.core.errors import InputError
from glassware.core.mesh import volume_of
from glassware.procedural.description.refill import refilled, section_of
from glassware.procedural.description.scene import MeshVessel, Vessel, liquid_solid
from glassware.procedural.optics.catalogue import catalogue, water
from glassware.procedural.optics.wetting import contact_angle
from glassware.procedural.primitives.bodies import ball
from glassware.procedural.profiles.liquid import brimful_volume
from glassware.procedural.profiles.liquid_surface import LEAST_ANGLE
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.scene_file import load_scene, save_scene, scene_digest
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene
from glassware.procedural.vessels.settings import REVOLVED, SHAPED

OIL = catalogue()["olive oil"]
#: Meshes hold single precision: rounding of a normal, and of a coordinate below 1 m.
ROUNDING = 1.2e-7
#: Relative difference between a liquid's volume and that of its mesh, whose facets cut the circle.
FACETS = 2e-2


#: Nothing in the vessels but one clear liquid, no parts, nothing that lies: one thing is changed at a time.
PLAIN = {"layered": 0.0, "turbid": 0.0, "ice": 0.0, "beads": 0.0, "bubbles": 0.0, "standing": 0.0}
BARE = {"closed_probability": 0.0, "label_probability": 0.0, "contents": PLAIN, "chord_error": 2e-4}


def _drawn(seed, vessels, count=1, props=0):
    settings = {
        "vessel_count": (count, count),
        "prop_count": (props, props),
        "vessels": BARE | vessels,
        "props": {"kinds": ["shape"]},
        "physics": {"piled_probability": 0.0, "lying_probability": 0.0},
        "environment": {"room_share": 0.0, "shipped_share": 0.0},
    }
    return draw_scene(SceneSettings.model_validate(settings), seed, 0)


@pytest.fixture(scope="module")
def scene():
    vessels = {"fill_probability": 1.0, "liquids": ["water"], "categories": ["beaker", "bowl"]}
    return _drawn(3, vessels, count=2, props=1)


@pytest.fixture(scope="module")
def iced():
    """A tumbler of water with ice and a straw."""
    contents = PLAIN | {"ice": 1.0, "ice_count": (2, 2), "standing": 1.0, "standing_kinds": ["straw"]}
    vessels = {"fill_probability": 1.0, "liquids": ["water"], "categories": ["tumbler"], "fill": (0.4, 0.5)}
    return _drawn(3, vessels | {"contents": contents})


@pytest.fixture(scope="module")
def closed():
    """An empty jar with a label and a lid."""
    parts = {"closed_probability": 1.0, "label_probability": 1.0}
    return _drawn(4, {"fill_probability": 0.0, "categories": ["jar"]} | parts, props=1)


def test_another_liquid_brings_its_surface_its_meshes_and_its_media(scene):
    changed = scene.with_liquid("vessel-00", "olive oil", fill="120ml")
    check_scene(changed)
    vessel = changed.vessels[0]
    assert vessel.liquid.medium == OIL
    assert vessel.liquid.volume == pytest.approx(1.2e-4, rel=1e-5)
    assert vessel.liquid.fill == pytest.approx(1.2e-4 / brimful_volume(np.array(vessel.inner)), rel=1e-5)
    assert vessel.liquid.contact_angle == pytest.approx(contact_angle(OIL, vessel.glass), abs=1e-6)
    assert volume_of(liquid_solid(vessel)) == pytest.approx(1.2e-4, rel=FACETS)
    media = {part.part: (part.front.name, part.back.name) for part in vessel.interfaces}
    assert media["wet_wall"] == ("olive oil", vessel.glass.name)
    assert media["liquid_surface"] == ("air", "olive oil")
    # What is not the liquid's stays: the other objects, the place, the outside, the profiles.
    assert (changed.vessels[1:], changed.props) == (scene.vessels[1:], scene.props)
    assert vessel.outer == scene.vessels[0].outer
    np.testing.assert_array_equal(vessel.world_T_object, scene.vessels[0].world_T_object)


@pytest.mark.parametrize("category", REVOLVED)
@pytest.mark.parametrize("filled", [0.0, 1.0])
def test_curves_are_read_back_from_the_meshes_of_every_family_of_revolution(category, filled):
    vessel = _drawn(5, {"fill_probability": filled, "liquids": ["ethanol"], "categories": [category]}).vessels[0]
    assert isinstance(vessel, Vessel)
    outer, inner, _ = section_of(vessel)
    for curve in (outer, inner):
        np.testing.assert_allclose(np.hypot(*curve.normals.T), 1.0, atol=1e-12)
    empty = refilled(vessel, None)
    assert (empty.liquid, [part.part for part in empty.interfaces]) == (None, ["outside"])
    if not filled:
        before, after = vessel.interfaces[0].mesh, empty.interfaces[0].mesh
        np.testing.assert_array_equal(after.vertices, before.vertices)
        np.testing.assert_array_equal(after.faces, before.faces)
        np.testing.assert_allclose(np.array(after.normals), np.array(before.normals), atol=ROUNDING)
    full = refilled(empty, water(), 0.4).liquid
    assert full is not None
    assert full.fill == pytest.approx(0.4, rel=1e-5)


@pytest.mark.parametrize(
    "category",
    [pytest.param(name, marks=() if name in ("mug", "square glass") else pytest.mark.slow) for name in sorted(SHAPED)],
)
def test_a_vessel_of_any_shape_is_emptied_and_filled_again(category):
    scene = _drawn(5, {"fill_probability": 1.0, "liquids": ["water"], "categories": [category]})
    (vessel,) = scene.vessels
    assert isinstance(vessel, MeshVessel)
    empty = scene.with_liquid(vessel.name, None)
    check_scene(empty)
    assert [part.part for part in empty.vessels[0].interfaces] == ["outside"]
    again = empty.with_liquid(vessel.name, "ethanol", 0.3)
    check_scene(again)
    liquid = again.vessels[0].liquid
    assert liquid is not None
    assert liquid.fill == pytest.approx(0.3, rel=1e-4)


def test_a_straw_goes_with_its_vessel_and_takes_no_pose_of_its_own(iced):
    straw = next(item for item in iced.objects if item.within)
    assert iced.without("vessel-00").objects == ()
    pose = iced.vessels[0].world_T_object.copy()
    pose[:3, 3] += (0.02, 0.01, 0.3)
    moved = iced.with_pose("vessel-00", pose)
    check_scene(moved)
    there = next(item for item in moved.objects if item.name == straw.name)
    np.testing.assert_allclose(there.world_T_object[:3, 3] - straw.world_T_object[:3, 3], (0.02, 0.01, 0.3), atol=1e-12)
    with pytest.raises(InputError, match=rf"^{straw.name}: expected a pose of the vessel that it stands in"):
        iced.with_pose(straw.name, pose)


def test_a_vessel_is_not_tilted_with_what_is_in_it(iced):
    (vessel,) = iced.vessels
    pose = vessel.world_T_object.copy()
    pose[:3, :3] = Rotation.from_euler("x", 5.0, degrees=True).as_matrix() @ pose[:3, :3]
    pose[2, 3] += 0.3
    expected = "a pose in which its water stays as it is, found one tilted by 5 degrees"
    with pytest.raises(InputError, match=rf"^vessel-00, world_T_object: expected {expected}$"):
        iced.with_pose("vessel-00", pose)
    with pytest.raises(InputError, match=expected):
        iced.without("vessel-00").add(vessel.model_copy(update={"world_T_object": pose}))
    with pytest.raises(InputError, match=expected):
        check_scene(iced.model_copy(update={"vessels": (vessel.model_copy(update={"world_T_object": pose}),)}))
    rounded = vessel.world_T_object.copy()
    rounded[:3, :3] *= 1.0 - 4e-7  # as of poses typed with seven digits
    iced.with_pose("vessel-00", rounded)
    turned = vessel.world_T_object @ np.diag([-1.0, -1.0, 1.0, 1.0])
    assert np.array_equal(iced.with_pose("vessel-00", turned).vessels[0].world_T_object, turned)


def test_without_its_straw_a_liquid_keeps_its_volume_and_falls(iced):
    straw = next(item for item in iced.objects if item.within)
    alone = iced.without(straw.name)
    check_scene(alone)
    before, after = iced.vessels[0].liquid, alone.vessels[0].liquid
    assert after.volume == pytest.approx(before.volume, rel=1e-5)
    assert after.level < before.level
    assert [content.kind for content in alone.vessels[0].contents] == ["ice cube", "ice cube"]


def test_ice_floats_and_a_straw_is_wetted_in_the_new_liquid(iced):
    changed = iced.with_liquid("vessel-00", "fruit juice" if "fruit juice" in catalogue() else "glycerol")
    check_scene(changed)
    medium = changed.vessels[0].liquid.medium
    ice = [part.front for part in changed.vessels[0].interfaces if part.part == "content"]
    straw = next(item for item in changed.objects if item.within)
    assert medium in ice
    assert medium in [piece.surrounding for piece in straw.pieces]
    assert iced.vessels[0].liquid.medium not in [*ice, *(piece.surrounding for piece in straw.pieces)]
    # Ice of 917 kg/m^3 lies higher in a denser liquid.
    higher = [new.centre[2] - changed.vessels[0].liquid.level for new in changed.vessels[0].contents]
    lower = [old.centre[2] - iced.vessels[0].liquid.level for old in iced.vessels[0].contents]
    assert sum(higher) > sum(lower)


def test_parts_go_with_their_vessel(closed):
    (jar,) = closed.vessels
    parts = [item for item in closed.objects if item.part_of]
    assert {item.part_of for item in parts} == {jar.name}
    assert {item.category for item in parts} == {"lid", "label"}
    alone = closed.without(jar.name)
    assert [item.name for item in alone.objects] == ["prop-00"]
    pose = jar.world_T_object.copy()
    pose[2, 3] += 0.4
    lifted = closed.with_pose(jar.name, pose)
    check_scene(lifted)
    for before, after in zip(closed.objects, lifted.objects, strict=True):
        rise = after.world_T_object[2, 3] - before.world_T_object[2, 3]
        assert rise == pytest.approx(0.0 if before.name == "prop-00" else 0.4, abs=1e-12)
    check_scene(closed.without(parts[0].name))


def test_a_liquid_keeps_its_volume_where_nobody_says_another(scene):
    changed = scene.with_liquid("vessel-00", "ethanol")
    assert changed.vessels[0].liquid.volume == pytest.approx(scene.vessels[0].liquid.volume, rel=1e-5)
    emptied = scene.with_liquid("vessel-00", None)
    assert emptied.vessels[0].liquid is None
    check_scene(emptied)
    assert emptied.with_liquid("vessel-00", "water").vessels[0].liquid.fill == pytest.approx(0.5, rel=1e-5)


def test_another_wall_changes_the_surface_where_the_liquid_wets_it_otherwise(scene):
    glass, plastic = (scene.with_glass("vessel-00", name).vessels[0] for name in ("fused silica", "acrylic"))
    assert glass.liquid == scene.vessels[0].liquid
    assert plastic.liquid.contact_angle == pytest.approx(np.radians(70.9), abs=1e-6)
    assert plastic.liquid.contact - plastic.liquid.centre < glass.liquid.contact - glass.liquid.centre
    assert plastic.liquid.contact_angle > LEAST_ANGLE
    check_scene(scene.with_glass("vessel-00", "acrylic"))


def test_objects_are_moved_left_out_and_added(scene):
    first = scene.vessels[0]
    pose = first.world_T_object.copy()
    pose[2, 3] += 0.3
    lifted = scene.with_pose("vessel-00", pose)
    np.testing.assert_array_equal(lifted.vessels[0].world_T_object, pose)
    check_scene(lifted)
    alone = scene.without("vessel-00", "prop-00")
    assert [item.name for item in alone.objects] == ["vessel-01"]
    check_scene(alone)
    again = scene.without("vessel-00").add(first)
    assert [item.name for item in again.objects] == [item.name for item in scene.objects]
    assert scene_digest(again.without("vessel-01", "prop-00")) == scene_digest(scene.without("vessel-01", "prop-00"))
    lens = ball(0.02, catalogue()["fused silica"], centre=(0.0, 0.0, 0.5), name="lens", chord_error=2e-4)
    added = scene.add(lens)
    assert added.vessels[-1].id == max(item.id for item in scene.objects) + 1
    check_scene(added)


def test_a_body_of_another_scene_is_added_with_an_id_and_meshes_of_its_own(scene, tmp_path):
    pose = scene.vessels[0].world_T_object.copy()
    pose[2, 3] += 0.3
    twin = scene.vessels[0].model_copy(update={"name": "twin of vessel-00", "world_T_object": pose})
    both = scene.add(twin)
    save_scene(both, tmp_path / "scene.json")
    stored = load_scene(tmp_path / "scene.json")
    assert [item.name for item in stored.vessels] == ["vessel-00", "vessel-01", "twin of vessel-00"]
    assert scene_digest(stored.without("twin of vessel-00")) == scene_digest(scene)
    # And its liquid can still be changed.
    assert both.with_liquid("twin of vessel-00", "ethanol").vessels[-1].liquid.medium.name == "ethanol"


def _sunk(scene):
    pose = scene.vessels[0].world_T_object.copy()
    pose[2, 3] -= 0.01
    return scene.with_pose("vessel-00", pose)


def _in_the_other(scene):
    pose = scene.vessels[0].world_T_object.copy()
    pose[:2, 3] = scene.vessels[1].world_T_object[:2, 3]
    return scene.with_pose("vessel-00", pose)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda s: s.with_liquid("vessel-00", "olive oill"), "(is it olive oil?), found 'olive oill'"),
        (lambda s: s.with_liquid("vesel-00", "water"), "(is it vessel-00?), found 'vesel-00'"),
        (lambda s: s.with_liquid("vessel-00", 3), "liquid: expected a Medium, its name in the catalogue, or None"),
        (lambda s: s.with_liquid("vessel-00", "water", "9l"), "vessel-00, fill: expected at most "),
        (lambda s: s.with_liquid("vessel-00", "water", 1.0), "vessel-00, fill: expected more than 0 and at most 0.9"),
        (lambda s: s.with_liquid("vessel-00", "water", "x"), "vessel-00, fill: expected a volume in ml, cl or l"),
        (lambda s: s.with_liquid("vessel-00", None, 0.5), "vessel-00, fill: expected none without a liquid, found 0.5"),
        (_sunk, "vessel-00: expected an object above the table's top (z = 0), found 9.9 mm below it"),
        (
            _in_the_other,
            "vessel-00: expected a place of its own (up to 0.5 mm), found that it overlaps vessel-01",
        ),
        (lambda s: s.with_pose("vessel-00", np.eye(3)), "world_T_object: expected a 4x4 matrix of finite numbers"),
        (lambda s: s.with_pose("vessel-00", 2 * np.eye(4)), "world_T_object: expected a rigid pose"),
        (lambda s: s.without("prp-00"), "found 'prp-00' (is it prop-00?)"),
        (lambda s: s.add(s.props[0]), "prop-00, name: expected one of its own"),
        (lambda s: s.add("a ball"), "add: expected bodies: vessels, other glass bodies, or props, found 'a ball'"),
    ],
)
def test_a_change_that_cannot_be_is_one_line(scene, change, line):
    with pytest.raises(InputError) as error:
        change(scene)
    assert line in str(error.value)
    assert "\n" not in str(error.value)


def test_what_has_no_inside_takes_no_liquid(scene):
    lens = ball(0.02, catalogue()["fused silica"], centre=(0.0, 0.0, 0.5), name="lens", chord_error=2e-4)
    with pytest.raises(InputError, match=r"^lens, liquid: expected a vessel, which has an inside, found a ball$"):
        scene.add(lens).with_liquid("lens", "water")


@pytest.mark.parametrize(
    ("field", "value", "line"),
    [
        ("fill", 0.9, "vessel-00, liquid, fill: expected that of its volume"),
        ("contact", 0.0, "vessel-00, liquid, contact: expected that of its surface"),
        ("centre", 0.0, "vessel-00, liquid, centre: expected that of its surface"),
        ("level", 0.0, "vessel-00, liquid, level: expected that of its surface"),
        (
            "medium",
            catalogue()["olive oil"],
            "vessel-00, wet_wall, front: expected its liquid (olive oil), found water",
        ),
    ],
)
def test_a_plain_copy_whose_label_says_something_else_is_refused(scene, field, value, line):
    vessel = scene.vessels[0]
    assert vessel.liquid is not None
    liquid = vessel.liquid.model_copy(update={field: value})
    changed = scene.model_copy(update={"vessels": (vessel.model_copy(update={"liquid": liquid}), *scene.vessels[1:])})
    with pytest.raises(InputError) as error:
        check_scene(changed)
    assert str(error.value).startswith(line)


def test_a_rod_in_milk_shows_its_colour_and_in_water_again_what_is_behind():
    """Light went from the rod into milk, where none travels: pictures were refused."""
    contents = PLAIN | {"turbid": 1.0, "turbid_liquids": ["milk"], "standing": 1.0, "standing_kinds": ["stirring rod"]}
    scene = _drawn(3, {"fill_probability": 1.0, "categories": ["beaker"], "fill": (0.4, 0.5), "contents": contents})
    for changed, turbid in ((scene, True), (scene.with_liquid("vessel-00", "water", 0.3), False)):
        check_scene(changed)
        (rod,) = [item for item in changed.vessels if item.within]
        wet = [part for part in rod.interfaces if part.front.name != "air"]
        assert wet
        for part in wet:
            assert (part.opaque is not None, part.seen_from_back) == (turbid, turbid), part.front.name
        (dry,) = [part for part in rod.interfaces if part.front.name == "air"]
        assert dry.opaque is None
