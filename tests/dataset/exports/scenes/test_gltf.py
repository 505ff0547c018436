"""glTF files that trimesh reads: poses, meshes, cameras, and the constants of glass."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest
import trimesh

from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset
from glassware.procedural.description.scene import Prop, glass_solid, liquid_solid

#: From glTF's axes, y up, to ours, z up.
Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
#: From glTF's camera axes to OpenCV's.
GL = np.diag([1.0, -1.0, -1.0, 1.0])


def _json(path) -> dict[str, Any]:
    """The JSON of a binary glTF file, by its specification."""
    data = path.read_bytes()
    magic, version, size, length, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, size, kind) == (b"glTF", 2, len(data), b"JSON")
    return json.loads(data[20 : 20 + length])


@pytest.fixture(scope="module")
def made(proven, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gltf")
    export(proven, "gltf", folder / "out")
    return Dataset.open(proven).scenes[0].scene(), folder / "out" / "000000.glb"


def test_objects_come_back_where_they_are(made):
    scene, path = made
    found: Any = trimesh.load(path, process=False)
    for item in scene.objects:
        pose = Z_UP @ found.graph[item.name][0]
        np.testing.assert_allclose(pose, item.world_T_object, atol=1e-6)
        solids = [item.mesh] if isinstance(item, Prop) else [glass_solid(item)]
        solids += [liquid_solid(item)] if not isinstance(item, Prop) and item.liquid else []
        (index,) = [node for node in _json(path)["nodes"] if node.get("name") == item.name]
        assert index["extras"]["id"] == item.id
        parts = [mesh for name, mesh in found.geometry.items() if name.startswith(item.name)]
        assert sum(len(part.faces) for part in parts) == sum(len(solid.faces) for solid in solids)
        volume = sum(trimesh.Trimesh(solid.vertices, solid.faces).volume for solid in solids)
        assert sum(part.volume for part in parts) == pytest.approx(volume, rel=1e-6)


def test_cameras_come_back(made):
    scene, path = made
    content = _json(path)
    nodes = {node["name"]: (number, node) for number, node in enumerate(content["nodes"])}
    root = nodes["world"][1]
    turn = np.reshape(root["matrix"], (4, 4)).T
    for number, camera in enumerate(scene.cameras):
        index, node = nodes[f"view-{number:03d}"]
        assert index in root["children"]
        pose = turn @ np.reshape(node["matrix"], (4, 4)).T  # trimesh leaves out what is above a camera
        np.testing.assert_allclose(Z_UP @ pose @ GL, camera.world_T_camera, atol=1e-12)
        lens = content["cameras"][number]["perspective"]
        focal = 0.5 * camera.height / np.tan(0.5 * lens["yfov"])
        assert focal == pytest.approx(camera.fy)
        assert camera.width / lens["aspectRatio"] * camera.fx / focal == pytest.approx(camera.height)


def test_glass_has_its_index_and_what_it_absorbs(made):
    scene, path = made
    content = _json(path)
    meshes = {node["name"]: content["meshes"][node["mesh"]] for node in content["nodes"] if "mesh" in node}
    for body in scene.vessels:  # glasses of one name may absorb differently
        used = [content["materials"][one["material"]] for one in meshes[body.name]["primitives"]]
        (extensions,) = [material["extensions"] for material in used if material["name"] == body.glass.name]
        assert extensions["KHR_materials_ior"]["ior"] == body.glass.eta
        volume = extensions["KHR_materials_volume"]
        sigma = -np.log(volume["attenuationColor"]) / volume["attenuationDistance"]
        np.testing.assert_allclose(sigma, body.glass.sigma_a, atol=1e-9)


def test_vessels_alone_leave_out_props(proven, made, tmp_path):
    scene, _ = made
    export(proven, "gltf", tmp_path / "out", vessels_only=True)
    names = {node["name"] for node in _json(tmp_path / "out" / "000000.glb")["nodes"]}
    assert {body.name for body in scene.vessels} <= names
    assert not {prop.name for prop in scene.props} & names
