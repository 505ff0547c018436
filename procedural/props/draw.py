"""An opaque prop, drawn at random: a made shape, or a mesh from the user's folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...core.mesh import Mesh
from ..description.material import OpaqueMaterial
from ..description.scene import Prop
from ..materials.draw import draw_material, draw_plain_material
from .mesh_files import MeshFile, box_mapped, read_mesh
from .settings import PropSettings
from .shapes import draw_shape


def draw_prop(
    rng: np.random.Generator,
    settings: PropSettings,
    *,
    id: int,
    name: str,
    mesh_files: Sequence[MeshFile] = (),
    texture_files: Sequence[Path] = (),
) -> Prop:
    """Draw a prop at the world's origin; placement gives it its pose.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    settings : PropSettings
        Sizes and shares.
    id : int
        Instance id.
    name : str
        Name of the prop and of its mesh, unique in the scene.
    mesh_files : sequence of MeshFile
        What `mesh_files.mesh_files` found; may be empty.
    texture_files : sequence of Path
        What `picture_files.picture_files` found; may be empty.

    Raises
    ------
    InputError
        Where the drawn file is unusable.
    """
    longest = rng.uniform(settings.smallest, settings.largest)
    from_file = rng.random() < settings.file_share
    if mesh_files and from_file:
        file = mesh_files[int(rng.integers(len(mesh_files)))]
        mesh, material = _from_file(rng, file, name, longest, texture_files)
        category, symmetric = file.name, False
    else:
        shape = draw_shape(rng, longest, name)
        mesh, category, symmetric = shape.mesh, shape.category, shape.symmetric
        material = _whole_repeats(draw_material(rng, texture_files), shape.texture_unit)
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return Prop(
        id=id,
        name=name,
        category=category,
        mesh=mesh,
        material=material,
        size=(x, y, z),
        symmetric=symmetric,
        world_T_object=np.eye(4),
    )


def _from_file(
    rng: np.random.Generator, file: MeshFile, name: str, longest: float, texture_files: Sequence[Path]
) -> tuple[Mesh, OpaqueMaterial]:
    found = read_mesh(file, name, longest)
    mesh, look = found.mesh, found.look
    if mesh.uv is None:
        mesh = box_mapped(mesh)
        material = _whole_repeats(draw_material(rng, texture_files), float(np.ptp(mesh.bounds, axis=0).max()))
    else:
        # The file's own charts: no pattern of ours would fit them.
        material = draw_plain_material(rng)
    said = {"base_colour": look.texture, "roughness": look.roughness, "metallic": look.metallic}
    said = {field: value for field, value in said.items() if value is not None}
    if look.texture is not None:
        said |= {"name": f"of {file.name}", "repeats": 1.0, "metallic": look.metallic or 0.0}
    return mesh, material.model_copy(update=said)


def _whole_repeats(material: OpaqueMaterial, unit: float) -> OpaqueMaterial:
    """Return a material whose repeats per metre became a whole number per texture unit of `unit` metres."""
    return material.model_copy(update={"repeats": float(max(1, round(material.repeats * unit)))})
