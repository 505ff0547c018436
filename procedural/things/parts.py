"""Parts of a thing, put together in its object frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from ..description.material import OpaqueMaterial
from ..description.scene import Prop, PropPart


@dataclass(frozen=True, eq=False)
class Part:
    """A closed part, or some faces of a closed surface that several parts make together."""

    name: str  #: such as 'cover'; with its material's name it is what labels say
    mesh: Mesh  #: texture coordinates as its material takes them: in metres, or 0 to 1 over an atlas
    material: OpaqueMaterial


@dataclass(frozen=True, eq=False)
class Thing:
    """A drawn thing, standing as it is used: z up, its lowest point anywhere."""

    parts: tuple[Part, ...]
    symmetric: bool = False  #: whether it is a solid of revolution about z, looks included


def as_prop(thing: Thing, category: str, *, id: int, name: str) -> Prop:
    """Return a thing as a prop at the world's origin, its frame at the centre of its bounding box.

    Parameters
    ----------
    thing : Thing
        The parts.
    category : str
        Its kind.
    id, name : int, str
        Of the prop; the name is also that of its mesh.
    """
    merged = _by_material(thing.parts)
    meshes = [part.mesh for part in merged]
    low, high = np.min([m.bounds[0] for m in meshes], axis=0), np.max([m.bounds[1] for m in meshes], axis=0)
    # Rounded, so that the shift keeps equal positions equal.
    centre = ((low + high) / 2).astype(np.float32)
    mesh = _joined(name, meshes, centre)
    parts = tuple(PropPart(faces=len(part.mesh.faces), material=part.material, name=part.name) for part in merged)
    largest = max(merged, key=lambda part: _area(part.mesh))
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return Prop(
        id=id,
        name=name,
        category=category,
        mesh=mesh,
        material=largest.material,
        parts=parts if len(parts) > 1 else (),
        size=(x, y, z),
        symmetric=thing.symmetric,
        world_T_object=np.eye(4),
    )


def some(mesh: Mesh, chosen: np.ndarray, planar: bool = False) -> Mesh:
    """Return the faces of a mesh where `chosen` (m,) is true; `planar` ones get (x, y) as texture coordinates [m]."""
    used, index = np.unique(mesh.faces[chosen], return_inverse=True)
    assert mesh.normals is not None
    assert mesh.uv is not None
    vertices = mesh.vertices[used]
    uv = vertices[:, :2] if planar else mesh.uv[used]
    return Mesh(mesh.name, vertices, index.reshape(-1, 3), mesh.normals[used], uv)


def _by_material(parts: Sequence[Part]) -> list[Part]:
    """Return parts with those of one material as one, named after all of them: each is a shape of its own to render."""
    found: list[Part] = []
    for part in parts:
        if all(part.material != other.material for other in found):
            same = [other for other in parts if other.material == part.material]
            names = ", ".join(dict.fromkeys(other.name for other in same))
            mesh = _joined("part", [other.mesh for other in same], np.zeros(3, np.float32))
            found.append(Part(names, mesh, part.material))
    return found


def _joined(name: str, meshes: Sequence[Mesh], centre: np.ndarray) -> Mesh:
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        name,
        np.concatenate([mesh.vertices for mesh in meshes]) - centre,
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]),
        np.concatenate([mesh.normals for mesh in meshes if mesh.normals is not None]),
        np.concatenate([mesh.uv for mesh in meshes if mesh.uv is not None]),
    )


def _area(mesh: Mesh) -> float:
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(cross, axis=1).sum())
