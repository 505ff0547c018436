"""A scene for ROS, PyBullet and SAPIEN: URDF files beside their meshes.

::

    000000/scene.urdf                      world, table and all objects
    000000/objects/vessel_00.urdf          one object with what goes with it, to be placed by a simulator
    000000/meshes/vessel_00-glass.obj

(wiki.ros.org/urdf/XML: link, joint. Friction is no part of URDF: `contact` is PyBullet's, `gazebo` Gazebo's.)
"""

from __future__ import annotations

import xml.etree.ElementTree as tree
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ....procedural.description.scene import Scene
from ...format.objects_file import ObjectRecord
from .folders import scene_folders
from .looks import Look, shown_colour
from .simulated import (
    SimulatedBody,
    Surface,
    hull_mesh,
    relative_pose,
    simulated_bodies,
    simulated_table,
    write_obj,
)
from .xml_files import element, write_xml

#: Axes of the inertia matrix, by URDF's names.
_INERTIA = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}

#: Cosine of the pitch below which roll and yaw are no longer told apart [1]: the rounding of a rotation matrix.
_STEEP = 1e-9


def write_urdf(folder: Path, scene: Scene, records: Sequence[ObjectRecord], ids: Sequence[int]) -> None:
    """Write ``scene.urdf``, a file for each object, and their meshes into a folder.

    Parameters
    ----------
    folder : Path
        An existing folder.
    scene : Scene
        The scene.
    records : sequence of ObjectRecord
        ``objects.json``.
    ids : sequence of int
        The objects; the table is there in any case.
    """
    for name in ("meshes", "objects"):
        (folder / name).mkdir()
    table, bodies = simulated_table(scene), simulated_bodies(scene, records, ids)
    write_obj(folder / "meshes" / f"{table.surface.name}.obj", table.surface.mesh)
    for body in bodies:
        _write_meshes(folder, body)
    whole = tree.Element("robot", name=f"scene_{scene.scene_id}")
    element(whole, "link", name="world")
    link = element(whole, "link", name="table")
    _visual(link, table.surface, "")
    box = element(link, "collision")
    _origin(box, np.array(table.centre), np.eye(3))
    element(element(box, "geometry"), "box", size=2.0 * np.array(table.half))
    _friction(whole, link, table.friction)
    _joint(whole, "world", "table", np.eye(4), "fixed")
    for body in bodies:
        _link(whole, body, "")
    for body in bodies:
        above = body.attached_to or "world"
        _joint(whole, above, body.name, relative_pose(body, bodies), "fixed" if body.attached_to else "floating")
    write_xml(folder / "scene.urdf", whole)
    for body in (body for body in bodies if body.attached_to is None):
        attached = [other for other in bodies if other.attached_to == body.name]
        alone = tree.Element("robot", name=body.name)
        for part in (body, *attached):
            _link(alone, part, "../")
        for part in attached:
            _joint(alone, body.name, part.name, relative_pose(part, bodies), "fixed")
        write_xml(folder / "objects" / f"{body.name}.urdf", alone)


def _write_meshes(folder: Path, body: SimulatedBody) -> None:
    for surface in body.surfaces:
        write_obj(folder / "meshes" / f"{surface.name}.obj", surface.mesh)
    for index, part in enumerate(body.touching):
        name = f"{body.name}-part-{index}"
        write_obj(folder / "meshes" / f"{name}.obj", hull_mesh(part.points, name))


def _link(robot: tree.Element, body: SimulatedBody, up: str) -> None:
    """Add a link; `up` leads from its file to the folder of the scene."""
    link, whole = element(robot, "link", name=body.name), body.mechanics.whole
    inertial = element(link, "inertial")
    _origin(inertial, np.array(whole.centre_of_mass), np.eye(3))
    element(inertial, "mass", value=whole.mass)
    rows = np.array(whole.inertia)
    element(inertial, "inertia", **{name: float(rows[place]) for name, place in _INERTIA.items()})
    for surface in body.surfaces:
        _visual(link, surface, up)
    for index, part in enumerate(body.touching):
        for turn in range(part.turns):
            collision = element(link, "collision")
            spin = Rotation.from_euler("z", 2.0 * np.pi * turn / part.turns).as_matrix()
            _origin(collision, np.zeros(3), spin)
            element(element(collision, "geometry"), "mesh", filename=f"{up}meshes/{body.name}-part-{index}.obj")
    _friction(robot, link, body.mechanics.friction)


def _visual(link: tree.Element, surface: Surface, up: str) -> None:
    visual = element(link, "visual", name=surface.name)
    element(element(visual, "geometry"), "mesh", filename=f"{up}meshes/{surface.name}.obj")
    element(element(visual, "material", name=surface.name), "color", rgba=_rgba(surface.look))


def _rgba(look: Look) -> list[float]:
    return [*shown_colour(look), look.opacity]


def _friction(robot: tree.Element, link: tree.Element, friction: float) -> None:
    element(element(link, "contact"), "lateral_friction", value=friction)
    gazebo = element(robot, "gazebo", reference=link.get("name"))
    for axis in ("mu1", "mu2"):
        element(gazebo, axis).text = repr(friction)


def _joint(robot: tree.Element, parent: str, child: str, pose: np.ndarray, kind: str) -> None:
    joint = element(robot, "joint", name=f"{parent}-{child}", type=kind)
    _origin(joint, pose[:3, 3], pose[:3, :3])
    element(joint, "parent", link=parent)
    element(joint, "child", link=child)


def _origin(above: tree.Element, position: np.ndarray, rotation: np.ndarray) -> None:
    """Add a pose; `rpy` are turns about the fixed axes x, y and z, in this order."""
    if np.array_equal(rotation, np.eye(3)) and not position.any():
        return
    element(above, "origin", xyz=position, rpy=_roll_pitch_yaw(rotation))


def _roll_pitch_yaw(rotation: np.ndarray) -> list[float]:
    pitch = float(np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0])))
    if np.hypot(rotation[0, 0], rotation[1, 0]) < _STEEP:  # x points up or down: only roll and yaw together are defined
        return [float(np.arctan2(-rotation[1, 2], rotation[1, 1])), pitch, 0.0]
    roll, yaw = np.arctan2(rotation[2, 1], rotation[2, 2]), np.arctan2(rotation[1, 0], rotation[0, 0])
    return [float(roll), pitch, float(yaw)]


EXPORTER = scene_folders("scenes with physics: ROS, PyBullet, SAPIEN", write_urdf)
