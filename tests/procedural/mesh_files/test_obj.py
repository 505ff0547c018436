"""OBJ and MTL files: which faces have which material, and the dialects of both formats."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.materials.textures import bake
from glassware.procedural.mesh_files.model import Notes
from glassware.procedural.mesh_files.mtl_maps import picture_name


def _read(
    makers: ModuleType, folder: Path, files: dict[str, str | bytes], name: str = "a.obj"
) -> tuple[list[Any], Notes]:
    return makers.parts_of(makers.written(folder, files) / name)


def _look(
    makers: ModuleType, folder: Path, mtl: str, files: dict[str, str | bytes] | None = None
) -> tuple[Any, list[str]]:
    """Return the look of a material, and the remarks."""
    parts, notes = _read(makers, folder, {"a.obj": makers.MAPPED, "look.mtl": f"newmtl skin\n{mtl}\n", **(files or {})})
    return parts[0].look, notes.remarks


def test_every_part_has_its_own_material(makers: ModuleType, tmp_path: Path) -> None:
    mtl = "newmtl box\nKd 0 0 1\nnewmtl knob\nKd 1 0 0\nnewmtl unused\nKd 0 1 0\n"
    obj = makers.CORNERS + "mtllib m.mtl\nusemtl box\nf 1 3 2\nusemtl knob\nf 1 2 4\nf 2 3 4\nusemtl box\nf 3 1 4\n"
    parts, _ = _read(makers, tmp_path, {"a.obj": obj, "m.mtl": mtl})
    assert {part.look.name: (len(part.faces), part.look.texture.colour) for part in parts} == {
        "box": (2, (0.0, 0.0, 1.0)),
        "knob": (2, (1.0, 0.0, 0.0)),
    }


def test_colours_of_vertices_are_those_of_the_file(makers: ModuleType, tmp_path: Path) -> None:
    colours = ["1 0 0", "0 1 0", "0 0 1", "1 1 0.5"]
    rows = [f"{line} {colour}" for line, colour in zip(makers.CORNERS.splitlines(), colours, strict=True)]
    parts, _ = _read(makers, tmp_path, {"a.obj": "\n".join(rows) + "\n" + makers.FACES})
    assert parts[0].look.texture.kind == "vertices"
    assert np.allclose(sorted(parts[0].colours[:, 2].tolist()), [0, 0, 0.2140, 1], atol=1e-4)  # sRGB 0.5 is 0.214
    bytes_ = [f"{line} {c}" for line, c in zip(makers.CORNERS.splitlines(), ["255 0 0"] * 4, strict=True)]
    parts, _ = _read(makers, tmp_path, {"b.obj": "\n".join(bytes_) + "\n" + makers.FACES}, "b.obj")
    assert np.array_equal(parts[0].colours, [[1, 0, 0]] * 4)


@pytest.mark.parametrize(
    ("named", "there"),
    [
        ("tex.png", "tex.png"),
        ("Tex.PNG", "tex.png"),
        ("C:\\Users\\me\\Desktop\\Model\\tex.png", "tex.png"),
        ("/home/me/model/tex.png", "tex.png"),
        ('"tex.png"', "tex.png"),
        ("textures\\tex.png", "textures/tex.png"),
        ("tex.png", "textures/tex.png"),
        ("-s 1 1 1 -o 0 0 my label texture.png", "my label texture.png"),
        ("-blendu on -bm 0.5 tex.png", "tex.png"),
        ("../gone/tex.png", "tex.png"),
    ],
)
def test_a_picture_is_found_where_people_have_it(makers: ModuleType, tmp_path: Path, named: str, there: str) -> None:
    look, remarks = _look(makers, tmp_path, f"map_Kd {named}", {there: makers.png()})
    assert np.allclose(bake(look.texture), [1, 0, 0])
    assert not remarks


def test_the_picture_of_a_scanned_object_is_in_the_folder_beside(makers: ModuleType, tmp_path: Path) -> None:
    files = {"meshes/model.obj": makers.MAPPED, "meshes/look.mtl": "newmtl skin\nmap_Kd texture.png\n"}
    makers.written(tmp_path, {**files, "materials/textures/texture.png": makers.png()})
    parts, notes = makers.parts_of(tmp_path / "meshes/model.obj", tmp_path)
    assert parts[0].look.texture.kind == "picture"
    assert not notes.remarks


def test_a_picture_that_is_nowhere_is_a_remark_with_both_names_and_the_rest_stays(
    makers: ModuleType, tmp_path: Path
) -> None:
    look, remarks = _look(makers, tmp_path, "Kd 0.8 0.1 0.1\nmap_Kd polar_bear_eye.PNG")
    assert look.texture.colour == (0.8, 0.1, 0.1)
    (remark,) = remarks
    assert remark.startswith("look.mtl: expected the picture of material 'skin' ('polar_bear_eye.PNG') inside")


@pytest.mark.parametrize("named", ["../secret.png", "../../other/secret.png", "..\\secret.png", "link.png"])
def test_nothing_outside_the_folder_is_read(makers: ModuleType, tmp_path: Path, named: str) -> None:
    secret = makers.written(tmp_path, {"secret.png": makers.png(), "other/secret.png": makers.png()}) / "secret.png"
    folder = tmp_path / "meshes"
    folder.mkdir()
    if named == "link.png":
        (folder / "link.png").symlink_to("/etc/passwd" if Path("/etc/passwd").stat().st_uid else secret.parent)
    look, remarks = _look(makers, folder, f"map_Kd {named}")
    assert look.texture is None
    assert len(remarks) == 1


def test_a_link_in_the_folder_is_followed_to_a_file_of_the_users_own(makers: ModuleType, tmp_path: Path) -> None:
    store = makers.written(tmp_path / "store", {"blob": makers.png()})
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "tex.png").symlink_to(store / "blob")
    assert _look(makers, folder, "map_Kd tex.png")[0].texture is not None


def test_a_link_that_a_checkout_stored_as_text_is_followed_inside_the_folder_alone(
    makers: ModuleType, tmp_path: Path
) -> None:
    makers.written(tmp_path, {"store/m.obj": makers.CORNERS + makers.FACES, "links/m.obj": "../store/m.obj"})
    parts, _ = makers.parts_of(tmp_path / "links/m.obj", tmp_path)
    assert len(parts[0].faces) == 4
    with pytest.raises(InputError, match=r"m\.obj: expected a mesh, found the text of a link to .*store/m\.obj"):
        makers.parts_of(tmp_path / "links/m.obj")


@pytest.mark.parametrize(
    ("mtl", "colour"),
    [
        ("Kd 0.1 0.2 0.3", (0.1, 0.2, 0.3)),
        ("Kd 0.8", (0.8, 0.8, 0.8)),
        ("  Kd\t.8 .1 .1  ", (0.8, 0.1, 0.1)),
        ("Kd xyz 0.9505 1.0 1.089", (1.0, 1.0, 1.0)),
        ("Kd 128 0 255", (128 / 255, 0.0, 1.0)),
        ("Kd 2 -1 0", (1.0, 0.0, 0.0)),
    ],
)
def test_dialects_of_a_colour(makers: ModuleType, tmp_path: Path, mtl: str, colour: tuple) -> None:
    assert _look(makers, tmp_path, mtl)[0].texture.colour == pytest.approx(colour, abs=2e-3)


@pytest.mark.parametrize("mtl", ["Kd red green blue", "Kd nan 0 0", "Ns 1.#QNAN0", "Ns shiny", "Kd spectral a.rfl"])
def test_a_broken_entry_is_a_remark_and_the_rest_stays(makers: ModuleType, tmp_path: Path, mtl: str) -> None:
    look, remarks = _look(makers, tmp_path, f"Pm 0.5\n{mtl}")
    assert look.metallic == 0.5
    assert look.texture is look.roughness is None
    assert len(remarks) == 1
    assert "'skin'" in remarks[0]


def test_a_shininess_is_a_roughness_unless_one_is_stated(makers: ModuleType, tmp_path: Path) -> None:
    # Walter et al. 2007: alpha = sqrt(2 / 227), roughness its root.
    assert _look(makers, tmp_path, "Ns 225")[0].roughness == pytest.approx(np.sqrt(np.sqrt(2 / 227)))
    assert _look(makers, tmp_path, "Ns 225\nPr 0.3")[0].roughness == 0.3


def test_an_ambient_picture_stands_for_the_missing_colour(makers: ModuleType, tmp_path: Path) -> None:
    assert _look(makers, tmp_path, "map_Ka b.jpg", {"b.jpg": makers.png(suffix=".jpg")})[0].texture.kind == "picture"


def test_a_clear_material_is_glass(makers: ModuleType, tmp_path: Path) -> None:
    assert _look(makers, tmp_path, "d 0.1\nNi 1.33")[0].glass.index == 1.33
    assert _look(makers, tmp_path, "Tr 0.9")[0].glass is not None
    assert _look(makers, tmp_path, "d 1")[0].glass is _look(makers, tmp_path, "Tr 1")[0].glass is None


def test_an_emission_is_a_colour_or_a_picture(makers: ModuleType, tmp_path: Path) -> None:
    glow = _look(makers, tmp_path, "Ke 4 2 0")[0].glow
    assert (glow.texture.colour, glow.strength) == ((1.0, 0.5, 0.0), 4.0)
    glow = _look(makers, tmp_path, "Ke 0 0 0\nmap_Ke a.png", {"a.png": makers.png()})[0].glow
    assert (glow.texture.kind, glow.strength) == ("picture", 1.0)
    for mtl in ("Ke 0 0 0", "Ke nan 0 0", "Ke inf 1 1", "Ke bright", "map_Ke gone.png"):
        assert _look(makers, tmp_path, mtl)[0].glow is None


def test_faces_without_a_material_have_the_only_one_there_is(makers: ModuleType, tmp_path: Path) -> None:
    obj = makers.CORNERS + "mtllib a.mtl\n" + makers.FACES
    assert _read(makers, tmp_path, {"a.obj": obj, "a.mtl": "newmtl x\nKd 1 0 0\n"})[0][0].look.texture.colour == (
        1,
        0,
        0,
    )
    two = {"a.obj": obj, "a.mtl": "newmtl x\nKd 1 0 0\nnewmtl y\nKd 0 1 0\n"}
    assert _read(makers, tmp_path, two)[0][0].look.texture is None


@pytest.mark.parametrize("library", ["/home/me/out/look.mtl", "look.mtl", "LOOK.MTL", "other.mtl look.mtl", "gone.mtl"])
def test_a_library_is_found_by_its_name_or_beside_the_mesh(makers: ModuleType, tmp_path: Path, library: str) -> None:
    mtl = "newmtl skin\nKd 1 0 0\n"
    files = {"a.obj": makers.MAPPED.replace("look.mtl", library), "a.mtl" if library == "gone.mtl" else "look.mtl": mtl}
    assert _read(makers, tmp_path, files)[0][0].look.texture.colour == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("name", ["a\0b", "n" * 300, "loop", "x/" * 3000], ids=["NUL", "long", "loop", "deep"])
def test_a_name_that_no_file_can_have_is_a_remark(makers: ModuleType, tmp_path: Path, name: str) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    _, remarks = _look(makers, tmp_path, f"map_Kd {name}")
    assert len(remarks) == 1
    assert "\n" not in remarks[0]
    parts, notes = _read(makers, tmp_path, {"a.obj": f"mtllib {name}\nusemtl m\n{makers.CORNERS}{makers.FACES}"})
    assert len(parts) == len(notes.remarks) == 1


@pytest.mark.parametrize(
    ("value", "name"),
    [
        ("a b.png", "a b.png"),
        ("-o 1 2 a.png", "a.png"),
        ("-s 1 1 1 2.png", "2.png"),
        ("-clamp on x", "x"),
        ("-mm 0 1 t", "t"),
    ],
)
def test_options_before_a_picture_are_no_part_of_its_name(value: str, name: str) -> None:
    assert picture_name(value) == name


def test_relative_indices_continued_lines_and_comments_are_read(makers: ModuleType, tmp_path: Path) -> None:
    obj = (
        makers.CORNERS.replace("\n", " # a corner\n")
        + "f -4 -2 \\\n -3\nf 1//  2// 4// # no normals\nf 2 3 4\nf 3 1 4\np 1\n"
    )
    parts, notes = _read(makers, tmp_path, {"a.obj": obj})
    assert len(parts[0].faces) == 4
    assert notes.remarks == ["its points have no surface and are left out"]


def test_a_picture_without_texture_coordinates_gives_way_to_the_plain_colour(
    makers: ModuleType, tmp_path: Path
) -> None:
    obj = makers.CORNERS + "mtllib look.mtl\nusemtl skin\n" + makers.FACES
    for mtl, colour in (("Kd 0.2 0.4 0.6\n", (0.2, 0.4, 0.6)), ("", (1.0, 0.0, 0.0))):
        files = {"a.obj": obj, "look.mtl": f"newmtl skin\n{mtl}map_Kd a.png\n", "a.png": makers.png()}
        parts, notes = _read(makers, tmp_path, files)
        assert parts[0].look.texture.colour == pytest.approx(colour)
        assert notes.remarks == ["material 'skin' has a picture, but its faces have no texture coordinates"]


@pytest.mark.parametrize("index", ["9", "-7", "9" * 30, "-" + "9" * 30])
def test_a_face_over_a_vertex_that_is_not_there_is_refused_whatever_its_index(
    makers: ModuleType, tmp_path: Path, index: str
) -> None:
    path = makers.written(tmp_path, {"a.obj": makers.CORNERS + f"f 1 2 {index}\n"}) / "a.obj"
    with pytest.raises(InputError, match="faces over 4 vertices, found one with index"):
        makers.parts_of(path)
