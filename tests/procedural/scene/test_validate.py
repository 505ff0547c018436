from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.mesh import Mesh, turned, volume_of
from glassware.core.pose import check_rigid
from glassware.procedural.description.camera import LONGEST_SIDE
from glassware.procedural.description.refill import ring_segments
from glassware.procedural.description.scene import Scene, Vessel, liquid_solid
from glassware.procedural.description.surroundings import ROOM_IDS, AreaLight
from glassware.procedural.placement import overlap
from glassware.procedural.primitives.bodies import ball
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import LARGEST_ID, check_scene
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.procedural.vessels.settings import VesselSettings

SETTINGS = SceneSettings(
    vessel_count=(3, 3),
    prop_count=(3, 3),
    vessels=VesselSettings(fill_probability=1.0, chord_error=60e-6),
    environment=EnvironmentSettings(room_share=0.0, shipped_share=0.0),
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return draw_scene(SETTINGS, 7, 0)


def _with(scene: Scene, index: int = 0, part: int | None = None, **changes: object) -> Scene:
    """The scene with a vessel, or one of its interfaces, changed without validation."""
    vessel = scene.vessels[index]
    if part is not None:
        interfaces = list(vessel.interfaces)
        interfaces[part] = interfaces[part].model_copy(update=changes)
        changes = {"interfaces": tuple(interfaces)}
    vessels = list(scene.vessels)
    vessels[index] = vessel.model_copy(update=changes)
    return scene.model_copy(update={"vessels": tuple(vessels)})


def _moved(pose: np.ndarray, shift: np.ndarray) -> np.ndarray:
    pose = pose.copy()
    pose[:3, 3] += shift
    return pose


@pytest.mark.parametrize("factor", [0.985, 1.0, 1.015])
def test_a_liquid_in_coarse_rings_has_the_volume_of_its_circles(factor):
    """Rings of few segments hold less than their circle, which is no fault; 1.5 % of the volume is one."""
    tubes = VesselSettings(categories=("test tube",), fill_probability=1.0, chord_error=200e-6)
    scene = draw_scene(SceneSettings(vessel_count=(1, 1), prop_count=(0, 0), vessels=tubes), 7, 0)
    vessel = next(body for body in scene.vessels if body.liquid is not None)
    assert isinstance(vessel, Vessel)
    assert vessel.liquid is not None
    assert ring_segments(vessel) == 16
    mesh_volume = volume_of(liquid_solid(vessel, 0, []))
    assert mesh_volume < 0.985 * vessel.liquid.volume
    changed = vessel.liquid.model_copy(update={"volume": factor * vessel.liquid.volume})
    scene = _with(scene, scene.vessels.index(vessel), liquid=changed)
    if factor == 1.0:
        check_scene(scene)
    else:
        with pytest.raises(InputError, match=r"liquid, volume: expected that of its body"):
            check_scene(scene)


def test_a_drawn_scene_is_sane_and_hulls_alone_tell_it(scene, monkeypatch):
    """Boxes and hulls clear nearly all pairs: points inside are counted for bodies side by side alone."""
    counted = []
    monkeypatch.setattr(overlap, "contains", lambda body, points: counted.append(len(points)) or np.zeros(0, bool))
    check_scene(scene)
    assert len(scene.objects) == 6
    assert len(counted) <= 2  # of 15 pairs one at most, looked at from both sides


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_scene_drawn_with_real_files_is_sane(shared_assets, seed):
    settings = SceneSettings(
        vessel_count=(3, 3),
        prop_count=(4, 4),
        mesh_dir=shared_assets / "meshes" / "pybullet",
        texture_dir=shared_assets / "textures",
        vessels=VesselSettings(fill_probability=1.0, chord_error=200e-6),  # the coarsest that may be asked for
        environment=EnvironmentSettings(hdri_dir=shared_assets / "hdri"),
    )
    check_scene(draw_scene(settings, seed, 0))


def test_an_index_below_one_is_refused_with_its_vessel_and_medium(scene):
    glass = scene.vessels[0].glass.model_copy(update={"eta": 0.9})
    with pytest.raises(InputError, match=rf"^vessel-00, glass, medium {glass.name}: expected .*at least 1, found 0.9$"):
        check_scene(_with(scene, glass=glass))
    with pytest.raises(InputError, match=r"^vessel-00, outside, back, medium .* found 0.9$"):
        check_scene(_with(scene, part=0, back=glass))
    with pytest.raises(InputError, match="at least 1, found nan"):
        check_scene(_with(scene, glass=glass.model_copy(update={"eta": float("nan")})))


def test_a_negative_absorption_is_refused_with_its_vessel_and_medium(scene):
    liquid = scene.vessels[1].liquid
    medium = liquid.medium.model_copy(update={"sigma_a": (0.0, -1.0, 0.0)})
    with pytest.raises(InputError, match=r"^vessel-01, liquid, medium .*: expected an absorption .* found -1.0$"):
        check_scene(_with(scene, 1, liquid=liquid.model_copy(update={"medium": medium})))


def test_glass_that_is_not_closed_is_refused(scene):
    mesh = scene.vessels[0].interfaces[0].mesh
    torn = Mesh(mesh.name, mesh.vertices, mesh.faces[:-1], mesh.normals)
    found = r"3 edges with one triangle \(holes\), the first at \("
    with pytest.raises(InputError, match=rf"^vessel-00, glass: expected a closed surface.*{found}"):
        check_scene(_with(scene, part=0, mesh=torn))


def test_a_crack_of_one_bit_between_two_interfaces_is_refused(scene):
    mesh = scene.vessels[0].interfaces[2].mesh
    vertices = mesh.vertices.copy()
    vertices[-1, 2] = np.nextafter(vertices[-1, 2], np.float32(1.0))
    moved = Mesh(mesh.name, vertices, mesh.faces, mesh.normals)
    with pytest.raises(InputError, match=r"^vessel-00, liquid: expected a closed surface"):
        check_scene(_with(scene, part=2, mesh=moved))


def test_an_interface_turned_round_is_refused(scene):
    with pytest.raises(InputError, match=r"^vessel-00, glass: expected a closed surface"):
        check_scene(_with(scene, part=1, mesh=turned(scene.vessels[0].interfaces[1].mesh)))
    inside_out = _with(scene, part=0, mesh=turned(scene.vessels[0].interfaces[0].mesh))
    inside_out = _with(inside_out, part=1, mesh=turned(scene.vessels[0].interfaces[1].mesh))
    with pytest.raises(InputError, match=r"^vessel-00, glass: expected normals that point out"):
        check_scene(inside_out)


def test_a_missing_interface_is_refused(scene):
    with pytest.raises(
        InputError, match=r"^vessel-00: expected the interfaces liquid_surface, outside, wet_wall, found"
    ):
        check_scene(_with(scene, interfaces=scene.vessels[0].interfaces[:2]))


def test_a_liquid_above_the_rim_is_refused(scene):
    liquid = scene.vessels[0].liquid
    rim = scene.vessels[0].inner[-1][1]
    with pytest.raises(InputError, match=r"^vessel-00, liquid: expected a surface below the rim"):
        check_scene(_with(scene, liquid=liquid.model_copy(update={"contact": rim + 1e-3})))


@pytest.mark.parametrize("seed", [6, 15])
def test_a_liquid_under_a_neck_meets_the_wall_at_the_border_of_its_surface(seed):
    # There the wall leans inwards, and the surface is widest below its border.
    check_scene(draw_scene(SceneSettings(prop_count=(0, 0)), seed, 0))


def test_an_object_in_the_table_is_refused(scene):
    pose = _moved(scene.vessels[0].world_T_object, np.array([0.0, 0.0, -0.002]))
    with pytest.raises(InputError, match=r"^vessel-00: expected an object above the table's top.*found 1.9 mm below"):
        check_scene(_with(scene, world_T_object=pose))


def test_two_objects_in_each_other_are_refused_by_name(scene):
    first, second = scene.vessels[0], scene.props[0]
    towards = first.world_T_object[:3, 3] - second.world_T_object[:3, 3]
    towards[2] = 0.0
    props = (second.model_copy(update={"world_T_object": _moved(second.world_T_object, towards)}), *scene.props[1:])
    with pytest.raises(InputError, match=f"^vessel-00: expected a place of its own .* overlaps {second.name}$"):
        check_scene(scene.model_copy(update={"props": props}))


def _changed(scene: Scene, kind: str, index: int = 0, **changes: object) -> Scene:
    """The scene with one of its vessels, props, cameras or lights changed without validation."""
    items = list(getattr(scene, kind))
    items[index] = items[index].model_copy(update=changes)
    return scene.model_copy(update={kind: tuple(items)})


def _refused(scene: Scene) -> str:
    with pytest.raises(InputError) as error:
        check_scene(scene)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_an_id_or_a_name_that_two_objects_have_is_refused(scene):
    said = _refused(_changed(scene, "props", id=scene.vessels[1].id))
    assert said.startswith(f"{scene.props[0].name}, id: expected one of its own, found {scene.vessels[1].id}, which ")
    assert _refused(_changed(scene, "props", name="vessel-01")).startswith("vessel-01, name: expected one of its own")


@pytest.mark.parametrize("number", [1, LARGEST_ID + 1])
def test_an_id_that_instance_pictures_cannot_hold_is_refused(scene, number):
    assert np.iinfo(np.uint16).max >= max(ROOM_IDS.values()) > LARGEST_ID
    said = _refused(_changed(scene, "vessels", id=number))
    assert said.startswith("vessel-00, id: expected ")
    assert said.endswith(f", found {number}")


def _stretched(pose):
    pose[:3, 0] *= 1.00001


def _sheared(pose):
    pose[:3, 0] += 1e-5 * pose[:3, 1]


def _mirrored(pose):
    pose[:3, 0] *= -1.0


def _projective(pose):
    pose[3, 0] = 1e-9


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_stretched, "length 1"),
        (_sheared, "right angles"),
        (_mirrored, "right-handed"),
        (_projective, "last row"),
    ],
)
@pytest.mark.parametrize(
    ("kind", "field", "where"),
    [
        ("vessels", "world_T_object", "vessel-00"),
        ("props", "world_T_object", "prop-00"),
        ("cameras", "world_T_camera", "camera 0"),
        ("lights", "world_T_light", "light 0"),
    ],
)
def test_a_pose_that_is_not_rigid_is_refused(scene, kind, field, where, change, says):
    if kind == "lights":
        lamp = AreaLight(world_T_light=np.eye(4), size=(0.1, 0.1), radiance=(1.0, 1.0, 1.0))
        scene = scene.model_copy(update={"lights": (lamp,)})
    pose = getattr(getattr(scene, kind)[0], field).copy()
    check_rigid("pose", pose)
    change(pose)
    said = _refused(_changed(scene, kind, **{field: pose}))
    assert said.startswith(f"{where}, {field}: expected a rigid pose")
    assert says in said


@pytest.mark.parametrize(("kind", "where"), [("vessels", "vessel-00"), ("props", "prop-00")])
def test_a_size_that_is_not_that_of_the_mesh_is_refused(scene, kind, where):
    x, y, z = getattr(scene, kind)[0].size
    check_scene(_changed(scene, kind, size=(x, y, z + 1e-4)))
    for size in ((x, y, z + 3e-4), (x - 3e-4, y, z)):
        assert _refused(_changed(scene, kind, size=size)).startswith(f"{where}, size: expected the extent of mesh")


def test_a_mesh_that_is_not_about_its_origin_or_has_no_triangle_is_refused(scene):
    mesh = scene.props[0].mesh
    aside = Mesh(mesh.name, mesh.vertices + np.array([0.0, 0.0, 0.01], np.float32), mesh.faces)
    assert "about the origin" in _refused(_changed(scene, "props", mesh=aside))
    none = Mesh(mesh.name, mesh.vertices, np.zeros((0, 3)))
    assert "expected triangles" in _refused(_changed(scene, "props", mesh=none))


def test_a_table_whose_size_is_not_that_of_its_mesh_is_refused(scene):
    table = scene.table.model_copy(update={"size": (*scene.table.size[:2], scene.table.size[2] + 0.01)})
    assert _refused(scene.model_copy(update={"table": table})).startswith("table, size: expected the extent of mesh")


def test_a_volume_that_is_not_that_of_the_liquid_is_refused(scene):
    liquid = scene.vessels[0].liquid
    for factor in (0.98, 1.02):
        changed = liquid.model_copy(update={"volume": liquid.volume * factor})
        assert _refused(_with(scene, liquid=changed)).startswith("vessel-00, liquid, volume: expected that of its body")


@pytest.mark.parametrize("field", ["outer", "inner"])
def test_a_profile_of_one_point_is_refused(scene, field):
    said = _refused(_with(scene, **{field: getattr(scene.vessels[0], field)[:1]}))
    assert said == f"vessel-00, {field}: expected a profile of at least 2 points, found 1"


def test_an_interface_between_a_medium_and_itself_is_refused(scene):
    glass = scene.vessels[0].glass
    said = _refused(_with(scene, part=0, front=glass))
    assert said == f"vessel-00, outside: expected two media, one on each side, found {glass.name} on both"


def test_another_glass_or_roughness_without_its_interfaces_is_refused(scene):
    glass = scene.vessels[0].glass
    other = glass.model_copy(update={"name": "flint", "eta": 1.7, "dispersion": None})
    said = _refused(_with(scene, glass=other))
    assert said == f"vessel-00, outside, back: expected the body's glass (flint), found {glass.name}"
    dyed = glass.model_copy(update={"sigma_a": (1.0, 2.0, 3.0)})
    assert _refused(_with(scene, glass=dyed)).endswith(f"found {glass.name} with other constants")
    assert _refused(_with(scene, part=1, roughness=0.3)).startswith("vessel-00, wet_wall, roughness: expected 0, as")
    changed = scene.vessels[0].with_media(glass=other, roughness=0.3)
    rough = {part.part for part in changed.interfaces if part.roughness == 0.3}
    assert rough == {"outside", "wet_wall"}
    check_scene(scene.model_copy(update={"vessels": (changed, *scene.vessels[1:])}))


def test_another_liquid_without_its_interfaces_is_refused(scene):
    liquid = scene.vessels[0].liquid
    other = liquid.medium.model_copy(update={"sigma_a": (1.0, 2.0, 3.0)})
    said = _refused(_with(scene, liquid=liquid.model_copy(update={"medium": other})))
    assert "its liquid" in said
    assert said.endswith(f"found {liquid.medium.name} with other constants")
    assert _refused(_with(scene, part=2, front=other)).startswith(
        "vessel-00, liquid_surface, front: expected air (air)"
    )
    dyed = scene.vessels[0].with_media(liquid=other)
    assert dyed.liquid.medium == dyed.interfaces[1].front == dyed.interfaces[2].back == other
    check_scene(scene.model_copy(update={"vessels": (dyed, *scene.vessels[1:])}))


def test_a_liquid_for_an_empty_body_is_refused(scene):
    empty = ball(0.02, scene.vessels[0].glass)
    with pytest.raises(InputError, match=r"^ball, liquid: expected a body that holds one, found an empty one$"):
        empty.with_media(liquid=scene.vessels[0].liquid.medium)


def test_pictures_are_as_large_as_the_settings_allow_and_no_larger(scene):
    limits = [item.le for item in CameraSettings.model_fields["width"].metadata if hasattr(item, "le")]
    assert limits == [LONGEST_SIDE]
    check_scene(_changed(scene, "cameras", width=LONGEST_SIDE, height=LONGEST_SIDE))
    for field in ("width", "height"):
        for side in (0, LONGEST_SIDE + 1):
            assert _refused(_changed(scene, "cameras", **{field: side})).startswith(f"camera 0, {field}: expected")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("exposure", 1e-13),
        ("exposure", 1e13),
        ("exposure", float("nan")),
        ("focal", float("inf")),
        ("baseline", float("inf")),
        ("centre", (0.0, float("nan"))),
    ],
)
def test_a_number_that_no_camera_has_is_refused(scene, field, value):
    assert _refused(_changed(scene, "cameras", **{field: value})).startswith(f"camera 0, {field}: expected")


def test_a_camera_inside_an_object_is_refused_by_eye_and_object(scene):
    camera, prop = scene.cameras[0], scene.props[0]
    inside = prop.world_T_object[:3, 3]
    left = scene.with_camera(0, eye=tuple(inside), target=(2.0, 0.0, 0.5))
    assert _refused(left).startswith("camera 0, left eye: expected a place in the air, found (")
    assert _refused(left).endswith(f"in {prop.name}")
    pose = camera.world_T_camera.copy()
    pose[:3, 3] = inside - camera.baseline * pose[:3, 0]
    assert "right eye" in _refused(_changed(scene, "cameras", world_T_camera=pose))
    table = scene.with_camera(0, eye=(0.0, 0.0, -0.5 * scene.table.size[2]), target=(2.0, 0.0, 0.5))
    assert _refused(table).endswith("in the table")
    # The middle of a glass's wall is in it, also above the liquid; the air over the liquid is not.
    vessel = scene.vessels[0]
    rim = 0.5 * (np.array(vessel.outer[-2]) + np.array(vessel.inner[-2]))
    glass = (vessel.world_T_object @ (rim[0], 0.0, rim[1], 1.0))[:3]
    assert _refused(scene.with_camera(0, eye=tuple(glass), target=(2.0, 0.0, 0.5))).endswith("in vessel-00")
    liquid = (vessel.world_T_object @ (0.0, 0.0, vessel.liquid.centre - 1e-3, 1.0))[:3]
    assert _refused(scene.with_camera(0, eye=tuple(liquid), target=(2.0, 0.0, 0.5))).endswith("in vessel-00")
