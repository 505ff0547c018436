from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from glassware.procedural.description import Scene
from glassware.procedural.draw import draw_scene
from glassware.procedural.errors import InputError
from glassware.procedural.mesh import Mesh, turned
from glassware.procedural.sanity import check_scene
from glassware.procedural.settings import SceneSettings
from glassware.procedural.vessels.settings import VesselSettings

SETTINGS = SceneSettings(
    vessel_count=(3, 3), prop_count=(3, 3), vessels=VesselSettings(fill_probability=1.0, chord_error=60e-6)
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


def test_a_drawn_scene_is_sane_and_checked_fast():
    drawn = draw_scene(SceneSettings(), 3, 1)
    check_scene(drawn)
    times = []
    for _ in range(3):
        start = process_time()
        check_scene(drawn)
        times.append(process_time() - start)
    assert min(times) < 0.2


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
    with pytest.raises(InputError, match=r"^vessel-00, glass: expected a closed surface.*loose edges"):
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
