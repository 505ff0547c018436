"""Pictures of MTL files: how they lie on the surface, maps of roughness, metalness and normals, and encodings."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest


def _read(makers: ModuleType, folder: Path, mtl: str, **pictures: bytes) -> tuple[Any, list[str]]:
    files = {f"{name}.png": content for name, content in pictures.items()}
    makers.written(folder, {"a.obj": makers.MAPPED, "look.mtl": f"newmtl skin\n{mtl}\n", **files})
    (part,), notes = makers.parts_of(folder / "a.obj")
    return part, notes.remarks


@pytest.mark.parametrize(
    ("options", "scale", "offset"),
    [
        ("-s 2 3 1 -o 0.5 0.25 0", (2, 3), (0.5, 0.25)),
        ("-o 0.5 -s 2", (2, 1), (0.5, 0)),
        ("-clamp on", (1, 1), (0, 0)),
    ],
)
def test_a_picture_lies_as_its_options_say(
    makers: ModuleType, tmp_path: Path, options: str, scale: tuple, offset: tuple
) -> None:
    plain, _ = _read(makers, tmp_path, "map_Kd a.png", a=makers.png())
    part, remarks = _read(makers, tmp_path, f"map_Kd {options} a.png", a=makers.png())
    assert np.allclose(part.uv, plain.uv * scale + offset)
    assert not remarks


def test_maps_are_those_of_the_material(makers: ModuleType, tmp_path: Path) -> None:
    pictures = {"a": makers.png(), "grey": makers.png((99, 99, 99)), "flat": makers.png((128, 128, 255))}
    mtl = "Ns 100\nPm 0\nmap_Kd -s 2 2 a.png\nmap_Pr -s 2 2 1 grey.png\nmap_Pm -s 2 2 1 grey.png\n"
    part, remarks = _read(makers, tmp_path, mtl + "map_Bump -bm 0.5 -s 2 2 1 flat.png", **pictures)
    maps = part.look.maps
    assert [maps[key].asset.path.name for key in sorted(maps)] == ["grey.png", "flat.png", "grey.png"]
    assert maps["normal_map"].strength == 0.5
    assert part.look.roughness == part.look.metallic == 1.0
    assert not remarks
    part, remarks = _read(makers, tmp_path, "map_Kd a.png\nmap_Bump grey.png\nmap_Pr -s 2 2 grey.png", **pictures)
    assert not part.look.maps
    assert remarks == [
        "'skin': a picture with texture coordinates of its own is not used",
        "material 'skin': its picture of heights is not used",
    ]


def test_maps_without_texture_coordinates_are_left_out_with_a_remark(makers: ModuleType, tmp_path: Path) -> None:
    obj = makers.CORNERS + "mtllib m.mtl\nusemtl skin\n" + makers.FACES
    files = {"a.obj": obj, "m.mtl": "newmtl skin\nKd 1 0 0\nmap_Pr a.png\n", "a.png": makers.png()}
    (part,), notes = makers.parts_of(makers.written(tmp_path, files) / "a.obj")
    assert not part.look.maps
    assert notes.remarks == ["material 'skin' has maps, but its faces have no texture coordinates"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_names_in_any_encoding_are_found(makers: ModuleType, tmp_path: Path, encoding: str) -> None:
    obj = makers.MAPPED.replace("skin", "gr\u00fcn").encode(encoding)
    mtl = "newmtl gr\u00fcn\nmap_Kd gr\u00fcn.png\n".encode(encoding)
    files = {"a.obj": obj, "look.mtl": mtl, "gr\u00fcn.png": makers.png()}
    (part,), notes = makers.parts_of(makers.written(tmp_path, files) / "a.obj")
    assert part.look.texture.kind == "picture"
    assert not notes.remarks


def test_a_library_without_materials_is_a_remark(makers: ModuleType, tmp_path: Path) -> None:
    files = {"a.obj": makers.MAPPED, "look.mtl": "# empty\n"}
    _, notes = makers.parts_of(makers.written(tmp_path, files) / "a.obj")
    assert notes.remarks == ["expected a material 'skin' in look.mtl, found none"]
