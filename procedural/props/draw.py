"""Opaque props, drawn at random: a procedural shape, or a mesh from the user's folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydantic import Field, model_validator

from ...core.mesh import Mesh
from ...core.model import Model
from ...core.units import Length
from ..description.material import OpaqueMaterial
from ..description.scene import Prop
from ..materials.draw import draw_material, draw_plain_material
from .mesh_files import MeshFile, box_mapped, read_mesh
from .shapes import draw_shape


class PropSettings(Model):
    """How opaque props are drawn."""

    smallest: Length = Field(default=0.05, ge=0.03, le=0.3, description="Least longest side of a drawn shape [m]")
    largest: Length = Field(default=0.16, ge=0.03, le=0.3, description="Greatest longest side of a drawn shape [m]")
    file_share: float = Field(
        default=0.6, ge=0.0, le=1.0, description="Probability that a prop comes from the mesh folder, if one is given"
    )

    @model_validator(mode="after")
    def _in_order(self) -> PropSettings:
        if self.smallest > self.largest:
            raise ValueError(f"smallest: expected at most largest ({self.largest} m), found {self.smallest} m")
        return self


def draw_prop(
    rng: np.random.Generator,
    settings: PropSettings,
    *,
    id: int,
    name: str,
    mesh_files: Sequence[MeshFile] = (),
    texture_files: Sequence[Path] = (),
) -> Prop:
    """Draw a prop at the world's origin; placement sets its pose.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    settings : PropSettings
        Range of sizes, and the probability of a mesh file.
    id : int
        Instance id.
    name : str
        Name of the prop and of its mesh, unique in the scene.
    mesh_files : sequence of MeshFile
        Result of `mesh_files.mesh_files`; may be empty.
    texture_files : sequence of Path
        Result of `picture_files.picture_files`; may be empty.

    Raises
    ------
    InputError
        If the drawn file is unusable.
    """
    longest = rng.uniform(settings.smallest, settings.largest)
    from_file = rng.random() < settings.file_share
    if mesh_files and from_file:
        file = mesh_files[int(rng.integers(len(mesh_files)))]
        mesh, material = _prop_from_file(rng, file, name, longest, texture_files)
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


def _prop_from_file(
    rng: np.random.Generator, file: MeshFile, name: str, longest: float, texture_files: Sequence[Path]
) -> tuple[Mesh, OpaqueMaterial]:
    found = read_mesh(file, name, longest)
    mesh, stored = found.mesh, found.material
    if mesh.uv is None:
        mesh = box_mapped(mesh)
        material = _whole_repeats(draw_material(rng, texture_files), float(np.ptp(mesh.bounds, axis=0).max()))
    else:
        # A procedural pattern would not fit the charts of the file.
        material = draw_plain_material(rng)
    fields = {"base_colour": stored.texture, "roughness": stored.roughness, "metallic": stored.metallic}
    fields = {field: value for field, value in fields.items() if value is not None}
    if stored.texture is not None:
        fields |= {"name": f"of {file.name}", "repeats": 1.0, "metallic": stored.metallic or 0.0}
    return mesh, material.model_copy(update=fields)


def _whole_repeats(material: OpaqueMaterial, unit: float) -> OpaqueMaterial:
    """Return a material with its repeats per metre rounded to a whole number per texture unit of `unit` metres."""
    return material.model_copy(update={"repeats": float(max(1, round(material.repeats * unit)))})
