"""Meshes from a user's folder: what is kept of them, and what is refused."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import as_trimesh
from glassware.procedural.materials.textures import bake
from glassware.procedural.props.mesh_files import FileMesh, box_mapped, mesh_files, read_mesh, usable_meshes

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
        ("a.obj", "", "a mesh with faces, found none|a readable OBJ mesh"),
        ("a.obj", CORNERS.replace("0.1 0 0", "nan 0 0") + FACES, "finite vertices, found NaN or infinity"),
        ("a.obj", CORNERS.replace("0.1 0 0", "inf 0 0") + FACES, "finite vertices, found NaN or infinity"),
        ("a.obj", CORNERS + "f 1 2 9\n", "a readable OBJ mesh, found one that cannot be read"),
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


def test_an_obj_takes_the_picture_of_its_mtl(tmp_path: Path) -> None:
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "red skin.png").write_bytes(_png((255, 0, 0)))
    (tmp_path / "look.mtl").write_text(
        "newmtl other\nKd 0 1 0\nnewmtl skin\nKd 0.8 0.8 0.8\nNs 225\nmap_Kd pictures/red skin.png\n"
    )
    found = _read(tmp_path, "a.obj", MAPPED)
    assert np.allclose(bake(found.material.texture), [1, 0, 0])
    # Walter et al. 2007: alpha = sqrt(2 / 227), roughness its root.
    assert found.material.roughness == pytest.approx(np.sqrt(np.sqrt(2 / 227)))
    assert found.mesh.uv is not None


def test_an_obj_takes_the_colour_of_its_mtl_and_goes_without_a_missing_one(tmp_path: Path) -> None:
    assert _read(tmp_path, "a.obj", MAPPED).material.texture is None
    (tmp_path / "look.mtl").write_text("newmtl skin\nKd 0.1 0.2 0.3\n")
    assert _read(tmp_path, "a.obj", MAPPED).material.texture.colour == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("entry", ["map_Kd ../secret.png", "map_Kd /etc/passwd", r"map_Kd ..\secret.png"])
def test_an_mtl_may_not_name_files_outside_the_folder(tmp_path: Path, entry: str) -> None:
    (tmp_path / "secret.png").write_bytes(_png((1, 2, 3)))
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "look.mtl").write_text(f"newmtl skin\n{entry}\n")
    with pytest.raises(InputError, match=r"look\.mtl: expected names of files inside .*meshes, found"):
        _read(folder, "a.obj", MAPPED)
    with pytest.raises(InputError, match=r"a\.obj: expected names of files inside"):
        _read(folder, "a.obj", MAPPED.replace("look.mtl", "../look.mtl"))


def test_an_mtl_with_a_missing_picture_or_a_broken_number_is_refused(tmp_path: Path) -> None:
    for entry, said in (
        ("map_Kd gone.png", r"gone\.png: expected a readable picture"),
        ("Kd red green blue", r"look\.mtl: expected a colour of three numbers"),
        ("Kd nan 0 0", r"look\.mtl: expected a colour of three numbers"),
        ("Ns shiny", r"look\.mtl: expected a number for Ns, found shiny"),
    ):
        (tmp_path / "look.mtl").write_text(f"newmtl skin\n{entry}\n")
        with pytest.raises(InputError, match=said):
            _read(tmp_path, "a.obj", MAPPED)


def _glb(surface: dict, picture: bytes = b"") -> bytes:
    """Return a GLB of one tetrahedron with a material, written by hand after the glTF 2.0 specification."""
    positions = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], "<f4").tobytes()
    uv = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], "<f4").tobytes()
    faces = np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3], "<u4").tobytes()
    blobs, views, start = [positions, uv, faces, picture], [], 0
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": start, "byteLength": len(blob)})
        start += len(blob)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0] * 3, "max": [0.1] * 3},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5125, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": views if picture else views[:3],
        "buffers": [{"byteLength": start}],
        "materials": [{"pbrMetallicRoughness": surface}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
    }
    if not picture:
        del document["textures"], document["images"]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(blobs)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def test_a_glb_takes_the_picture_inside_it_and_keeps_it_by_its_content(tmp_path: Path) -> None:
    content = _glb({"baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.4}, _png((0, 255, 0)))
    found = _read(tmp_path, "a.glb", content)
    assert np.allclose(bake(found.material.texture), [0, 1, 0])
    assert (found.material.roughness, found.material.metallic) == (0.4, 0.0)
    assert [path.name for path in (tmp_path / "kept").iterdir()] == [f"{found.material.texture.asset.sha256}.png"]
    # v points down in glTF and up here: the second vertex (0.1, 0, 0) has (1, 0) there and (1, 1) here.
    row = np.flatnonzero(found.mesh.vertices[:, 0] > 0.04)[0]
    assert found.mesh.uv[row].tolist() == [1.0, 1.0]


def test_a_glb_takes_its_factors(tmp_path: Path) -> None:
    material = _read(tmp_path, "a.glb", _glb({"baseColorFactor": [0.1, 0.2, 0.3, 1.0]})).material
    assert material.texture.colour == (0.1, 0.2, 0.3)
    assert (material.roughness, material.metallic) == (1.0, 1.0)  # what the specification says where nothing is given


def test_a_glb_with_a_broken_picture_or_material_is_refused(tmp_path: Path) -> None:
    surface = {"baseColorTexture": {"index": 0}}
    with pytest.raises(InputError, match=r"a\.glb: expected a PNG or JPEG picture inside"):
        _read(tmp_path, "a.glb", _glb(surface, b"GIF89a.."))
    with pytest.raises(InputError, match=r"a\.glb: expected a readable picture inside"):
        _read(tmp_path, "a.glb", _glb(surface, _png((1, 2, 3))[:36]))
    with pytest.raises(InputError, match=r"a\.glb: expected a (GLB file with valid materials|readable GLB mesh)"):
        _read(tmp_path, "a.glb", _glb({"baseColorTexture": {"index": 7}}, _png((1, 2, 3))))


@pytest.mark.parametrize("name", ["a\0b", "n" * 300, "loop", "x/" * 3000], ids=["NUL", "long", "loop", "deep"])
def test_a_name_that_no_file_can_have_is_refused_wherever_it_stands(tmp_path: Path, name: str) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    said = "expected names that a file can have"
    with pytest.raises(InputError, match=rf"a\.obj: {said}"):
        _read(tmp_path, "a.obj", f"mtllib {name}\nusemtl m\n{CORNERS}{FACES}")
    (tmp_path / "look.mtl").write_text(f"newmtl m\nmap_Kd {name}\n")
    with pytest.raises(InputError, match=rf"look\.mtl: {said}"):
        _read(tmp_path, "a.obj", f"mtllib look.mtl\nusemtl m\n{CORNERS}{FACES}")


@pytest.mark.parametrize("field", ["roughnessFactor", "metallicFactor"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), "rough", None])
def test_a_factor_of_a_glb_that_is_no_number_is_refused(tmp_path: Path, field: str, value: object) -> None:
    with pytest.raises(InputError, match=r"a\.glb: expected (finite numbers for|a readable GLB mesh)") as caught:
        _read(tmp_path, "a.glb", _glb({field: value}))
    assert "Error" not in str(caught.value)


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
        if found.material.texture is not None and found.material.texture.kind == "picture":
            pictured.add(file.path.stem)
    assert len(files) == 19
    assert pictured == {"bread", "can", "cereal", "lemon", "milk"}
