"""A scene for MuJoCo: one MJCF file beside its meshes.

::

    000000/scene.xml
    000000/meshes/vessel_00-glass.obj

Bodies have the contacts with which scenes come to rest here (`procedural.physics.world`), so a pile stays where it is.
(MuJoCo's documentation, "XML Reference"; its cameras look along -z, y up.)
"""

from __future__ import annotations

import xml.etree.ElementTree as tree
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....procedural.description.camera import Camera
from ....procedural.description.scene import Scene
from ....procedural.optics.capillary import GRAVITY
from ....procedural.physics.wedges import ConvexPart
from ....procedural.physics.world import (
    FRICTION_STIFFNESS,
    MEETS_BODIES,
    MEETS_TABLE,
    SLIDING,
    contact_settings,
)
from ...format import layout
from ...format.objects_file import ObjectRecord
from .folders import scene_folders
from .looks import Look, shown_colour
from .simulated import SimulatedBody, Surface, relative_pose, simulated_bodies, simulated_table, write_obj
from .xml_files import element, quaternion, write_xml

#: From MuJoCo's camera axes to OpenCV's.
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
#: Width of the sensor [m]: any will do, as focal lengths are in pixels; that of 35 mm film.
_SENSOR = 0.036
#: Time step [s]: a fifth of the time constant of contacts.
_STEP = 2e-3
#: Group of geometry that viewers show, and that of contacts, which they hide (MuJoCo's own menagerie of models).
_SHOWN, _HIDDEN = 2, 3


def write_mjcf(folder: Path, scene: Scene, records: Sequence[ObjectRecord], ids: Sequence[int]) -> None:
    """Write ``scene.xml`` and its meshes into a folder.

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
    (folder / "meshes").mkdir()
    root = tree.Element("mujoco", model=f"scene {scene.scene_id}")
    element(root, "compiler", angle="radian", meshdir="meshes", balanceinertia="true")
    option = {"timestep": _STEP, "gravity": [0.0, 0.0, -GRAVITY], "integrator": "implicitfast"}
    element(root, "option", **option, cone="elliptic", impratio=FRICTION_STIFFNESS)
    widest = max(scene.cameras, key=lambda camera: camera.width)
    element(element(root, "visual"), "global", offwidth=widest.width, offheight=max(c.height for c in scene.cameras))
    assets, world = element(root, "asset"), element(root, "worldbody")
    table = simulated_table(scene)
    _shown(assets, world, folder, table.surface)
    contact = contact_settings(table.friction, (MEETS_TABLE, 0))
    element(world, "geom", name="table", type="box", size=table.half, pos=table.centre, group=_HIDDEN, **contact)
    bodies = simulated_bodies(scene, records, ids)
    frames: dict[str, tree.Element] = {}
    for body in sorted(bodies, key=lambda body: body.attached_to is not None):
        above = world if body.attached_to is None else frames[body.attached_to]
        frames[body.name] = _body(assets, above, folder, body, relative_pose(body, bodies))
    for number, camera in enumerate(scene.cameras):
        _camera(world, camera, number)
    write_xml(folder / "scene.xml", root)


def _body(
    assets: tree.Element, above: tree.Element, folder: Path, body: SimulatedBody, pose: np.ndarray
) -> tree.Element:
    frame = element(above, "body", name=body.name, pos=pose[:3, 3], quat=quaternion(pose))
    if body.attached_to is None:
        element(frame, "freejoint", name=body.name)
    whole = body.mechanics.whole
    rows = np.array(whole.inertia)
    inertia = [rows[0, 0], rows[1, 1], rows[2, 2], rows[0, 1], rows[0, 2], rows[1, 2]]
    element(frame, "inertial", pos=whole.centre_of_mass, mass=whole.mass, fullinertia=inertia)
    for surface in body.surfaces:
        _shown(assets, frame, folder, surface)
    friction, apart = body.mechanics.friction, bool(body.shape.parts)
    if body.touching:
        # The table meets the hull, which touches a plane where the body does; bodies meet each other's parts.
        kinds = (0, MEETS_TABLE) if apart else (MEETS_BODIES, MEETS_TABLE | MEETS_BODIES)
        hull = ConvexPart(body.shape.hull)
        _touching(assets, frame, f"{body.name}-hull", hull, contact_settings(friction, kinds))
    settings = contact_settings(friction, (MEETS_BODIES, MEETS_BODIES)) | {"condim": SLIDING}
    for index, part in enumerate(body.touching if apart else ()):
        _touching(assets, frame, f"{body.name}-part-{index}", part, settings)
    return frame


def _shown(assets: tree.Element, frame: tree.Element, folder: Path, surface: Surface) -> None:
    """Add a surface that is seen and touches nothing."""
    write_obj(folder / "meshes" / f"{surface.name}.obj", surface.mesh)
    # Open surfaces have no volume, and the inertia is stated anyway.
    element(assets, "mesh", name=surface.name, file=f"{surface.name}.obj", inertia="shell")
    look = surface.look
    element(assets, "material", name=surface.name, rgba=_rgba(look), **_shine(look))
    contact = {"contype": 0, "conaffinity": 0, "group": _SHOWN, "mass": 0}
    element(frame, "geom", type="mesh", mesh=surface.name, material=surface.name, **contact)


def _touching(assets: tree.Element, frame: tree.Element, name: str, part: ConvexPart, contact: dict[str, Any]) -> None:
    element(assets, "mesh", name=name, vertex=part.points, inertia="convex")
    for turn in range(part.turns):
        half = np.pi * turn / part.turns
        spin = [float(np.cos(half)), 0.0, 0.0, float(np.sin(half))] if turn else None
        element(frame, "geom", type="mesh", mesh=name, quat=spin, group=_HIDDEN, mass=0, **contact)


def _rgba(look: Look) -> list[float]:
    return [*shown_colour(look), look.opacity]


def _shine(look: Look) -> dict[str, float]:
    return {"specular": 1.0 - look.roughness, "shininess": 1.0 - look.roughness, "reflectance": 0.0}


def _camera(world: tree.Element, camera: Camera, number: int) -> None:
    """Add a left camera; its principal point is counted to the left and up from the middle of the picture."""
    pose = np.asarray(camera.world_T_camera) @ _FLIP
    (cx, cy), width, height = camera.centre, camera.width, camera.height
    element(
        world,
        "camera",
        name=f"view-{layout.view_name(number)}",
        pos=pose[:3, 3],
        quat=quaternion(pose),
        resolution=[width, height],
        sensorsize=[_SENSOR, _SENSOR * height / width],
        focalpixel=[camera.fx, camera.fy],
        principalpixel=[0.5 * width - cx - 0.5, 0.5 * height - cy - 0.5],
    )


EXPORTER = scene_folders("scenes with physics: MuJoCo", write_mjcf)
