"""URDF read by its definition (links, joints, turns about fixed axes), and by yourdfpy where it is installed."""

from __future__ import annotations

import xml.etree.ElementTree as tree
from typing import Any

import numpy as np
import pytest
import trimesh

from glassware.dataset.exports.run import export
from glassware.dataset.exports.scenes.urdf import write_urdf
from glassware.dataset.reader import Dataset
from glassware.procedural.description.scene import Prop, glass_solid


@pytest.fixture(scope="module")
def made(proven, tmp_path_factory):
    folder = tmp_path_factory.mktemp("urdf")
    export(proven, "urdf", folder / "out")
    scene = Dataset.open(proven).scenes[0]
    return scene.scene(), scene.objects().objects, folder / "out" / "000000"


def links_of(path) -> dict[str, Any]:
    return {link.get("name", ""): link for link in tree.parse(path).getroot().iter("link")}


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def origin(element):
    """The pose of an element, by the words of URDF: roll, pitch and yaw about the fixed axes x, y, z."""
    found, stated = np.eye(4), element.find("origin")
    if stated is not None:
        roll, pitch, yaw = map(float, stated.get("rpy").split())
        found[:3, :3] = turn("z", yaw) @ turn("y", pitch) @ turn("x", roll)
        found[:3, 3] = [float(word) for word in stated.get("xyz").split()]
    return found


def poses(path):
    """Poses of all links in the root's frame."""
    root: Any = tree.parse(path).getroot()
    joints = {joint.find("child").get("link"): joint for joint in root.iter("joint")}

    def pose(link):
        joint = joints.get(link)
        return np.eye(4) if joint is None else pose(joint.find("parent").get("link")) @ origin(joint)

    return {name: pose(name) for name in links_of(path)}


def test_links_are_where_the_objects_are(made):
    scene, _, folder = made
    found = poses(folder / "scene.urdf")
    for item in scene.objects:
        np.testing.assert_allclose(found[item.name.replace("-", "_")], item.world_T_object, atol=1e-6)


def test_links_have_mass_inertia_friction_and_meshes(made):
    scene, records, folder = made
    links = links_of(folder / "scene.urdf")
    for item, record in zip(scene.objects, records, strict=True):
        link, whole = links[item.name.replace("-", "_")], record.mechanics.whole
        assert float(link.find("inertial/mass").get("value")) == whole.mass
        np.testing.assert_allclose(origin(link.find("inertial"))[:3, 3], whole.centre_of_mass, atol=1e-12)
        stated = link.find("inertial/inertia").attrib
        rows = np.array([[float(stated["i" + "".join(sorted(a + b))]) for b in "xyz"] for a in "xyz"])
        np.testing.assert_allclose(rows, whole.inertia, rtol=1e-12)
        assert float(link.find("contact/lateral_friction").get("value")) == record.mechanics.friction
        solid = item.mesh if isinstance(item, Prop) else glass_solid(item)
        first: Any = trimesh.load_mesh(folder / link.find("visual/geometry/mesh").get("filename"), process=False)
        assert first.bounds[0] == pytest.approx(solid.bounds[0], abs=1e-6) or len(link.findall("visual")) > 1


def test_convex_parts_enclose_the_glass_and_leave_it_hollow(made):
    scene, _, folder = made
    vessel = scene.vessels[0]
    links = links_of(folder / "scene.urdf")
    parts: list[Any] = []
    for collision in links[vessel.name.replace("-", "_")].findall("collision"):
        mesh: Any = trimesh.load_mesh(folder / collision.find("geometry/mesh").get("filename"))
        assert mesh.is_watertight
        assert mesh.is_convex
        parts.append(mesh.apply_transform(origin(collision)))
    glass = trimesh.Trimesh(glass_solid(vessel).vertices, glass_solid(vessel).faces)
    volume = sum(part.volume for part in parts)
    hull = glass.convex_hull.volume
    assert glass.volume < volume < 0.7 * hull
    low, high = np.min([part.bounds[0] for part in parts], 0), np.max([part.bounds[1] for part in parts], 0)
    np.testing.assert_allclose([low, high], glass.bounds, atol=1e-3)


def test_each_object_has_a_file_of_its_own_with_what_goes_with_it(made, tmp_path):
    scene, records, folder = made
    assert len(list((folder / "objects").iterdir())) == len(scene.objects)
    vessel, prop = scene.vessels[0], scene.props[0]
    changed = scene.model_copy(update={"props": (prop.model_copy(update={"part_of": vessel.name}),)})
    write_urdf(tmp_path, changed, records, [vessel.id, prop.id])
    (alone,) = (tmp_path / "objects").iterdir()
    found = poses(alone)[prop.name.replace("-", "_")]
    np.testing.assert_allclose(np.array(vessel.world_T_object) @ found, prop.world_T_object, atol=1e-6)
    for mesh in tree.parse(alone).getroot().iter("mesh"):
        assert (alone.parent / mesh.attrib["filename"]).is_file()


def test_yourdfpy_reads_the_same(made):
    yourdfpy = pytest.importorskip("yourdfpy", exc_type=ImportError)
    scene, records, folder = made
    robot = yourdfpy.URDF.load(str(folder / "scene.urdf"), load_collision_meshes=True)
    assert robot.validate()
    for item, record in zip(scene.objects, records, strict=True):
        name = item.name.replace("-", "_")
        np.testing.assert_allclose(robot.get_transform(name, "world"), item.world_T_object, atol=1e-6)
        assert robot.link_map[name].inertial.mass == pytest.approx(record.mechanics.whole.mass)
