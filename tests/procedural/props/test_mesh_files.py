"""Meshes from a user's folder: what is kept of them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import as_trimesh
from glassware.procedural.props.draw import PropSettings, draw_prop
from glassware.procedural.props.mesh_files import (
    FileMesh,
    MeshChoice,
    box_mapped,
    mesh_files,
    read_mesh,
    usable_meshes,
)

REAL = Path(__file__).resolve().parents[4] / "shared" / "assets" / "meshes"
CORNERS = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
FACES = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
MAPPED = CORNERS + "vt 0 0\nvt 1 0\nvt 0 1\nmtllib look.mtl\nusemtl skin\nf 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\n"


def _read(folder: Path, name: str, content: str | bytes, longest: float = 0.1) -> FileMesh:
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    files = {file.name: file for file in mesh_files(folder, folder / "kept")}
    return read_mesh(files[name], "prop", longest)


def _png(colour: tuple[int, int, int]) -> bytes:
    return cv2.imencode(".png", np.full((4, 4, 3), colour[::-1], np.uint8))[1].tobytes()


def test_meshes_are_found_in_subfolders_in_the_order_of_their_paths(tmp_path: Path) -> None:
    for name in ("b/a.obj", "a.STL", "c.ply", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    assert [file.name for file in mesh_files(tmp_path)] == ["a.STL", "b/a.obj", "c.ply"]


def test_a_missing_and_an_empty_folder_are_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere: expected a folder of meshes, found no such folder"):
        mesh_files(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"expected meshes \(.*\), found none"):
        mesh_files(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.obj", CORNERS, "a mesh with faces, found none"),
        ("a.obj", "", "a mesh, found an empty file"),
        ("a.obj", CORNERS.replace("0.1 0 0", "nan 0 0") + FACES, "finite vertices, found NaN or infinity"),
        ("a.obj", CORNERS.replace("0.1 0 0", "inf 0 0") + FACES, "finite vertices, found NaN or infinity"),
        ("a.obj", CORNERS + "f 1 2 9\n", "faces over 4 vertices, found one with index 9"),
        ("a.obj", CORNERS + "f 1 2 3\n", "a body with three extents, found 0.1 x 0.1 x 0"),
        ("a.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "a body with three extents, found 0 x 0 x 0"),
        ("a.obj", CORNERS + "f 1 1 2\nf 3 3 4\n", "a mesh with faces, found only faces without area"),
        ("a.glb", b"glTF nonsense", "a readable GLB mesh"),
        ("a.ply", "ply\nformat ascii 1.0\n", "a readable PLY mesh|a mesh with faces"),
        ("a.stl", b"\x00" * 40, "a readable STL mesh|a mesh with faces"),
    ],
)
def test_a_bad_file_is_named_with_what_is_wrong(tmp_path: Path, name: str, content: str | bytes, said: str) -> None:
    with pytest.raises(InputError, match=rf"{name}: expected ({said})") as caught:
        _read(tmp_path, name, content)
    assert "\n" not in str(caught.value)


def test_a_face_of_a_ply_that_points_past_the_vertices_is_refused(tmp_path: Path) -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    body = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 7\n"
    with pytest.raises(InputError, match=r"a\.ply: expected"):
        _read(tmp_path, "a.ply", header + body)


def test_a_whole_folder_is_checked_and_a_bad_file_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(CORNERS + FACES)
    (tmp_path / "b.obj").write_text(CORNERS)
    files, findings = usable_meshes(tmp_path)
    assert [file.name for file in files] == ["a.obj"]
    assert [str(item) for item in findings] == ["mesh_dir: b.obj: expected a mesh with faces, found none"]
    (tmp_path / "a.obj").unlink()
    with pytest.raises(InputError, match="meshes that can be used, found none in 1 file; mesh_dir: b"):
        usable_meshes(tmp_path)


@pytest.mark.parametrize(("side", "expected"), [(0.1, 0.1), (0.021, 0.021), (0.39, 0.39), (10.0, 0.07), (0.001, 0.07)])
def test_a_plausible_size_is_kept_and_any_other_is_replaced(tmp_path: Path, side: float, expected: float) -> None:
    content = trimesh.creation.box((side, side / 2, side / 4)).export(file_type="obj")
    mesh = _read(tmp_path, "a.obj", content, longest=0.07).mesh
    assert np.ptp(mesh.bounds, axis=0) == pytest.approx([expected, expected / 2, expected / 4], rel=1e-5)
    assert np.abs(mesh.bounds.sum(axis=0)).max() < 1e-7


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "glb"])
def test_every_format_gives_the_same_solid(tmp_path: Path, kind: str) -> None:
    solid = trimesh.creation.cylinder(0.03, 0.1, sections=24)
    content = (
        solid.export(file_type=kind, include_normals=False) if kind in ("obj", "glb") else solid.export(file_type=kind)
    )
    mesh = _read(tmp_path, f"a.{kind}", content).mesh
    welded = as_trimesh(mesh)
    assert welded.is_watertight
    assert welded.volume == pytest.approx(solid.volume, rel=1e-4)
    # A GLB's y points up: what was z there is -y here.
    assert np.ptp(mesh.bounds, axis=0).argmax() == (1 if kind == "glb" else 2)
    # The side is smooth and its edges with the caps are sharp.
    axis = 1 if kind == "glb" else 2
    upright = np.abs(mesh.normals[:, axis])
    assert np.all((upright < 1e-3) | (upright > 1 - 1e-3))


def test_parts_of_a_file_become_one_in_their_places(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((0.1, 0.1, 0.1)))
    scene.add_geometry(
        trimesh.creation.box((0.1, 0.1, 0.1)), transform=trimesh.transformations.translation_matrix([0.2, 0, 0])
    )
    mesh = _read(tmp_path, "a.glb", scene.export(file_type="glb")).mesh
    assert len(mesh.faces) == 24
    assert np.ptp(mesh.bounds, axis=0) == pytest.approx([0.3, 0.1, 0.1], rel=1e-5)


def test_normals_of_the_file_are_kept_and_unusable_ones_are_replaced(tmp_path: Path) -> None:
    normals = "vn 0 0 -1\nvn 0 -1 0\nvn 1 1 1\nvn -1 0 0\n"
    faces = "f 1//1 3//1 2//1\nf 1//2 2//2 4//2\nf 2//3 3//3 4//3\nf 3//4 1//4 4//4\n"
    good = _read(tmp_path, "a.obj", CORNERS + normals + faces).mesh
    assert np.allclose(good.normals[good.faces[2]], 1 / np.sqrt(3), atol=1e-6)
    for wrong in (normals.replace("1", "0"), normals.replace("-1", "2").replace("1 1 1", "-1 -1 -1")):
        mended = _read(tmp_path, "b.obj", CORNERS + wrong + faces).mesh
        corners = mended.vertices[mended.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.all(np.einsum("fi,fci->fc", cross, mended.normals[mended.faces]) > 0)


def test_a_file_name_that_is_not_utf8_is_refused(tmp_path: Path) -> None:
    (tmp_path / "\udcff.obj").write_text("")
    with pytest.raises(InputError, match=r"\\udcff\.obj: expected a file name in UTF-8, found other bytes"):
        mesh_files(tmp_path)


def test_a_surface_without_texture_coordinates_is_mapped_from_its_six_sides(tmp_path: Path) -> None:
    content = trimesh.creation.box((0.1, 0.05, 0.05)).export(file_type="obj", include_normals=False)
    mesh = _read(tmp_path, "a.obj", content).mesh
    mapped = box_mapped(mesh)
    edges = mapped.vertices[mapped.faces] - mapped.vertices[mapped.faces[:, [1, 2, 0]]]
    across = mapped.uv[mapped.faces] - mapped.uv[mapped.faces[:, [1, 2, 0]]]
    # Every side of a box lies flat in its chart: lengths are those of the surface in units of the longest side.
    assert np.allclose(np.linalg.norm(across, axis=2) * 0.1, np.linalg.norm(edges, axis=2), atol=1e-6)
    assert as_trimesh(mapped).volume == pytest.approx(0.1 * 0.05 * 0.05, rel=1e-5)


@pytest.mark.skipif(not REAL.is_dir(), reason="shared/assets/meshes is not beside the checkout")
def test_real_files_load_and_the_textured_ones_bring_their_pictures(tmp_path: Path) -> None:
    files = mesh_files(REAL, tmp_path)
    pictured = set()
    for file in files:
        found = read_mesh(file, "prop", 0.1)
        assert np.isfinite(found.mesh.vertices).all()
        assert np.allclose(np.linalg.norm(found.mesh.normals, axis=1), 1.0, atol=1e-5)
        assert 0.02 <= np.ptp(found.mesh.bounds, axis=0).max() <= 0.4
        if any(piece.look.texture is not None and piece.look.texture.kind == "picture" for piece in found.pieces):
            pictured.add(file.path.stem)
    assert len(files) == 19
    assert pictured == {"bread", "can", "cereal", "lemon", "milk"}


def _sizes(folder: Path, **choice: object) -> tuple[list[float], list[str]]:
    """Return the longest sides of all props of a folder, to a tenth of a millimetre, and the lines about it."""
    files, findings = usable_meshes(folder, pictures=folder, choice=MeshChoice(**choice))
    settings, rng = PropSettings(file_share=1.0), np.random.default_rng(0)
    props = [draw_prop(rng, settings, id=2, name="prop", mesh_files=[file]) for file in files]
    return [round(max(prop.size), 4) for prop in props], [str(item) for item in findings]


def test_a_size_that_a_layout_or_the_user_states_is_the_true_one(tmp_path: Path) -> None:
    content = trimesh.creation.box((60.0, 30.0, 20.0)).export(file_type="ply")
    (tmp_path / "obj_000001.ply").write_bytes(content)
    assert _sizes(tmp_path) == ([0.06], [])
    (tmp_path / "obj_000001.ply").rename(tmp_path / "part.ply")
    assert _sizes(tmp_path, unit="mm") == ([0.06], [])
    (drawn,), (line,) = _sizes(tmp_path)
    assert 0.05 <= drawn <= 0.16
    assert "part.ply: no known size; one is drawn, the same in all scenes" in line
    assert _sizes(tmp_path)[0] == [drawn]


@pytest.mark.parametrize(("unit", "size"), [("m", "60 m"), ("cm", "0.6001 m")])
def test_a_stated_unit_that_makes_an_absurd_object_is_asked_about(tmp_path: Path, unit: str, size: str) -> None:
    side = 60.0 if unit == "m" else 60.01
    (tmp_path / "part.stl").write_bytes(trimesh.creation.box((side, 30.0, 20.0)).export(file_type="stl"))
    with pytest.raises(InputError, match=rf"part\.stl: expected an object of 5 mm to 0\.6 m, found one of {size}"):
        _sizes(tmp_path, unit=unit)


def test_names_and_categories_are_included_and_excluded_by_patterns(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.05)).export(file_type="stl")
    for name in ("a/Mug.stl", "a/cup.stl", "025_mug/google_16k/textured.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(box)

    def chosen(**choice: object) -> list[str]:
        return [file.name for file in mesh_files(tmp_path, tmp_path, MeshChoice(**choice))]

    assert chosen(include=("*mug*",)) == ["025_mug/google_16k/textured.stl", "a/Mug.stl"]
    assert chosen(include=("mug",)) == ["025_mug/google_16k/textured.stl"]
    assert chosen(exclude=("a/*",)) == ["025_mug/google_16k/textured.stl"]
    with pytest.raises(InputError, match=r"props\.exclude choose, found none with x"):
        chosen(include=("x",))


def test_a_single_file_is_a_folder_of_one(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(CORNERS + FACES)
    (tmp_path / "b.obj").write_text(CORNERS + FACES)
    files, _ = usable_meshes(tmp_path / "a.obj")
    assert [file.name for file in files] == ["a.obj"]


def test_a_y_axis_that_points_up_is_turned_to_z(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.3 0\nv 0 0 0.1\n" + FACES)
    for up, axis in (("auto", 1), ("z", 1), ("y", 2)):
        (file,) = mesh_files(tmp_path, tmp_path, MeshChoice(up=up))
        assert np.ptp(read_mesh(file, "prop", 0.1).mesh.bounds, axis=0).argmax() == axis
