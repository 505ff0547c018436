"""Objects of their own that stand in a vessel, such as straws and rods: their surfaces lie in its liquids."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...core.mesh import Mesh, joined, on_border, some_faces
from ..cavities.split import whole
from ..optics.medium import AIR, Medium
from .bodies import GlassBody, Prop, PropPart, SceneObject
from .interfaces import clouded

#: Points on the borders of such an object's pieces that are nearer to one of the vessel's are that one [m]: both lie on
#: the line where it meets a liquid's surface, and each is rounded to single precision in the frame of its own object.
#: (Its other points stay, however near they are: a triangle between one and the line would be lost.)
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Standing:
    """An object in a vessel.

    Parameters
    ----------
    item : Prop or GlassBody
        The object.
    pieces : tuple of (Mesh, Medium)
        Its surface in the vessel's frame, each piece with the medium before it.
    """

    item: SceneObject
    pieces: tuple[tuple[Mesh, Medium], ...]

    @property
    def solid(self) -> Mesh:
        """Its whole surface in the vessel's frame, with normals and texture coordinates."""
        return whole([mesh for mesh, _ in self.pieces], f"{self.item.name}-solid")


def standing_in(objects: Sequence[SceneObject], vessel: GlassBody) -> tuple[Standing, ...]:
    """Return the objects that stand in a vessel, by their ids."""
    inside = [item for item in objects if item.within == vessel.name]
    if not inside:
        return ()
    places = joined([part.mesh for part in vessel.interfaces], "vessel").vertices
    near = cKDTree(places)
    found = []
    for item in sorted(inside, key=lambda one: one.id):
        vessel_T_item = np.linalg.inv(vessel.world_T_object) @ item.world_T_object
        pieces = [(_snapped(_moved(mesh, vessel_T_item), places, near), medium) for mesh, medium in _pieces(item)]
        found.append(Standing(item, tuple(pieces)))
    return tuple(found)


def wetted_surfaces(objects: Sequence[SceneObject], item: SceneObject) -> list[tuple[Mesh, Medium]]:
    """Return the surfaces of the objects that stand in one, in its frame, each with the medium before it."""
    if not isinstance(item, GlassBody):
        return []
    return [piece for other in standing_in(objects, item) for piece in other.pieces]


def restood(item: SceneObject, pieces: Sequence[tuple[Medium, Mesh]], world_T_vessel: np.ndarray) -> SceneObject:
    """Return an object in a vessel with other pieces of its surface, given in the vessel's frame."""
    item_T_vessel = np.linalg.inv(item.world_T_object) @ world_T_vessel
    local = [(medium, _moved(mesh, item_T_vessel)) for medium, mesh in pieces]
    if isinstance(item, Prop):
        name, material = item.mesh.name, item.pieces[0].material
        parts = tuple(
            PropPart(faces=len(mesh.faces), material=material, surrounding=None if medium == AIR else medium)
            for medium, mesh in local
        )
        alone = len(parts) == 1 and parts[0].surrounding is None
        mesh = whole([mesh for _, mesh in local], name)
        return item.model_copy(update={"mesh": mesh, "parts": () if alone else parts})
    outside = item.interfaces[0].model_copy(update={"opaque": None, "seen_from_back": False})
    interfaces = tuple(
        clouded(
            outside.model_copy(
                update={"mesh": replace(mesh, name=f"{item.name}-outside" + (f"-{k}" if k else "")), "front": medium}
            )
        )
        for k, (medium, mesh) in enumerate(local)
    )
    return item.model_copy(update={"interfaces": interfaces})


def _pieces(item: SceneObject) -> list[tuple[Mesh, Medium]]:
    if not isinstance(item, Prop):
        return [(part.mesh, part.front) for part in item.interfaces]
    ends = np.cumsum([0, *(piece.faces for piece in item.pieces)])
    slices = [slice(start, end) for start, end in itertools.pairwise(ends)]
    return [
        (some_faces(item.mesh, faces, item.mesh.name), piece.surrounding or AIR)
        for faces, piece in zip(slices, item.pieces, strict=True)
    ]


def _moved(mesh: Mesh, a_T_mesh: np.ndarray) -> Mesh:
    # Element by element, so that equal points stay equal (see `render.scene.bodies.to_world`).
    x, y, z = mesh.vertices.astype(np.float64).T
    points = np.stack([a * x + b * y + c * z + t for a, b, c, t in a_T_mesh[:3]], axis=1)
    normals = None if mesh.normals is None else mesh.normals @ a_T_mesh[:3, :3].T
    return replace(mesh, vertices=points, normals=normals)


def _snapped(mesh: Mesh, places: np.ndarray, near: cKDTree) -> Mesh:
    distance, index = near.query(mesh.vertices)
    same = ((distance < _SAME) & on_border(mesh))[:, None]
    return replace(mesh, vertices=np.where(same, places[index], mesh.vertices))
