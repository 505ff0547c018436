"""Folders of known collections: which files are objects, and what their places say."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from types import ModuleType

import pytest

from glassware.procedural.mesh_files.layouts import listing
from glassware.procedural.mesh_files.records import licence_beside, licence_named

UID = "0123456789abcdef0123456789abcdef"


def _listed(folder: Path, names: list[str]) -> tuple[dict, dict[str, str]]:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    paths = [folder / name for name in names if Path(name).suffix in (".obj", ".ply", ".stl", ".glb")]
    found = listing(paths, folder)
    used = {path.relative_to(folder).as_posix(): place for path, place in found.used}
    return used, {path.relative_to(folder).as_posix(): why for path, why in found.left_out}


def test_shapenet_has_names_and_no_sizes(tmp_path: Path) -> None:
    name = f"03797390/{UID}/models/model_normalized.obj"
    place = _listed(tmp_path, [name])[0][name]
    assert (place.layout, place.category, place.unit, place.up) == ("shapenet", "mug", "none", "y")
    assert place.licence == "ShapeNet terms of use"
    (tmp_path / "taxonomy.json").write_text(json.dumps([{"synsetId": "03797390", "name": "mug, cup"}, 3]))
    assert _listed(tmp_path / "03797390" / "..", [name])[0][name].category == "mug"
    other = f"01234567/{UID}/models/model_normalized.obj"
    assert _listed(tmp_path, [other])[0][other].category == "01234567"


def test_scanned_objects_are_in_metres_with_their_categories(tmp_path: Path) -> None:
    names = ["Toy_Block/meshes/model.obj", "Shoe/meshes/model.obj", "Shoe/materials/textures/texture.png"]
    (tmp_path / "Toy_Block").mkdir()
    (tmp_path / "Toy_Block/metadata.pbtxt").write_text('name: "x"\ncategories {\n  first: "Toys"\n}\n')
    used, _ = _listed(tmp_path, names)
    assert [place.category for place in used.values()] == ["Toys", "Shoe"]
    assert {(place.layout, place.unit, place.licence) for place in used.values()} == {("gso", 1.0, "CC BY 4.0")}


def test_ycb_has_one_good_mesh_for_each_object_and_never_a_hull(tmp_path: Path) -> None:
    kinds = ("google_16k/textured.obj", "google_16k/nontextured.ply", "poisson/nontextured.stl", "tsdf/textured.obj")
    names = [f"{name}/{kind}" for name in ("025_mug", "072-a_toy_airplane") for kind in kinds]
    used, left_out = _listed(tmp_path, [*names, "003_box/tsdf/nontextured.ply"])
    assert {name: place.category for name, place in used.items()} == {
        "025_mug/google_16k/textured.obj": "mug",
        "072-a_toy_airplane/google_16k/textured.obj": "toy_airplane",
        "003_box/tsdf/nontextured.ply": "box",
    }
    assert left_out["025_mug/tsdf/textured.obj"] == "the same object as 025_mug/google_16k/textured.obj"


def test_bop_is_in_millimetres_with_its_symmetries_and_prefers_models_for_rendering(tmp_path: Path) -> None:
    half_turn = [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    info = {
        "1": {"diameter": 90.0, "symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]},
        "2": {"diameter": 70.0, "symmetries_discrete": [half_turn, [1, 2], "x"]},
    }
    folders = ("models", "models_eval", "models_cad")
    names = [f"{folder}/obj_00000{k}.ply" for folder in folders for k in (1, 2)]
    (tmp_path / "models").mkdir()
    (tmp_path / "models/models_info.json").write_text(json.dumps(info))
    used, left_out = _listed(tmp_path, names)
    assert list(used) == ["models/obj_000001.ply", "models/obj_000002.ply"]
    assert [place.unit for place in used.values()] == [1e-3, 1e-3]
    assert [place.turns for place in used.values()] == [True, False]
    assert used["models/obj_000002.ply"].symmetries == (tuple(map(float, half_turn)),)
    assert len(left_out) == 4


def test_objaverse_has_licences_and_categories_from_its_lists(tmp_path: Path) -> None:
    name = f"glbs/000-007/{UID}.glb"
    (tmp_path / "metadata").mkdir()
    with gzip.open(tmp_path / "metadata/000-007.json.gz", "wt") as file:
        json.dump({UID: {"license": "by-sa"}}, file)
    with gzip.open(tmp_path / "lvis-annotations.json.gz", "wt") as file:
        json.dump({"teapot": [UID]}, file)
    place = _listed(tmp_path, [name])[0][name]
    assert (place.layout, place.category, place.licence, place.up) == ("objaverse", "teapot", "CC BY-SA 4.0", "y")


@pytest.mark.parametrize(
    ("names", "used"),
    [
        (["m/collision_vhacd.obj", "m/textured_reoriented.obj"], ["m/textured_reoriented.obj"]),
        (["mug.obj", "mug_collision.obj", "cup.obj", "cup_vhacd.obj"], ["mug.obj", "cup.obj"]),
        (["mug.obj", "mug.stl", "mug.glb"], ["mug.glb"]),
        (["a/nontextured.ply", "a/textured.obj"], ["a/textured.obj"]),
        (["collision.obj"], ["collision.obj"]),
        (["hull_of_ship.obj", "mast.obj", "sail.obj"], ["hull_of_ship.obj", "mast.obj", "sail.obj"]),
        (["a/mug.obj", "b/mug.obj"], ["a/mug.obj", "b/mug.obj"]),
    ],
)
def test_a_plain_folder_has_each_object_once(tmp_path: Path, names: list[str], used: list[str]) -> None:
    assert list(_listed(tmp_path, names)[0]) == used


def test_the_licence_nearest_above_a_mesh_is_the_meshs(makers: ModuleType, tmp_path: Path) -> None:
    texts = {
        "LICENSE.txt": "Creative Commons CC0 1.0",
        "a/b/license": "MIT License\n...",
        "c/License.md": "My terms",
    }
    makers.written(tmp_path, {**texts, "a/b/m.obj": "", "d/m.obj": ""})
    folders = ("a/b", "a", "c", "d")
    assert [licence_beside(tmp_path / name, tmp_path) for name in folders] == ["MIT", "CC0", "My terms", "CC0"]
    assert licence_named("CC-BY-NC-SA-4.0") == "CC BY-NC-SA"
    assert licence_named("") == ""


@pytest.mark.parametrize("text", ["", "[", "{}", '{"1": 3}', '{"1": {"symmetries_continuous": 3}}', "[" * 10_000])
def test_a_damaged_record_says_nothing(tmp_path: Path, text: str) -> None:
    (tmp_path / "models_info.json").write_text(text)
    place = _listed(tmp_path, ["obj_000001.ply"])[0]["obj_000001.ply"]
    assert (place.turns, place.symmetries) == (False, ())
