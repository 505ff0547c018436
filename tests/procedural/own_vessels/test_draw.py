"""Scenes with vessels from files: drawn, changed, kept in files, and labelled."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import trimesh

import glassware as gw
from glassware.annotate.keypoints import keypoints
from glassware.annotate.symmetries import symmetry_of
from glassware.procedural.description.bodies import MeshVessel
from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.scene_file import scene_digest
from glassware.procedural.scene.validate import check_scene


@pytest.fixture(scope="module")
def file(own_shapes: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return own_shapes.saved(own_shapes.beaker(sections=48), tmp_path_factory.mktemp("own") / "beaker.obj", 1e3)


def drawn(file: Path, **vessels: Any) -> Scene:
    settings = {"unit": "mm", "liquids": ["water"], "fill": [0.6, 0.6], "fill_probability": 1.0} | vessels
    return gw.draw(3, vessel_dir=str(file), vessels=settings, vessel_count=[1, 1], prop_count=[0, 0])


def test_a_file_is_a_vessel_with_its_liquid(own_shapes: ModuleType, file: Path) -> None:
    vessel = drawn(file).vessels[0]
    assert isinstance(vessel, MeshVessel)
    assert vessel.category == "beaker.obj"
    assert vessel.liquid is not None
    assert vessel.liquid.volume == pytest.approx(0.6 * own_shapes.capacity(48), rel=0.01)
    assert vessel.liquid.contact_angle == pytest.approx(np.radians(25.0), abs=0.01)  # water on glass
    assert vessel.symmetric
    assert symmetry_of(vessel).turns


def test_the_settings_choose_glass_and_volume(file: Path) -> None:
    vessel = drawn(file, glasses=["lead crystal"], fill=["100ml", "100ml"]).vessels[0]
    assert vessel.glass.name == "lead crystal"
    assert vessel.liquid is not None
    assert vessel.liquid.volume == pytest.approx(1e-4, rel=1e-3)
    with pytest.raises(gw.InputError, match=r"vessels\.fill: expected at most .* in beaker\.obj"):
        drawn(file, fill=["2l", "2l"])


def test_it_can_be_emptied_refilled_moved_and_taken_away(file: Path) -> None:
    scene = drawn(file)
    name = scene.vessels[0].name
    empty = scene.with_liquid(name, None)
    assert empty.vessels[0].liquid is None
    for changed in (
        empty,
        empty.with_liquid(name, "olive oil", 0.3),
        scene.with_glass(name, "acrylic"),
        scene.with_pose(name, scene.vessels[0].world_T_object @ np.diag([-1.0, -1.0, 1.0, 1.0])),
        scene.without(name),
    ):
        check_scene(changed)
    assert keypoints(empty.vessels[0]) == pytest.approx(keypoints(scene.vessels[0]))
    with pytest.raises(gw.InputError, match="below the rim"):
        scene.with_liquid(name, "water", 0.999)


def test_a_scene_file_gives_it_back_bit_by_bit(file: Path, tmp_path: Path) -> None:
    scene = drawn(file)
    gw.save_scene(scene, tmp_path / "scene.json")
    found = gw.load_scene(tmp_path / "scene.json")
    assert scene_digest(found) == scene_digest(scene)
    again = found.with_liquid(found.vessels[0].name, "water", 0.5)
    gw.save_scene(again, tmp_path / "other" / "scene.json")


def test_a_solid_that_is_not_its_glass_is_refused(file: Path) -> None:
    scene = drawn(file)
    other = drawn(file, fill=[0.2, 0.2]).vessels[0]
    vessel = scene.vessels[0].model_copy(update={"interfaces": other.interfaces})
    with pytest.raises(gw.InputError):
        check_scene(scene.model_copy(update={"vessels": (vessel,)}))


def test_a_file_of_another_kind_is_one_line(tmp_path: Path) -> None:
    (path := tmp_path / "beaker.step").write_text("ISO-10303-21;", "utf-8")
    with pytest.raises(gw.InputError, match=r"beaker\.step: expected a folder of vessels .* of another format$"):
        drawn(path)


def test_vessels_of_the_families_stay_as_they_were_without_a_folder(file: Path) -> None:
    settings = {"vessel_count": [2, 2], "prop_count": [0, 0], "cameras": {"views": 1}}
    plain = gw.draw(5, **settings)
    none_of_files = gw.draw(5, vessel_dir=str(file), vessels={"unit": "mm", "file_probability": 0.0}, **settings)
    assert scene_digest(plain) == scene_digest(none_of_files)


def test_a_cup_on_its_saucer_has_two_levels(tmp_path: Path) -> None:
    saucer = [(0, 0), (60, 0), (60, 20), (58, 20), (58, 4), (30, 4)]
    cup = [(30, 80), (28, 80), (28, 8), (0, 8)]
    path = tmp_path / "cup.stl"
    trimesh.creation.revolve(np.array(saucer + cup, float), sections=48).export(path)
    scene = drawn(path)
    vessel = scene.vessels[0]
    assert isinstance(vessel, MeshVessel)
    assert len(vessel.cavities) == 2
    assert vessel.liquid is not None
    check_scene(scene)
    wrong = vessel.model_copy(update={"liquid": vessel.liquid.model_copy(update={"level": 0.0})})
    with pytest.raises(gw.InputError, match="level"):
        check_scene(scene.model_copy(update={"vessels": (wrong,)}))
