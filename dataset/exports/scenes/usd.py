"""A scene as one USD file in text form, with its physics: Isaac Sim, Omniverse, Blender, usdview.

::

    000000.usda

Metres, kilograms, z up. Bodies are Xforms with meshes to look at, and convex meshes of purpose `guide` that touch.
(openusd.org: UsdGeom, UsdShade's UsdPreviewSurface, UsdPhysics. USD multiplies row vectors, so matrices are transposed,
and its cameras look along -z, y up.)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np
from scipy.spatial.transform import Rotation

from ....core.atomic_io import atomic_file
from ....core.mesh import Mesh
from ....procedural.description.camera import Camera
from ....procedural.description.scene import Scene
from ....procedural.optics.capillary import GRAVITY
from ....procedural.physics.mass import MassProperties, combined, moved_mass
from ...format import layout
from ...format.objects_file import ObjectRecord
from .folders import scene_files
from .simulated import (
    SimulatedBody,
    SimulatedTable,
    Surface,
    hull_mesh,
    relative_pose,
    simulated_bodies,
    simulated_table,
)

#: From USD's camera axes to OpenCV's.
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
#: Width of the film [tenths of a scene unit]: any will do, as only ratios matter; that of 35 mm film in millimetres.
_APERTURE = 36.0
#: Nearest and farthest depth that a viewer draws [m].
_CLIPPING = (0.01, 1000.0)
_HEAD = """#usda 1.0
(
    defaultPrim = "world"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
"""


class _Text:
    """A USD text file that is written from the top down."""

    def __init__(self, file: TextIO) -> None:
        self.file, self.depth = file, 0

    def line(self, text: str = "") -> None:
        """Write a line at the present depth."""
        self.file.write("    " * self.depth + text + "\n" if text else "\n")

    @contextmanager
    def prim(self, kind: str, name: str, *schemas: str, more: str = "") -> Iterator[None]:
        """Write a prim around what is written inside."""
        heads = [f"prepend apiSchemas = [{', '.join(map(_quoted, schemas))}]"] if schemas else []
        heads += [more] if more else []
        self.line(f'def {kind} "{name}"' + (f" ({'; '.join(heads)})" if heads else ""))
        self.line("{")
        self.depth += 1
        yield
        self.depth -= 1
        self.line("}")


def write_usd(path: Path, scene: Scene, records: Sequence[ObjectRecord], ids: Sequence[int]) -> None:
    """Write a scene with some of its objects.

    Parameters
    ----------
    path : Path
        The file, ``.usda``.
    scene : Scene
        The scene.
    records : sequence of ObjectRecord
        ``objects.json``.
    ids : sequence of int
        The objects; the table is there in any case.
    """
    table, bodies = simulated_table(scene), simulated_bodies(scene, records, ids)
    with atomic_file(path) as partial, partial.open("w", encoding="utf-8") as file:
        file.write(_HEAD)
        text = _Text(file)
        with text.prim("Xform", "world"):
            with text.prim("PhysicsScene", "physics"):
                text.line("vector3f physics:gravityDirection = (0, 0, -1)")
                text.line(f"float physics:gravityMagnitude = {GRAVITY!r}")
            with text.prim("Scope", "materials"):
                for surface in (table.surface, *(surface for body in bodies for surface in body.surfaces)):
                    _material(text, surface)
                for name, friction in (("table", table.friction), *((b.name, b.mechanics.friction) for b in bodies)):
                    _contact(text, name, friction)
            _table(text, table)
            for body in bodies:
                if body.attached_to is None:
                    _body(text, body, [other for other in bodies if other.attached_to == body.name], bodies)
            for number, camera in enumerate(scene.cameras):
                _camera(text, camera, number)


def _material(text: _Text, surface: Surface) -> None:
    look, name = surface.look, _identifier(surface.name)
    with text.prim("Material", name):
        text.line(f"token outputs:surface.connect = </world/materials/{name}/surface.outputs:surface>")
        with text.prim("Shader", "surface"):
            text.line('uniform token info:id = "UsdPreviewSurface"')
            text.line(f"color3f inputs:diffuseColor = {_tuple(look.colour)}")
            text.line(f"float inputs:roughness = {look.roughness!r}")
            text.line(f"float inputs:metallic = {look.metallic!r}")
            text.line(f"float inputs:opacity = {look.opacity!r}")
            if look.eta is not None:
                text.line(f"float inputs:ior = {look.eta!r}")
            text.line("token outputs:surface")


def _contact(text: _Text, name: str, friction: float) -> None:
    with text.prim("Material", f"{name}_contact", "PhysicsMaterialAPI"):
        text.line(f"float physics:staticFriction = {friction!r}")
        text.line(f"float physics:dynamicFriction = {friction!r}")
        text.line("float physics:restitution = 0")


def _table(text: _Text, table: SimulatedTable) -> None:
    with text.prim("Xform", "table"):
        _mesh(text, table.surface)
        with text.prim("Cube", "top", "PhysicsCollisionAPI", "MaterialBindingAPI"):
            text.line('uniform token purpose = "guide"')
            text.line("double size = 2")
            text.line(f"double3 xformOp:translate = {_tuple(table.centre)}")
            text.line(f"float3 xformOp:scale = {_tuple(table.half)}")
            text.line('uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]')
            text.line("rel material:binding:physics = </world/materials/table_contact>")


def _body(text: _Text, body: SimulatedBody, attached: Sequence[SimulatedBody], bodies: Sequence[SimulatedBody]) -> None:
    """Write a rigid body with what moves with it: their masses are one."""
    parts = [moved_mass(part.mechanics.whole, relative_pose(part, bodies)) for part in attached]
    whole = combined([body.mechanics.whole, *parts])
    with text.prim("Xform", body.name, "PhysicsRigidBodyAPI", "PhysicsMassAPI", more='kind = "component"'):
        text.line(f"custom int glassware:id = {body.item.id}")
        text.line(f"custom string glassware:category = {_quoted(body.item.category)}")
        _mass(text, whole)
        _shape(text, body, body.pose, f"/world/{body.name}")
        for part in attached:
            with text.prim("Xform", part.name):
                text.line(f"custom int glassware:id = {part.item.id}")
                text.line(f"custom string glassware:category = {_quoted(part.item.category)}")
                _shape(text, part, relative_pose(part, bodies), f"/world/{body.name}/{part.name}")


def _mass(text: _Text, whole: MassProperties) -> None:
    moments, axes = np.linalg.eigh(np.array(whole.inertia))
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # a rotation, not a reflection
    x, y, z, w = Rotation.from_matrix(axes).as_quat().tolist()
    text.line(f"float physics:mass = {whole.mass!r}")
    text.line(f"point3f physics:centerOfMass = {_tuple(whole.centre_of_mass)}")
    text.line(f"float3 physics:diagonalInertia = {_tuple(moments)}")
    text.line(f"quatf physics:principalAxes = {_tuple((w, x, y, z))}")


def _shape(text: _Text, body: SimulatedBody, pose: np.ndarray, path: str) -> None:
    """Write the pose of a body, its surfaces, and the convex parts that touch."""
    _pose(text, pose)
    for surface in body.surfaces:
        _mesh(text, surface)
    if not body.touching:
        return
    with text.prim("Scope", "contacts"):
        for index, part in enumerate(body.touching):
            name = f"part_{index}"
            schemas = ("PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI")
            with text.prim("Mesh", f"{name}_0", *schemas):
                _points(text, hull_mesh(part.points, name))
                text.line('uniform token purpose = "guide"')
                text.line('uniform token physics:approximation = "convexHull"')
                text.line(f"rel material:binding:physics = </world/materials/{body.name}_contact>")
            for turn in range(1, part.turns):
                first = f"prepend references = <{path}/contacts/{name}_0>"
                with text.prim("Mesh", f"{name}_{turn}", more=first):
                    text.line(f"double xformOp:rotateZ = {360.0 * turn / part.turns!r}")
                    text.line('uniform token[] xformOpOrder = ["xformOp:rotateZ"]')


def _mesh(text: _Text, surface: Surface) -> None:
    name = _identifier(surface.name)
    with text.prim("Mesh", name, "MaterialBindingAPI"):
        _points(text, surface.mesh)
        text.line("uniform bool doubleSided = 1")
        text.line(f"rel material:binding = </world/materials/{name}>")


def _points(text: _Text, mesh: Mesh) -> None:
    text.line('uniform token subdivisionScheme = "none"')
    text.line(f"float3[] extent = [{', '.join(_tuple(row) for row in mesh.bounds)}]")
    text.line(f"point3f[] points = [{_rows(mesh.vertices)}]")
    text.line(f"int[] faceVertexCounts = [{', '.join(['3'] * len(mesh.faces))}]")
    text.line(f"int[] faceVertexIndices = [{', '.join(map(str, mesh.faces.ravel().tolist()))}]")
    if mesh.normals is not None:
        text.line(f'normal3f[] normals = [{_rows(mesh.normals)}] (interpolation = "vertex")')


def _pose(text: _Text, pose: np.ndarray) -> None:
    text.line(f"matrix4d xformOp:transform = ({', '.join(_tuple(row) for row in pose.T)})")
    text.line('uniform token[] xformOpOrder = ["xformOp:transform"]')


def _camera(text: _Text, camera: Camera, number: int) -> None:
    """Write a left camera; the offset of the film is where its middle is, right and up of the optical axis."""
    (cx, cy), width, height = camera.centre, camera.width, camera.height
    focal = camera.fx * _APERTURE / width
    tall = focal * height / camera.fy
    with text.prim("Camera", f"view_{layout.view_name(number)}"):
        _pose(text, np.asarray(camera.world_T_camera) @ _FLIP)
        text.line(f"float focalLength = {focal!r}")
        text.line(f"float horizontalAperture = {_APERTURE!r}")
        text.line(f"float verticalAperture = {tall!r}")
        text.line(f"float horizontalApertureOffset = {(0.5 * width - cx - 0.5) / width * _APERTURE!r}")
        text.line(f"float verticalApertureOffset = {(cy + 0.5 - 0.5 * height) / height * tall!r}")
        text.line(f"float2 clippingRange = {_tuple(_CLIPPING)}")
        text.line(f"custom double glassware:baseline = {camera.baseline!r}")


def _identifier(name: str) -> str:
    return name.replace("-", "_")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
    return f'"{escaped}"'


def _tuple(values: Iterable[float]) -> str:
    return f"({', '.join(repr(float(value)) for value in values)})"


def _rows(values: np.ndarray) -> str:
    """Return vectors of float32 with nine digits, which read back exactly."""
    return ", ".join(f"({x:.9g}, {y:.9g}, {z:.9g})" for x, y, z in values.tolist())


EXPORTER = scene_files("scenes with physics: Isaac Sim, Omniverse, Blender", ".usda", write_usd)
