"""Opaque props, drawn at random: a procedural shape, or a mesh from the user's folder."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from ...core.model import Model, Ordered, Unit
from ...core.units import Length
from ...core.weighted import Weighted, check_names, weights_of
from ..description.scene import GlassBody, Prop
from ..materials.draw import draw_material, whole_repeats
from ..materials.surface_files import SurfaceFiles
from .from_file import prop_from_file
from .kinds import DEFAULT_KINDS, PROP_KINDS
from .mesh_files import MeshChoice, MeshFile
from .shapes import draw_shape


class PropSettings(Model):
    """How opaque props are drawn."""

    kinds: Weighted = Field(
        default=DEFAULT_KINDS,
        min_length=1,
        description="Kinds to draw from where no mesh file is drawn, equally likely or by weights (book=2); all but "
        "`shape` have the sizes of real ones",
        json_schema_extra={"range": f"one or more of {', '.join(PROP_KINDS)}"},
    )
    wear: Annotated[tuple[Unit, Unit], Ordered] = Field(
        default=(0.1, 0.9), description="Traces of use of all kinds but `shape`: 0 new, 1 worn, within 0 and 1"
    )
    smallest: Length = Field(default=0.05, ge=0.03, le=0.3, description="Least longest side of a drawn shape [m]")
    largest: Length = Field(default=0.16, ge=0.03, le=0.3, description="Greatest longest side of a drawn shape [m]")
    file_share: float = Field(
        default=0.6, ge=0.0, le=1.0, description="Probability that a prop comes from the mesh folder, if one is given"
    )

    unit: Literal["auto", "m", "cm", "mm", "inch"] = Field(
        default="auto", description="Unit of the mesh files; auto takes it from their layout, or their size"
    )
    up: Literal["auto", "y", "z"] = Field(
        default="auto", description="Axis of the mesh files that points up; auto takes it from their layout or format"
    )
    include: tuple[str, ...] = Field(
        default=(), description="Patterns such as *mug*: of the mesh files, only those with such a name or category"
    )
    exclude: tuple[str, ...] = Field(default=(), description="Patterns of names or categories that are left out")

    @property
    def choice(self) -> MeshChoice:
        """Which mesh files are used, and what is stated about them."""
        return MeshChoice(self.include, self.exclude, self.unit, self.up)

    @field_validator("kinds")
    @classmethod
    def _known_kinds(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(kinds), PROP_KINDS)
        return kinds

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
    texture_files: Sequence[SurfaceFiles] = (),
    thing: Callable[[], Prop] | None = None,
) -> Prop | GlassBody:
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
        Result of `mesh_files.usable_meshes`; may be empty. One that its file says is glass is a glass body.
    texture_files : sequence of SurfaceFiles
        Result of `surface_files.usable_surfaces`; may be empty.
    thing : callable, optional
        What makes the prop where no file is drawn, instead of a plain shape (`things.draw.draw_prop_of_kind`).

    Raises
    ------
    InputError
        If the drawn file is unusable.
    """
    longest = rng.uniform(settings.smallest, settings.largest)
    from_file = rng.random() < settings.file_share
    if mesh_files and from_file:
        file = mesh_files[int(rng.integers(len(mesh_files)))]
        return prop_from_file(rng, file, drawn_size(file, settings), id=id, name=name, texture_files=texture_files)
    if thing is not None:
        return thing()
    shape = draw_shape(rng, longest, name)
    x, y, z = (float(side) for side in np.ptp(shape.mesh.bounds, axis=0))
    return Prop(
        id=id,
        name=name,
        category=shape.category,
        mesh=shape.mesh,
        material=whole_repeats(draw_material(rng, texture_files), shape.texture_unit),
        size=(x, y, z),
        symmetric=shape.symmetric,
        world_T_object=np.eye(4),
    )


def drawn_size(file: MeshFile, settings: PropSettings) -> float:
    """Return the longest side of a file without a size of its own [m]: the same in all scenes and data sets."""
    fraction = int.from_bytes(hashlib.sha256(file.name.encode()).digest()[:4], "little") / 2**32
    return settings.smallest + fraction * (settings.largest - settings.smallest)
