from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
import trimesh
from trimesh.visual import TextureVisuals

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.core.mesh_file import read_mesh, write_mesh
from glassware.procedural.description.material import PictureTexture
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.scene.scene_file import assets_of, load_scene, save_scene


@pytest.fixture
def textured(analytic, tmp_path):
    """A scene that uses two files, one of them with an awkward name."""
    files = tmp_path / "mine"
    files.mkdir()
    (files / "sky ä&b.hdr").write_bytes(b"not really a sky")
    (files / "oak.png").write_bytes(b"not really wood")
    scene = analytic.scene()
    oak = scene.table.material.model_copy(update={"base_colour": PictureTexture(asset=asset(files / "oak.png"))})
    return scene.model_copy(
        update={
            "environment": PictureEnvironment(asset=asset(files / "sky ä&b.hdr")),
            "table": scene.table.model_copy(update={"material": oak}),
        }
    )


def _saved(scene, root):
    path = root / "scenes" / "000000" / "scene.json"
    path.parent.mkdir(parents=True)
    save_scene(scene, path, root / "assets")
    return path


def _meshes(scene):
    yield scene.table.mesh
    for vessel in scene.vessels:
        yield from (interface.mesh for interface in vessel.interfaces)
    yield from (prop.mesh for prop in scene.props)


def test_a_scene_comes_back_exactly(analytic, tmp_path):
    scene = analytic.scene()
    save_scene(scene, tmp_path / "scene.json")
    again = load_scene(tmp_path / "scene.json")
    assert again.model_dump_json() == scene.model_dump_json()
    for before, after in zip(_meshes(scene), _meshes(again), strict=True):
        assert before.name == after.name
        np.testing.assert_array_equal(before.vertices, after.vertices)
        np.testing.assert_array_equal(before.faces, after.faces)


def test_a_scene_is_saved_and_loaded_by_a_path_in_words_too(analytic, tmp_path):
    scene = analytic.scene()
    save_scene(scene, str(tmp_path / "scene.json"))
    assert load_scene(str(tmp_path / "scene.json")).model_dump_json() == scene.model_dump_json()


def test_saving_a_loaded_scene_writes_the_same_bytes(textured, tmp_path):
    first = _saved(textured, tmp_path / "a")
    second = _saved(load_scene(first), tmp_path / "b")
    names = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*") if path.is_file())
    assert names == sorted(path.relative_to(tmp_path / "b") for path in (tmp_path / "b").rglob("*") if path.is_file())
    assert all((tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() for name in names)
    assert second.read_bytes() == first.read_bytes()


def test_a_data_set_carries_its_assets_when_it_is_moved(textured, tmp_path):
    _saved(textured, tmp_path / "a")
    shutil.rmtree(tmp_path / "mine")
    (tmp_path / "a").rename(tmp_path / "elsewhere")
    again = load_scene(tmp_path / "elsewhere" / "scenes" / "000000" / "scene.json")
    assert [item.sha256 for item in assets_of(again)] == [item.sha256 for item in assets_of(textured)]
    assert len(assets_of(again)) == 2
    assert all(item.path.is_relative_to(tmp_path / "elsewhere" / "assets") for item in assets_of(again))


def test_scene_json_holds_no_path_of_the_machine_that_drew_it(textured, tmp_path):
    assert str(tmp_path) not in _saved(textured, tmp_path / "a").read_text(encoding="utf-8")


def test_a_mesh_with_normals_and_texture_coordinates_comes_back_bit_by_bit(tmp_path, rng):
    normals = rng.normal(size=(20, 3))
    mesh = Mesh("m", rng.normal(size=(20, 3)), rng.integers(0, 20, (7, 3)), normals, rng.random((20, 2)) * 9 - 4)
    write_mesh(mesh, tmp_path / "m.ply")
    again = read_mesh(tmp_path / "m.ply", "m")
    for field in ("vertices", "faces", "normals", "uv"):
        np.testing.assert_array_equal(getattr(again, field), getattr(mesh, field))
        assert getattr(again, field).dtype == getattr(mesh, field).dtype


def test_trimesh_reads_the_mesh_files(tmp_path, rng):
    ball = trimesh.creation.icosphere(subdivisions=2)
    mesh = Mesh("ball", ball.vertices, ball.faces, ball.vertex_normals, rng.random((len(ball.vertices), 2)))
    write_mesh(mesh, tmp_path / "ball.ply")
    again = trimesh.load_mesh(tmp_path / "ball.ply", process=False)
    assert isinstance(again, trimesh.Trimesh)
    assert isinstance(again.visual, TextureVisuals)
    assert again.visual.uv is not None
    np.testing.assert_array_equal(again.vertices.astype(np.float32), mesh.vertices)
    np.testing.assert_array_equal(again.faces, mesh.faces)
    np.testing.assert_array_equal(again.vertex_normals.astype(np.float32), mesh.normals)
    np.testing.assert_array_equal(again.visual.uv.astype(np.float32), mesh.uv)


def _edited(path, change):
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


def _no_traceback(error):
    assert "\n" not in str(error.value)
    assert "expected" in str(error.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.update(schema_version="glassware/scene/2"), "glassware/scene/1"),
        (lambda d: d.pop("schema_version"), "schema_version"),
        (lambda d: d.update(colour="red"), "colour"),
        (lambda d: d["cameras"][0].update(focal=-1.0), "focal"),
        (lambda d: d["vessels"][0]["interfaces"][0].update(mesh="missing"), "missing.ply"),
        (lambda d: d["props"][0].update(mesh="../../../secret"), "mesh name"),
        (lambda d: d["props"][0].update(mesh="/etc/passwd"), "mesh name"),
        (lambda d: d["props"][0].update(mesh="ball\n"), "mesh name"),
        (lambda d: d["props"][0].update(mesh=3), "mesh name"),
        (lambda d: d["props"][0].update(world_T_object=[[1, 2], [3, 4]]), "world_T_object"),
        (lambda d: d["props"][0].update(world_T_object={"a": 1}), "matrix"),
        (lambda d: d["props"][0].update(world_T_object=[[{"a": 1}] * 4] * 4), "matrix"),
        (lambda d: d["props"][0].update(world_T_object=[[10**400] * 4] * 4), "matrix"),
        (lambda d: d["props"][0].update(world_T_object=[["a"] * 4] * 4), "world_T_object"),
        (lambda d: d["props"][0].update(world_T_object=None), "world_T_object"),
        # Which scenes cannot exist is in test_sanity; here, that a file with one is refused, and named.
        (lambda d: d["props"][0].update(id=2), "scene.json: ball, id"),
        (lambda d: d["props"][0].update(size=[1.0, 1.0, 1.0]), "scene.json: ball, size"),
        (lambda d: d["cameras"][0].update(width=1 << 20), "scene.json: camera 0, width"),
        (lambda d: d["environment"]["asset"].update(path="/etc/passwd"), "asset"),
        (lambda d: d["environment"]["asset"].update(path="../../../0123456789abcdef-x"), "asset"),
        (lambda d: d["environment"]["asset"].update(path="../../assets/../dataset.json"), "asset"),
        (
            lambda d: d["environment"]["asset"].update(path="../../assets/0123456789abcdef-gone"),
            "0123456789abcdef-gone",
        ),
        (lambda d: d["environment"]["asset"].update(sha256="0" * 64), "SHA-256"),
    ],
)
def test_a_scene_file_that_is_wrong_is_one_clear_line(textured, tmp_path, change, words):
    path = _saved(textured, tmp_path / "a")
    _edited(path, change)
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert words in str(error.value)
    _no_traceback(error)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "3",
        '{"schema_version": NaN}',
        '{"schema_version": 1e999}',
        '{"schema_version": "glassware/scene/1", "schema_version": "glassware/scene/1"}',
        '{"a": {"b": 1, "b": 2}}',
        "[" * 200_000,
        "[" * 200_000 + "]" * 200_000,
        '{"a":' * 200_000 + "1" + "}" * 200_000,
        "\ufeff{}",
    ],
    ids=lambda text: text[:30],
)
def test_a_damaged_scene_file_is_one_clear_line(tmp_path, text):
    path = tmp_path / "scene.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(path) in str(error.value)
    _no_traceback(error)


def test_a_missing_scene_file_is_one_clear_line(tmp_path):
    with pytest.raises(InputError, match=r"scene\.json: expected a readable file"):
        load_scene(tmp_path / "scene.json")


def test_an_asset_that_links_out_of_the_data_set_is_refused(textured, tmp_path):
    path = _saved(textured, tmp_path / "a")
    stored = next((tmp_path / "a" / "assets").glob("*oak.png"))
    stored.rename(tmp_path / "outside.png")
    stored.symlink_to(tmp_path / "outside.png")
    with pytest.raises(InputError, match="a file inside"):
        load_scene(path)


def test_an_asset_that_changed_since_the_scene_was_drawn_is_refused(textured, tmp_path):
    (tmp_path / "mine" / "oak.png").write_bytes(b"something else")
    with pytest.raises(InputError, match="SHA-256"):
        _saved(textured, tmp_path / "a")


def test_two_meshes_of_one_name_are_a_fault_of_ours(analytic, tmp_path):
    scene = analytic.scene()
    other = Mesh("ball", *[getattr(scene.props[1].mesh, field) for field in ("vertices", "faces")])
    props = (scene.props[0], scene.props[1].model_copy(update={"mesh": other}))
    with pytest.raises(ValueError, match="'ball'"):
        save_scene(scene.model_copy(update={"props": props}), tmp_path / "scene.json")


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:-1],
        lambda data: data + b"\0",
        lambda data: data.replace(b"element vertex 3", b"element vertex 4"),
        lambda data: data.replace(b"element vertex 3", b"element vertex -3"),
        lambda data: data.replace(b"element vertex 3", b"element vertex 99999999999"),
        lambda data: data.replace(b"float x", b"float u"),
        lambda data: data.replace(b"ply", b"PLY", 1),
        lambda data: data[:-4] + np.int32(3).tobytes(),
        lambda data: data[:-4] + np.int32(-1).tobytes(),
        lambda data: data[:-13] + b"\4" + data[-12:],
        lambda data: data.replace(np.float32(1.5).tobytes(), np.float32(np.nan).tobytes()),
        lambda data: b"",
    ],
)
def test_a_damaged_mesh_file_is_one_clear_line(tmp_path, damage):
    write_mesh(Mesh("m", np.array([[0, 0, 0], [1.5, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])), tmp_path / "m.ply")
    data = (tmp_path / "m.ply").read_bytes()
    broken = damage(data)
    assert broken != data
    (tmp_path / "m.ply").write_bytes(broken)
    with pytest.raises(InputError) as error:
        read_mesh(tmp_path / "m.ply", "m")
    _no_traceback(error)
