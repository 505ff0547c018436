"""What the objects of a scene are to mechanics: mass, centre of gravity, inertia, friction."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from pydantic import Field

from ...core.mesh import Mesh
from ...core.model import Model
from ..description.bodies import GlassBody, Prop, SceneObject, content_solid, glass_solid, liquid_solid
from ..description.material import OpaqueMaterial
from ..optics.medium import AIR, Medium
from .mass import MassProperties, combined, moved_mass, shell_mass, solid_mass
from .substances import (
    GLASS_DENSITY,
    LIQUID_DENSITY,
    WHOLE_DENSITIES,
    Substance,
    glass_substance,
    substance_of,
)

#: A surface whose volume is less than this part of its hull's is open, or a sheet: it gets a wall [1].
_LEAST_VOLUME = 1e-3


class Mechanics(Model):
    """Mechanical properties of an object as it is in the scene."""

    whole: MassProperties = Field(description="With its liquids, and the beads and ice in it")
    empty: MassProperties | None = Field(
        default=None,
        exclude_if=lambda empty: empty is None,
        description="Of a vessel with something in it, the vessel alone",
    )
    density: float = Field(gt=0.0, description="Of what the body is made of, or of the whole where it is full [kg/m^3]")
    wall: float | None = Field(default=None, description="Wall of a hollow body [m]; null where it is solid")
    friction: float = Field(ge=0.0, description="Coefficient of static friction [1]; a pair has the larger of both")
    source: str = Field(description="Where density and friction come from")


def mechanics_of(item: SceneObject, others: Iterable[tuple[Mesh, Medium]] = ()) -> Mechanics:
    """Return the mechanical properties of an object, with what it holds: liquids, beads, ice.

    Glass has the volume of its mesh, and so have the walls of cups and other open shapes. Closed props of plastic,
    ceramic, metal, terracotta and cardboard are hollow; those of wood, stone, rubber, cloth and paper are solid. Tins
    and cartons are full, and books are paper. A thing of closed parts has the mass of each; density and friction are
    those of its first.

    Parameters
    ----------
    item : Prop or GlassBody
        The object.
    others : iterable of (Mesh, Medium)
        Surfaces of objects that stand in its liquids (`standing.standing_in`): they take the place of some. Without
        them the mass of a liquid in which a straw or a rod stands is up to 1 % off.
    """
    if isinstance(item, GlassBody):
        return _of_glass(item, list(others))
    substance = substance_of(item.material)
    if item.category in WHOLE_DENSITIES:
        density, source = WHOLE_DENSITIES[item.category]
        whole = Substance(density, substance.friction, None, f"{source}; friction: {substance.source}")
        return _record(solid_mass(item.mesh, density), whole)
    parts = [_only(item, part) for part in _parts_of(item)]
    if len(parts) > 1 and all(_encloses(part.mesh) for part in parts):
        first, *rest = [_of_prop(part, substance_of(part.material)) for part in parts]
        return first.model_copy(update={"whole": combined([part.whole for part in (first, *rest)])})
    return _of_prop(item, substance)


def _parts_of(item: Prop) -> list[tuple[OpaqueMaterial, np.ndarray]]:
    """Return the materials of a prop, each with its faces."""
    faces = np.split(item.mesh.faces, np.cumsum([piece.faces for piece in item.pieces])[:-1])
    return [(piece.material, some) for piece, some in zip(item.pieces, faces, strict=True)]


def _only(item: Prop, part: tuple[OpaqueMaterial, np.ndarray]) -> Prop:
    return item.model_copy(update={"mesh": replace(item.mesh, faces=part[1]), "material": part[0], "parts": ()})


def with_attached(mechanics: Mechanics, attached: Sequence[SceneObject]) -> Mechanics:
    """Return the mechanical properties of a body together with its parts, whose poses are in its frame."""
    if not attached:
        return mechanics
    others = [moved_mass(mechanics_of(part).whole, part.world_T_object) for part in attached]
    return mechanics.model_copy(update={"whole": combined([mechanics.whole, *others])})


def _of_glass(item: GlassBody, others: Sequence[tuple[Mesh, Medium]]) -> Mechanics:
    substance = glass_substance(item.glass)
    glass = solid_mass(glass_solid(item), substance.density)
    held = [
        solid_mass(liquid_solid(item, number, others), liquid.medium.density or LIQUID_DENSITY)
        for number, liquid in enumerate(item.liquids)
    ]
    held += [
        solid_mass(content_solid(item, number), content.medium.density or GLASS_DENSITY)
        for number, content in enumerate(item.contents)
        if content.medium != AIR
    ]
    return _record(combined([glass, *held]), substance, glass) if held else _record(glass, substance)


def _of_prop(item: Prop, substance: Substance) -> Mechanics:
    hollow = substance.wall is not None or not _encloses(item.mesh)
    if not hollow:
        return _record(solid_mass(item.mesh, substance.density), substance)
    wall = substance.wall or _SHEET
    shell = shell_mass(item.mesh, substance.density, wall)
    if _encloses(item.mesh):
        solid = solid_mass(item.mesh, substance.density)
        if solid.mass <= shell.mass:  # the mesh itself is a wall, as that of a cup
            return _record(solid, substance)
    return _record(shell, Substance(substance.density, substance.friction, wall, substance.source))


#: Wall of open surfaces of solid materials [m]: boards and thick paper; a file's surface has none of its own.
_SHEET = 3e-3


def _encloses(mesh: Mesh) -> bool:
    """Return whether a surface encloses a volume that can be trusted: closed, or at least most of its hull's."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces] - mesh.bounds.mean(0)
    volume = float(np.linalg.det(corners).sum()) / 6.0
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2.0
    # Open surfaces have boundaries: the vector areas of their triangles do not cancel.
    vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(0) / 2.0
    return volume > _LEAST_VOLUME * area**1.5 and float(np.linalg.norm(vector)) < 1e-3 * area


def _record(whole: MassProperties, substance: Substance, empty: MassProperties | None = None) -> Mechanics:
    return Mechanics(
        whole=whole,
        empty=empty,
        density=substance.density,
        wall=substance.wall if empty is None else None,
        friction=substance.friction,
        source=substance.source,
    )
