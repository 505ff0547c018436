"""A prop from a mesh file: its pieces with the materials that the file states, and drawn ones where it states none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...core.mesh import Mesh
from ..description.material import Emission, OpaqueMaterial
from ..description.scene import GlassBody, Interface, Origin, Prop, PropPart
from ..materials.draw import draw_material, draw_plain_material, whole_repeats
from ..materials.surface_files import SurfaceFiles
from ..mesh_files.model import GlassLook, Glow, Look
from ..optics.medium import AIR
from .glass import medium_of, roughness_of
from .mesh_files import Z_UP, FileMesh, MeshFile, box_mapped, read_mesh

#: Radiance of what a file calls an emission of 1 [kcd/m^2]: white on the reference display of IEC 61966-2-1 (sRGB),
#: 80 cd/m^2, as files are made to look right on a screen. (The unit of glTF 2.0, section 3.9.3, is 1 cd/m^2, by which
#: nothing that people export would shine in a lit room.)
SCREEN_WHITE = 0.08


def prop_from_file(
    rng: np.random.Generator,
    file: MeshFile,
    longest: float,
    *,
    id: int,
    name: str,
    texture_files: Sequence[SurfaceFiles] = (),
) -> Prop | GlassBody:
    """Return a prop of a mesh file at the world's origin.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws what the file does not state.
    file : MeshFile
        The file.
    longest : float
        Longest side of a file without a size of its own [m].
    id, name : int, str
        Of the prop; the name is also that of its mesh.
    texture_files : sequence of SurfaceFiles
        Pictures for files without any material; may be empty.

    Raises
    ------
    InputError
        Where the file is unusable.
    """
    found = read_mesh(file, name, longest)
    if found.glass is not None:
        return _glass_body(file, found, found.glass, id, name)
    mesh = found.mesh
    if all(piece.look.is_bare for piece in found.pieces):
        mesh, whole = _of_drawn_material(rng, mesh, texture_files)
        materials = [_with_look(whole, piece.look) for piece in found.pieces[:1]]
        counts = [len(mesh.faces)]
    else:
        plain = draw_plain_material(rng)
        materials = [_material(file, piece.look, plain) for piece in found.pieces]
        counts = [piece.faces for piece in found.pieces]
    largest = int(np.argmax([piece.area for piece in found.pieces])) if len(materials) > 1 else 0
    parts = tuple(PropPart(faces=count, material=one) for count, one in zip(counts, materials, strict=True))
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return Prop(
        id=id,
        name=name,
        category=file.category,
        mesh=mesh,
        material=materials[largest],
        parts=parts if len(parts) > 1 else (),
        origin=origin_of(file, found),
        size=(x, y, z),
        symmetric=_turns(file, found),
        symmetries=_motions(file, found),
        world_T_object=np.eye(4),
    )


def origin_of(file: MeshFile, found: FileMesh) -> Origin:
    """Return where a mesh comes from, and how its frame lies in the file's."""
    place = file.place
    return Origin(
        file=file.name,
        layout=place.layout,
        licence=place.licence,
        metres_per_unit=found.metres_per_unit,
        centre=found.centre,
        up=place.up,
    )


def _of_drawn_material(
    rng: np.random.Generator, mesh: Mesh, texture_files: Sequence[SurfaceFiles]
) -> tuple[Mesh, OpaqueMaterial]:
    if mesh.uv is None:
        mesh = box_mapped(mesh)
        return mesh, whole_repeats(draw_material(rng, texture_files), float(np.ptp(mesh.bounds, axis=0).max()))
    # A procedural pattern would not fit the charts of the file.
    return mesh, draw_plain_material(rng)


def _material(file: MeshFile, look: Look, plain: OpaqueMaterial) -> OpaqueMaterial:
    """Return a look as a material; what it does not state is the drawn one's."""
    if look.texture is None:
        return _with_look(plain, look)
    return OpaqueMaterial.model_validate(
        {
            "name": look.name or f"of {Path(file.name).name}",
            "base_colour": look.texture,
            "roughness": plain.roughness if look.roughness is None else look.roughness,
            "metallic": look.metallic or 0.0,
            "emission": _emission(look.glow),
            **look.maps,
        }
    )


def _with_look(material: OpaqueMaterial, look: Look) -> OpaqueMaterial:
    fields = {"roughness": look.roughness, "metallic": look.metallic, "emission": _emission(look.glow)}
    return material.model_copy(update={name: value for name, value in fields.items() if value is not None})


def _emission(glow: Glow | None) -> Emission | None:
    return None if glow is None else Emission(colour=glow.texture, radiance=min(SCREEN_WHITE * glow.strength, 1e6))


def _motions(file: MeshFile, found: FileMesh) -> tuple[np.ndarray, ...]:
    """Return the symmetries that a file's layout states, in the object frame [m]."""
    object_T_file = np.eye(4)
    object_T_file[:3, :3] *= found.metres_per_unit
    object_T_file[:3, 3] = -found.metres_per_unit * np.array(found.centre)
    if file.place.up == "y":
        object_T_file = Z_UP @ object_T_file
    back = np.linalg.inv(object_T_file)
    return tuple(object_T_file @ np.reshape(values, (4, 4)) @ back for values in file.place.symmetries)


def _turns(file: MeshFile, found: FileMesh) -> bool:
    """Return whether the file's layout states a solid of revolution, about an axis through the middle of its box."""
    x, y, _ = found.centre
    return file.place.turns and math.hypot(x, y) <= _AXIS_TOLERANCE * found.longest


#: Distance of a stated axis of revolution from the middle of the bounding box, over the longest side [1]: scanned
#: objects are this round.
_AXIS_TOLERANCE = 0.02


def _glass_body(file: MeshFile, found: FileMesh, look: GlassLook, id: int, name: str) -> GlassBody:
    mesh = Mesh(name, found.mesh.vertices, found.mesh.faces, found.mesh.normals)
    medium = medium_of(look, found.metres_per_unit, f"glass of {Path(file.name).name}")
    alpha = roughness_of(found.pieces[0].look)
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return GlassBody(
        id=id,
        name=name,
        category=file.category,
        glass=medium,
        roughness=alpha,
        interfaces=(Interface(part="outside", mesh=mesh, front=AIR, back=medium, roughness=alpha),),
        size=(x, y, z),
        symmetric=_turns(file, found),
        origin=origin_of(file, found),
        world_T_object=np.eye(4),
    )
