"""GLB and glTF: nodes, primitives, materials and their extensions; what cannot be read is named."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.materials.textures import bake

PICTURED = {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0}


def _parts(makers: ModuleType, folder: Path, content: bytes) -> tuple:
    return makers.parts_of(makers.written(folder, {"a.glb": content}) / "a.glb")


def test_every_primitive_has_its_own_material_in_its_place(makers: ModuleType, tmp_path: Path) -> None:
    blue, green = makers.surface(baseColorFactor=[0, 0, 1, 1]), makers.surface(**PICTURED)
    parts, notes = _parts(makers, tmp_path, makers.glb([blue, green], makers.png((0, 255, 0))))
    assert parts[0].look.texture.colour == (0.0, 0.0, 1.0)
    assert np.allclose(bake(parts[1].look.texture), [0, 1, 0])
    assert np.allclose(parts[1].vertices, makers.POSITIONS + np.array([0.2, 0, 0]))
    assert not notes.remarks


def test_factors_multiply_pictures_and_channels(makers: ModuleType, tmp_path: Path) -> None:
    fields = {"baseColorFactor": [0.5, 1, 1, 1], "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5}
    (part,), _ = _parts(makers, tmp_path, makers.glb([makers.surface(**PICTURED | fields)], makers.png((255, 0, 0))))
    assert np.allclose(bake(part.look.texture), [0.5, 0, 0])
    assert (part.look.roughness, part.look.metallic) == (0.5, 0.0)
    assert part.look.maps["roughness_map"].channel == "green"
    assert part.look.maps["metallic_map"].channel == "blue"


def test_a_picture_inside_is_kept_by_its_content(makers: ModuleType, tmp_path: Path) -> None:
    (part,), _ = _parts(makers, tmp_path, makers.glb([makers.surface(**PICTURED)], makers.png()))
    assert [path.name for path in (tmp_path / "kept").iterdir()] == [f"{part.look.texture.asset.sha256}.png"]


def test_coordinates_point_up_and_follow_the_transform_of_the_texture(makers: ModuleType, tmp_path: Path) -> None:
    reference: dict[str, object] = {"index": 0}
    (part,), _ = _parts(makers, tmp_path, makers.glb([makers.surface(baseColorTexture=reference)], makers.png()))
    assert part.uv.tolist() == [[0, 1], [1, 1], [0, 0], [1, 0]]
    change = {"offset": [0.1, 0.2], "scale": [0.5, 2.0], "rotation": np.pi / 2}
    reference["extensions"] = {"KHR_texture_transform": change}
    content = makers.glb(
        [makers.surface(baseColorTexture=reference)], makers.png(), extensionsRequired=["KHR_texture_transform"]
    )
    (part,), _ = _parts(makers, tmp_path, content)
    # The extension's text: offset * rotation * scale; a quarter turn takes (u, v) to (v, -u).
    u, v = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], float).T * [[0.5], [2.0]]
    assert np.allclose(part.uv, np.stack([v + 0.1, 1.0 - (-u + 0.2)], 1))


def test_a_second_set_of_coordinates_is_used_where_the_material_says_so(makers: ModuleType, tmp_path: Path) -> None:
    other = {"TEXCOORD_1": np.full((4, 2), 0.25)}
    material = makers.surface(baseColorTexture={"index": 0, "texCoord": 1})
    (part,), _ = _parts(makers, tmp_path, makers.glb([material], makers.png(), other))
    assert np.allclose(part.uv, [0.25, 0.75])


def test_colours_of_vertices_are_linear_and_times_the_factor(makers: ModuleType, tmp_path: Path) -> None:
    colours = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.4, 0.6]])
    material = makers.surface(baseColorFactor=[0.5, 1, 1, 1])
    (part,), _ = _parts(makers, tmp_path, makers.glb([material], columns={"COLOR_0": colours}))
    assert part.look.texture.kind == "vertices"
    assert np.allclose(part.colours, colours * [0.5, 1, 1], atol=1e-6)


def test_specular_glossiness_becomes_roughness_and_metalness(makers: ModuleType, tmp_path: Path) -> None:
    name = "KHR_materials_pbrSpecularGlossiness"
    dull = {"diffuseTexture": {"index": 0}, "glossinessFactor": 0.2, "specularFactor": [0.04, 0.04, 0.04]}
    (part,), _ = _parts(
        makers, tmp_path, makers.glb([{"extensions": {name: dull}}], makers.png(), extensionsRequired=[name])
    )
    assert part.look.texture.kind == "picture"
    assert (part.look.roughness, part.look.metallic) == (pytest.approx(0.8), 0.0)
    gold = {"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.77, 0.34], "glossinessFactor": 1.0}
    (part,), _ = _parts(makers, tmp_path, makers.glb([{"extensions": {name: gold}}]))
    assert part.look.metallic == pytest.approx(1.0, abs=0.02)
    assert part.look.texture.colour == pytest.approx((1.0, 0.77, 0.34), abs=0.03)


def test_transmission_is_glass_with_its_index_and_attenuation(makers: ModuleType, tmp_path: Path) -> None:
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.33},
        "KHR_materials_volume": {"attenuationColor": [0.5, 0.9, 1.0], "attenuationDistance": 0.02},
    }
    (part,), _ = _parts(makers, tmp_path, makers.glb([{"extensions": extensions}]))
    assert (part.look.glass.index, part.look.glass.distance) == (1.33, 0.02)
    assert part.look.glass.colour == (0.5, 0.9, 1.0)
    clear = {"alphaMode": "BLEND", **makers.surface(baseColorFactor=[1, 1, 1, 0.2])}
    assert _parts(makers, tmp_path, makers.glb([clear]))[0][0].look.glass is not None


def test_emission_has_its_strength_and_its_picture(makers: ModuleType, tmp_path: Path) -> None:
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 5}}
    material = {"emissiveFactor": [0.5, 0.25, 0], "extensions": strength}
    (part,), notes = _parts(makers, tmp_path, makers.glb([material]))
    assert (part.look.glow.texture.colour, part.look.glow.strength) == ((1.0, 0.5, 0.0), 2.5)
    pictured = {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}
    (part,), notes = _parts(makers, tmp_path, makers.glb([pictured], makers.png((0, 255, 0))))
    assert np.allclose(bake(part.look.glow.texture), [0, 1, 0])
    assert part.look.glow.strength == 1.0
    assert not notes.remarks
    # Colours of vertices are a picture of their own, so that of the emission gives way to its mean.
    (part,), _ = _parts(
        makers, tmp_path, makers.glb([pictured], makers.png((0, 255, 0)), {"COLOR_0": np.full((4, 3), 0.5)})
    )
    assert part.look.glow.texture.colour == (0.0, 1.0, 0.0)
    (part,), _ = _parts(makers, tmp_path, makers.glb([{"emissiveTexture": {"index": 0}}], makers.png()))
    assert part.look.glow is None  # the factor is 0 where none is stated


def test_a_webp_picture_is_read_and_another_format_is_named(makers: ModuleType, tmp_path: Path) -> None:
    texture = {"extensions": {"EXT_texture_webp": {"source": 0}}}
    content = makers.glb([makers.surface(**PICTURED)], makers.png(suffix=".webp"), textures=[texture])
    assert _parts(makers, tmp_path, content)[0][0].look.texture.kind == "picture"
    (part,), notes = _parts(makers, tmp_path, makers.glb([makers.surface(**PICTURED)], b"\xabKTX 20\xbb\r\n\x1a\n"))
    assert part.look.texture.colour == (1.0, 1.0, 1.0)
    assert notes.remarks == ["a.glb: expected the colour of 'material 0' as PNG, JPEG or WebP, found KTX2"]


def test_a_broken_picture_is_a_remark(makers: ModuleType, tmp_path: Path) -> None:
    (part,), notes = _parts(makers, tmp_path, makers.glb([makers.surface(**PICTURED)], makers.png()[:36]))
    assert part.look.texture.colour == (1.0, 1.0, 1.0)
    assert len(notes.remarks) == 1


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu", "X_y"])
def test_a_required_extension_that_is_unknown_refuses_the_file_by_name(
    makers: ModuleType, tmp_path: Path, name: str
) -> None:
    with pytest.raises(InputError, match=rf"a\.glb: expected no required extension but known ones, found {name}"):
        _parts(makers, tmp_path, makers.glb(extensionsRequired=[name]))


def test_a_mirroring_node_keeps_the_outside_outside(makers: ModuleType, tmp_path: Path) -> None:
    nodes = [{"mesh": 0, "scale": [-1, 1, 1]}]
    (part,), _ = _parts(makers, tmp_path, makers.glb(nodes=nodes, columns={"NORMAL": makers.POSITIONS + 0.1}))
    corners = part.vertices[part.faces]
    assert np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0
    assert np.allclose(part.normals * [-1, 1, 1], makers.POSITIONS + 0.1)


def test_nodes_nest_and_repeat_meshes(makers: ModuleType, tmp_path: Path) -> None:
    nodes = [
        {"children": [1, 2], "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1]},
        {"mesh": 0, "rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)]},
        {"mesh": 0, "translation": [0, 1, 0]},
    ]
    parts, _ = _parts(makers, tmp_path, makers.glb(nodes=nodes, scenes=[{"nodes": [0]}]))
    x, y, z = makers.POSITIONS.T
    assert np.allclose(parts[0].vertices, 2 * np.stack([-y, x, z], 1) + [1, 0, 0])
    assert np.allclose(parts[1].vertices, 2 * (makers.POSITIONS + np.array([0, 1, 0])) + [1, 0, 0])


def test_strips_fans_and_parts_without_surface(makers: ModuleType, tmp_path: Path) -> None:
    attributes = {"POSITION": 0}
    primitives = [{"attributes": attributes, "mode": mode} for mode in (5, 6, 0, 1)]
    parts, notes = _parts(makers, tmp_path, makers.glb(meshes=[{"primitives": primitives}]))
    assert [part.faces.tolist() for part in parts] == [[[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [0, 2, 3]]]
    assert len(notes.remarks) == 2


def test_a_gltf_reads_its_buffer_beside_it_and_nothing_outside(makers: ModuleType, tmp_path: Path) -> None:
    binary = np.asarray(makers.POSITIONS, "<f4").tobytes() + np.asarray(makers.TRIANGLES, "<u4").tobytes()
    document = {
        "asset": {"version": "2.0", "extras": {"license": "CC-BY-4.0 (http://creativecommons.org/licenses/by/4.0/)"}},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
        ],
    }
    for uri in ("a%20b.bin", "data:application/octet-stream;base64," + base64.b64encode(binary).decode()):
        text = json.dumps(document | {"buffers": [{"byteLength": 96, "uri": uri}]})
        (part,), notes = makers.parts_of(
            makers.written(tmp_path / "in", {"a.gltf": text, "a b.bin": binary}) / "a.gltf"
        )
        assert np.array_equal(part.faces, makers.TRIANGLES)
        assert notes.facts["licence"] == "CC BY"
    makers.written(tmp_path, {"out.bin": binary})
    text = json.dumps(document | {"buffers": [{"byteLength": 96, "uri": "../out.bin"}]})
    with pytest.raises(
        InputError, match=r"a\.gltf: expected a buffer \('\.\./out\.bin'\) inside the folder, found none"
    ):
        makers.parts_of(makers.written(tmp_path / "in", {"a.gltf": text}) / "a.gltf")


BOMBS = {
    "accessor of gigabytes": {"accessors": [{"componentType": 5126, "count": 10**9, "type": "VEC3"}] * 3},
    "accessor past its view": {"accessors": [{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"}] * 3},
    "view past its buffer": {"bufferViews": [{"buffer": 0, "byteLength": 2**40}] * 3},
    "sparse without end": {
        "accessors": [{"componentType": 5126, "count": 4, "type": "VEC3", "sparse": {"count": 10**9}}] * 3
    },
    "node of itself": {"nodes": [{"mesh": 0, "children": [0]}]},
    "nodes in a ring": {"nodes": [{"children": [1]}, {"children": [0]}], "scenes": [{"nodes": [0]}]},
    "many nodes": {"nodes": [{"mesh": 0}] * 30_000, "scenes": [{"nodes": list(range(30_000))}]},
    "unknown mesh": {"nodes": [{"mesh": 7}]},
    "negative index": {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [-1]}]},
    "version 1": {"asset": {"version": "1.0"}},
    "nested deep": {"extras": json.loads("[" * 900 + "]" * 900)},
}


@pytest.mark.parametrize("change", BOMBS.values(), ids=BOMBS)
def test_what_would_exhaust_memory_or_time_is_one_line(makers: ModuleType, tmp_path: Path, change: dict) -> None:
    if "extras" in change:
        assert len(_parts(makers, tmp_path, makers.glb(**change))[0]) == 1
        return
    with pytest.raises(InputError, match=r"a\.glb: expected ") as caught:
        _parts(makers, tmp_path, makers.glb(**change))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"glTF nonsense", b"glTF\x02\0\0\0" + bytes(20), b"glTF" + bytes(8) + b"\xff" * 40, b"{" * 99999]
)
def test_a_file_that_is_no_glb_is_one_line(makers: ModuleType, tmp_path: Path, content: bytes) -> None:
    with pytest.raises(InputError, match=r"a\.glb: expected (a readable GLB mesh|glTF 2\.0)"):
        _parts(makers, tmp_path, content)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda content: content[:-60], r"cut short \([\d,]+ of [\d,]+ bytes\)"),
        (lambda _: b"<!DOCTYPE html>", "begins with b'<!DOCTYPE ht'"),
        (lambda content: content.replace(b'"scene": 0', b'"scene": 5'), "expected one of 1 scenes, found number 5"),
        (lambda content: content.replace(b'"count": 4', b'"kount": 4'), "no entry 'count'"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(
    makers: ModuleType, tmp_path: Path, change: Callable[[bytes], bytes], found: str
) -> None:
    with pytest.raises(InputError, match=rf"a\.glb: expected a readable GLB mesh, found .*{found}"):
        _parts(makers, tmp_path, change(makers.glb()))


def test_a_picture_of_transmission_is_a_remark(makers: ModuleType, tmp_path: Path) -> None:
    transmission = {"transmissionFactor": 1, "transmissionTexture": {"index": 0}}
    material = {"name": "pane", "extensions": {"KHR_materials_transmission": transmission}}
    (part,), notes = _parts(makers, tmp_path, makers.glb([material], makers.png()))
    assert part.look.glass is not None
    assert notes.remarks == ["'pane': its picture of transmission is not used; it is glass all over"]


@pytest.mark.parametrize("field", ["roughnessFactor", "metallicFactor", "baseColorFactor"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), "rough", None, [[1]], True])
def test_a_factor_that_is_no_number_is_refused(makers: ModuleType, tmp_path: Path, field: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"a\.glb: expected (a finite number|finite numbers) for {field}"):
        _parts(makers, tmp_path, makers.glb([makers.surface(**{field: value})]))


def test_an_attribute_with_another_number_of_rows_is_not_used(makers: ModuleType, tmp_path: Path) -> None:
    columns = {"NORMAL": makers.POSITIONS + 0.1, "COLOR_0": np.full((4, 3), 0.5)}
    content = makers.glb([makers.surface(**PICTURED)], makers.png(), columns).replace(b'"count": 4', b'"count": 3')
    content = content.replace(b'"count": 3', b'"count": 4', 1)  # the positions'
    (part,), _ = _parts(makers, tmp_path, content)
    assert part.uv is part.normals is None
    assert part.look.texture.kind == "uniform"
