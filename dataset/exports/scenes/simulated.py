"""The bodies of a scene as simulators take them: surfaces to look at, convex parts that touch, mass and friction."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....annotate.projection import inverse_pose
from ....core.mesh import Mesh, some_faces
from ....procedural.description.scene import Prop, Scene, SceneObject, content_solid, glass_solid, liquid_solid
from ....procedural.description.standing import wetted_surfaces
from ....procedural.physics.bodies import Mechanics, mechanics_of
from ....procedural.physics.parts import ON_THE_WALL, BodyParts, body_parts
from ....procedural.physics.substances import substance_of
from ....procedural.physics.wedges import ConvexPart
from ...format.objects_file import ObjectRecord
from .looks import Look, medium_look, opaque_look

#: What no name in XML or USD may have.
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_]")
#: Thickness of the table's top as a body [m]: nothing falls through it at the steps that simulators take.
TABLE_THICKNESS = 0.1


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface with one look."""

    name: str
    mesh: Mesh  #: object frame [m]
    look: Look


@dataclass(frozen=True, eq=False)
class SimulatedBody:
    """A rigid body."""

    name: str  #: unique, of letters, digits and underscores
    item: SceneObject
    surfaces: tuple[Surface, ...]
    shape: BodyParts  #: what touches, object frame
    mechanics: Mechanics  #: of this body alone, with its liquid
    attached_to: str | None  #: name of the body that it moves with, such as a cap's bottle

    @property
    def pose(self) -> np.ndarray:
        """Its pose, ``world_T_object``."""
        return np.asarray(self.item.world_T_object)

    @property
    def touching(self) -> tuple[ConvexPart, ...]:
        """The convex bodies that stand for it where bodies meet; none for what lies on a wall, such as a label."""
        if self.item.category in ON_THE_WALL and self.attached_to:
            return ()
        return self.shape.parts or (ConvexPart(self.shape.hull),)


@dataclass(frozen=True, eq=False)
class SimulatedTable:
    """The table: it does not move, and its top is at z = 0."""

    surface: Surface
    centre: tuple[float, float, float]  #: of the box that stands for it [m]
    half: tuple[float, float, float]  #: half its extent [m]
    friction: float


def simulated_bodies(scene: Scene, records: Sequence[ObjectRecord], ids: Sequence[int]) -> list[SimulatedBody]:
    """Return some of a scene's objects as rigid bodies, in the order of their ids.

    Parameters
    ----------
    scene : Scene
        The scene.
    records : sequence of ObjectRecord
        ``objects.json``. Mechanical properties that it lacks, as in data sets of earlier versions, are computed.
    ids : sequence of int
        The objects.
    """
    chosen = {item.id: item for item in scene.objects if item.id in ids}
    names = _names([(item.id, item.name) for item in chosen.values()])
    by_name = {item.name: names[item.id] for item in chosen.values()}
    stated = {record.id: record.mechanics for record in records}
    return [
        SimulatedBody(
            name=names[item.id],
            item=item,
            surfaces=tuple(_surfaces(item, names[item.id])),
            shape=body_parts(item),
            mechanics=stated.get(item.id) or mechanics_of(item, wetted_surfaces(scene.objects, item)),
            attached_to=by_name.get(item.part_of) if item.part_of else None,
        )
        for item in chosen.values()
    ]


def simulated_table(scene: Scene) -> SimulatedTable:
    """Return the table of a scene: its look, and the box below its top."""
    table = scene.table
    width, depth, _ = table.size
    return SimulatedTable(
        surface=Surface("table", table.mesh, opaque_look(table.material, table.mesh)),
        centre=(0.0, 0.0, -0.5 * TABLE_THICKNESS),
        half=(0.5 * width, 0.5 * depth, 0.5 * TABLE_THICKNESS),
        friction=substance_of(table.material).friction,
    )


def relative_pose(body: SimulatedBody, bodies: Sequence[SimulatedBody]) -> np.ndarray:
    """Return the pose of a body in the frame of what it is attached to; in the world where it is free, (4, 4)."""
    if body.attached_to is None:
        return body.pose
    (above,) = (other for other in bodies if other.name == body.attached_to)
    return inverse_pose(above.pose) @ body.pose


def hull_mesh(points: np.ndarray, name: str) -> Mesh:
    """Return the convex hull of points as a closed mesh, normals out."""
    from scipy.spatial import ConvexHull  # here, as it takes a third of a second to load

    hull = ConvexHull(points)
    corners, faces = np.unique(hull.simplices, return_inverse=True)
    faces = faces.reshape(-1, 3)
    places = hull.points[corners]
    a, b, c = (places[faces[:, k]] for k in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return Mesh(name, places, faces)


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write positions, normals if there are any, and faces as a Wavefront OBJ file; numbers read back exactly."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices.tolist()]
    if mesh.normals is not None:
        lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.normals.tolist()]
    corner = "{0}" if mesh.normals is None else "{0}//{0}"
    row = "f " + " ".join([corner, corner.replace("0", "1"), corner.replace("0", "2")])
    lines += [row.format(*face) for face in (mesh.faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", "ascii")


def _surfaces(item: SceneObject, name: str) -> list[Surface]:
    if isinstance(item, Prop):
        found, start = [], 0
        for number, piece in enumerate(item.pieces):
            if piece.faces:
                mesh = some_faces(item.mesh, slice(start, start + piece.faces), f"{name}-{number}")
                found.append(Surface(mesh.name, mesh, opaque_look(piece.material, mesh)))
            start += piece.faces
        return found
    found = [Surface(f"{name}-glass", glass_solid(item), medium_look(item.glass, item.roughness))]
    for number, liquid in enumerate(item.liquids):
        found.append(Surface(f"{name}-liquid-{number}", liquid_solid(item, number), medium_look(liquid.medium, 0.0)))
    for number, content in enumerate(item.contents):
        solid = content_solid(item, number)
        found.append(Surface(f"{name}-content-{number}", solid, medium_look(content.medium, 0.0)))
    return [surface for surface in found if len(surface.mesh.faces)]


def _names(pairs: Sequence[tuple[int, str]]) -> dict[int, str]:
    """Return names of letters, digits and underscores by id; where two become the same, with their ids."""
    plain = {number: _NOT_IN_NAMES.sub("_", name) for number, name in pairs}
    plain = {number: f"_{name}" if name[:1].isdigit() or not name else name for number, name in plain.items()}
    used = list(plain.values())
    return {number: name if used.count(name) == 1 else f"{name}_{number}" for number, name in plain.items()}
