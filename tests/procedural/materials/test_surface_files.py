"""Materials in folders as Poly Haven, ambientCG and others name their files."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.materials.draw import draw_table_material
from glassware.procedural.materials.map_names import map_name
from glassware.procedural.materials.surface_files import surface_files, usable_surfaces


def write(path: Path, level: int = 128) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full((4, 4, 3), level, np.uint8))
    return path


def test_a_folder_of_poly_haven_is_one_material(tmp_path) -> None:
    folder = tmp_path / "wood_table_001" / "textures"
    for kind in ("diff", "rough", "arm", "ao", "nor_gl", "disp"):
        write(folder / f"wood_table_001_{kind}_4k.jpg")
    (surface,), findings = surface_files(tmp_path)
    assert findings == ()
    assert surface.name == "wood_table_001/textures/wood_table_001_diff_4k.jpg"
    assert surface.base == "wood_table_001"
    assert surface.roughness is not None
    assert surface.roughness.path.name == "wood_table_001_rough_4k.jpg"
    assert surface.metalness is not None
    assert surface.metalness.channel == "blue"
    assert surface.normal is not None
    assert surface.normal.convention == "opengl"
    assert surface.height is None  # the normals say the same


def test_a_folder_of_ambientcg_is_one_material_without_its_preview(tmp_path) -> None:
    folder = tmp_path / "Wood051_1K-JPG"
    for kind in ("Color", "NormalGL", "NormalDX", "Displacement", "Roughness", "AmbientOcclusion"):
        write(folder / f"Wood051_1K-JPG_{kind}.jpg")
    write(folder / "Wood051_1K-JPG.png")
    (surface,), findings = surface_files(tmp_path)
    assert surface.normal is not None
    assert surface.normal.path.name == "Wood051_1K-JPG_NormalGL.jpg"
    assert surface.metalness is None
    assert [item.path for item in findings] == ["Wood051_1K-JPG/Wood051_1K-JPG.png"]
    assert "a view of the material wood051" in findings[0].reason


@pytest.mark.parametrize(
    ("stem", "base", "kind", "detail"),
    [
        ("T_Brick_BaseColor", "t_brick", "colour", ""),
        ("T_Brick_Base_Color", "t_brick", "colour", ""),
        ("brick-albedo", "brick", "colour", ""),
        ("Brick_Mixed_AO", "brick", "unused", ""),
        ("WoodFlooring041_REFL_2K", "woodflooring041", "unused", ""),
        ("BrickDiffuse", "brick", "colour", ""),
        ("red_brick_diff_01", "red_brick", "colour", ""),
        ("rusty_coll1_2k", "rusty", "colour", ""),
        ("Brick_Normal-ogl", "brick", "normal", "opengl"),
        ("brick_nor_dx_8k", "brick", "normal", "directx"),
        ("Brick_Normal_DirectX", "brick", "normal", "directx"),
        ("brick_glossiness", "brick", "glossiness", ""),
        ("T_Brick_ORM", "t_brick", "packed", "arm"),
        ("brick_metallic-roughness", "brick", "packed", "arm"),
        ("brick_height_16bit", "brick", "height", ""),
        ("Metal012_4K-PNG_Metalness", "metal012", "metalness", ""),
        ("color", "", "colour", ""),
        ("light-gray-floor-tile", "light_gray_floor_tile", "plain", ""),
    ],
)
def test_names_say_what_a_picture_shows(stem, base, kind, detail) -> None:
    found = map_name(stem)
    assert (found.base, found.kind, found.detail) == (base, kind, detail)


def test_two_materials_and_two_colours_of_one_in_a_folder_stay_apart(tmp_path) -> None:
    for stem in ("wood_001_diff", "wood_001_rough", "wood_002_diff", "wood_002_rough", "cloth_col_01", "cloth_col_02"):
        write(tmp_path / f"{stem}_1k.png")
    write(tmp_path / "cloth_nor_dx_1k.png")
    surfaces, _ = surface_files(tmp_path)
    assert [(item.colour.stem, len(item.maps)) for item in surfaces] == [
        ("cloth_col_01_1k", 1),
        ("cloth_col_02_1k", 1),
        ("wood_001_diff_1k", 1),
        ("wood_002_diff_1k", 1),
    ]
    assert surfaces[0].normal is not None
    assert surfaces[0].normal.convention == "directx"


def test_of_several_sizes_the_one_that_is_needed_is_taken(tmp_path) -> None:
    for size in ("1k", "4k", "8k"):
        write(tmp_path / f"wood_diff_{size}.png")
        write(tmp_path / f"wood_rough_{size}.png")
    (surface,), _ = surface_files(tmp_path)
    assert surface.colour.stem == "wood_diff_4k"
    assert surface.roughness is not None
    assert surface.roughness.path.stem == "wood_rough_4k"


def test_plain_pictures_stay_materials_of_one_picture(tmp_path) -> None:
    plain = ["clay.png", "photo_1.png", "photo_2.png", "rusty_metal.jpg", "sub/colour.png", "wood_color.png"]
    for name in plain:
        write(tmp_path / name)
    surfaces, findings = surface_files(tmp_path)
    assert findings == ()
    assert [(item.name, item.maps) for item in surfaces] == [(name, ()) for name in plain]


def test_a_normal_map_alone_is_no_table_top(tmp_path) -> None:
    write(tmp_path / "a.png")
    write(tmp_path / "brick_normal.png")
    surfaces, findings = surface_files(tmp_path)
    assert [item.name for item in surfaces] == ["a.png"]
    assert [item.path for item in findings] == ["brick_normal.png"]
    (tmp_path / "a.png").unlink()
    with pytest.raises(InputError, match="pictures in colour, found maps alone, such as brick_normal"):
        surface_files(tmp_path)


def test_a_material_has_the_size_that_a_file_beside_it_states(tmp_path) -> None:
    for kind in ("diff", "rough"):
        write(tmp_path / "wood" / "textures" / f"wood_{kind}_1k.png")
    (tmp_path / "wood" / "info.json").write_text(json.dumps({"dimensions": [2500, 2500]}))
    (surface,), _ = surface_files(tmp_path)
    assert surface.side == 2.5
    assert draw_table_material(np.random.default_rng(0), [surface]).repeats == pytest.approx(1.0 / 2.5)
    for text in ("{", "[]", '{"dimensions": ["x"]}', '{"dimensions": [-4]}'):
        (tmp_path / "wood" / "info.json").write_text(text)
        assert surface_files(tmp_path)[0][0].side is None


def test_a_material_of_maps_takes_roughness_metalness_and_normals_from_them(tmp_path) -> None:
    for kind in ("BaseColor", "ORM", "Normal-dx"):
        write(tmp_path / f"brick_{kind}.png")
    material = draw_table_material(np.random.default_rng(0), usable_surfaces(tmp_path, (2.0, 2.0))[0])
    assert material.roughness_map is not None
    assert material.roughness_map.channel == "green"
    assert material.metallic_map is not None
    assert material.metallic_map.channel == "blue"
    assert material.normal_map is not None
    assert material.normal_map.convention == "directx"
    assert (material.roughness, material.metallic, material.repeats) == (1.0, 1.0, 0.5)


def test_a_bad_picture_is_passed_over_and_a_bad_map_with_its_material(tmp_path) -> None:
    write(tmp_path / "good.png")
    for kind in ("diff", "rough"):
        write(tmp_path / f"wood_{kind}.png")
    (tmp_path / "wood_rough.png").write_bytes(b"no picture")
    (tmp_path / "bad.png").write_bytes(b"no picture")
    (tmp_path / "gone.png").symlink_to(tmp_path / "nowhere.png")
    surfaces, findings = usable_surfaces(tmp_path)
    assert [item.name for item in surfaces] == ["good.png"]
    assert {item.path for item in findings} == {"bad.png", "gone.png", "wood_diff.png"}
    assert "wood_rough.png: expected a readable picture" in next(str(x) for x in findings if x.path == "wood_diff.png")


def test_maps_named_by_letters_are_one_material_where_colour_and_normals_are_there(tmp_path) -> None:
    for kind in ("D", "N", "R", "ORM"):
        write(tmp_path / f"T_Rock_{kind}.png")
    ((surface,), findings) = surface_files(tmp_path)
    assert findings == ()
    assert surface.name == "T_Rock_D.png"
    assert surface.normal is not None
    assert surface.normal.convention == "directx"
    assert surface.roughness is not None
    assert surface.roughness.path.name == "T_Rock_R.png"
    assert surface.metalness is not None
    assert surface.metalness.path.name == "T_Rock_ORM.png"


@pytest.mark.parametrize("letters", ["abn", "dnk", "dr"])
def test_letters_that_may_be_variants_are_pictures_of_their_own(tmp_path, letters: str) -> None:
    for letter in letters:
        write(tmp_path / f"marble_{letter}.png")
    assert len(surface_files(tmp_path)[0]) == len(letters)


def test_a_roughness_map_beside_normals_without_a_colour_is_no_picture(tmp_path) -> None:
    for name in ("x_nor_gl", "x_rough", "wood_rough"):
        write(tmp_path / f"{name}.png")
    surfaces, findings = surface_files(tmp_path)
    assert [item.name for item in surfaces] == ["wood_rough.png"]
    assert [item.path for item in findings] == ["x_nor_gl.png", "x_rough.png"]
