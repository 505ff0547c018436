"""Props of mesh files: parts, colours, glass, and what a layout states of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from glassware.annotate.symmetries import symmetry_of
from glassware.core.randomness import stream
from glassware.procedural.description.material_list import materials_of
from glassware.procedural.description.scene import GlassBody, Prop
from glassware.procedural.primitives.scenes import camera, scene
from glassware.procedural.props.from_file import prop_from_file
from glassware.procedural.props.mesh_files import MeshChoice, usable_meshes
from glassware.procedural.scene.scene_file import load_scene, save_scene
from glassware.procedural.scene.validate import check_scene

TWO = (
    "mtllib m.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
    "usemtl box\nf 1 3 2\nf 1 2 4\nf 2 3 4\nusemtl knob\nf 3 1 4\n"
)


def _prop(folder: Path, **choice: object) -> Prop | GlassBody:
    (file,), _ = usable_meshes(folder, pictures=folder, choice=MeshChoice(**choice))
    return prop_from_file(stream(0, 0, "props/0"), file, 0.1, id=2, name="prop-00")


def _standing(prop: Prop) -> Prop:
    pose = np.eye(4)
    pose[2, 3] = 1e-4 - prop.mesh.bounds[0, 2]
    return prop.model_copy(update={"world_T_object": pose})


def test_a_prop_of_two_materials_has_two_parts_one_id_and_is_read_back(tmp_path: Path) -> None:
    (tmp_path / "m.mtl").write_text("newmtl box\nKd 0 0 1\nnewmtl knob\nKd 1 0 0\n")
    (tmp_path / "a.obj").write_text(TWO)
    prop = _standing(_prop(tmp_path))
    assert [(piece.faces, piece.material.base_colour.colour) for piece in prop.parts] == [
        (3, (0.0, 0.0, 1.0)),
        (1, (1.0, 0.0, 0.0)),
    ]
    assert prop.material.name == "box"
    whole = scene([], [camera((0.3, -0.3, 0.3))], props=[prop])
    check_scene(whole)
    assert [material.name for material in materials_of(whole)[2:]] == ["box", "knob"]
    save_scene(whole, tmp_path / "out" / "scene.json")
    again = load_scene(tmp_path / "out" / "scene.json").props[0]
    assert again.parts == prop.parts
    assert again.origin == prop.origin


def test_parts_that_do_not_fit_the_mesh_are_refused(tmp_path: Path) -> None:
    (tmp_path / "m.mtl").write_text("newmtl box\nKd 0 0 1\nnewmtl knob\nKd 1 0 0\n")
    (tmp_path / "a.obj").write_text(TWO)
    prop = _standing(_prop(tmp_path))
    for parts, said in (
        (prop.parts[:1], "parts of 4 faces together, found 3"),
        ((*prop.parts, prop.parts[0].model_copy(update={"faces": 0})), "faces in each of several parts"),
    ):
        wrong = scene([], [camera((0.3, -0.3, 0.3))], props=[prop.model_copy(update={"parts": parts})])
        with pytest.raises(ValueError, match=said):
            check_scene(wrong)


def test_colours_of_vertices_are_kept_with_the_scene(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.05))
    box.visual.vertex_colors = np.tile([[200, 30, 90, 255]], (8, 1))
    (tmp_path / "a.ply").write_bytes(box.export(file_type="ply"))
    prop = _standing(_prop(tmp_path))
    assert prop.material.base_colour.kind == "vertices"
    assert np.allclose(prop.mesh.colours, [0.5776, 0.0130, 0.1022], atol=1e-4)  # sRGB 200, 30, 90
    save_scene(scene([], [camera((0.3, -0.3, 0.3))], props=[prop]), tmp_path / "scene.json")
    again = load_scene(tmp_path / "scene.json").props[0]
    assert np.array_equal(again.mesh.colours, prop.mesh.colours)


def test_a_closed_file_of_glass_is_a_glass_body_and_an_open_one_is_passed_over(tmp_path: Path) -> None:
    ball = trimesh.creation.uv_sphere(radius=0.04)
    (tmp_path / "m.mtl").write_text("newmtl g\nd 0.1\nNi 1.45\nNs 10000\n")
    text = "mtllib m.mtl\nusemtl g\n" + ball.export(file_type="obj", include_normals=False)
    (tmp_path / "a.obj").write_text(text)
    body = _prop(tmp_path)
    assert isinstance(body, GlassBody)
    assert body.glass.eta == 1.45
    (tmp_path / "b.obj").write_text(text[: text.rstrip().rindex("f ")])
    files, findings = usable_meshes(tmp_path)
    assert [file.name for file in files] == ["a.obj"]
    assert "expected a closed surface, as its material is glass, found " in findings[0].reason


def test_many_plain_parts_become_one_with_colours_of_its_vertices(tmp_path: Path) -> None:
    mtl = "".join(f"newmtl m{k}\nKd {k / 40} 0.5 0.5\n" for k in range(40))
    rows = [f"v {x} {y} {z}" for k in range(40) for x, y, z in ((0, k, 0), (1, k, 0), (0, k, 1), (0, k + 0.9, 0))]
    faces = [
        f"usemtl m{k}\nf {4 * k + 1} {4 * k + 2} {4 * k + 3}\nf {4 * k + 1} {4 * k + 3} {4 * k + 4}" for k in range(40)
    ]
    (tmp_path / "m.mtl").write_text(mtl)
    (tmp_path / "a.obj").write_text("mtllib m.mtl\n" + "\n".join(rows + faces))
    prop = _prop(tmp_path, unit="mm")
    assert prop.parts == ()
    assert prop.material.base_colour.kind == "vertices"
    assert np.allclose(np.unique(prop.mesh.colours[:, 0]), np.arange(40) / 40)


def test_what_a_collection_states_of_an_object_is_in_its_labels(tmp_path: Path) -> None:
    box = trimesh.creation.box((60.0, 30.0, 20.0))
    box.apply_translation([100.0, 0.0, 50.0])
    (tmp_path / "obj_000001.ply").write_bytes(box.export(file_type="ply"))
    turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    turn[0, 3] = 200.0  # about the box's own upright axis, in the file's frame
    info = {"1": {"symmetries_discrete": [turn.ravel().tolist()]}}
    (tmp_path / "models_info.json").write_text(json.dumps(info))
    (tmp_path / "LICENSE").write_text("CC0 1.0 Universal")
    prop = _prop(tmp_path)
    assert prop.category == "obj_000001"
    assert prop.size == pytest.approx((0.06, 0.03, 0.02))
    assert (prop.origin.layout, prop.origin.licence, prop.origin.metres_per_unit) == ("bop", "CC0", 1e-3)
    assert prop.origin.centre == pytest.approx((100.0, 0.0, 50.0))
    assert np.allclose(symmetry_of(prop).motions, [np.eye(4), np.diag([-1.0, -1.0, 1.0, 1.0])], atol=1e-9)


def test_a_ground_below_an_object_is_left_out(tmp_path: Path) -> None:
    boxes = trimesh.Scene()
    boxes.add_geometry(trimesh.creation.box((0.08, 0.08, 0.08)))
    sheet = trimesh.Trimesh([[-2, -0.05, -2], [2, -0.05, -2], [2, -0.05, 2], [-2, -0.05, 2]], [[0, 2, 1], [0, 3, 2]])
    boxes.add_geometry(sheet)
    (tmp_path / "a.glb").write_bytes(boxes.export(file_type="glb"))
    assert _prop(tmp_path).size == pytest.approx((0.08, 0.08, 0.08), rel=1e-5)
