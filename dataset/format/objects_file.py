"""``objects.json``: the properties of each object that all views of a scene share."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ...annotate.keypoints import SceneKeypoints
from ...annotate.outlines import fill_lines, openings
from ...annotate.symmetries import symmetry_of
from ...core.mesh import volume_of
from ...core.model import Matrix4, Model, Vector3
from ...procedural.description.material import OpaqueMaterial
from ...procedural.description.material_list import materials_of
from ...procedural.description.rest import Rest, touched
from ...procedural.description.scene import (
    Content,
    Liquid,
    MeshVessel,
    Origin,
    Prop,
    Scene,
    SceneObject,
    Vessel,
    glass_solid,
)
from ...procedural.description.standing import wetted_surfaces
from ...procedural.optics.medium import Medium
from ...procedural.physics.bodies import Mechanics, mechanics_of
from ...procedural.profiles.liquid import brimful_volume

OBJECTS_SCHEMA = "glassware/objects/1"


class GlassMaterial(Model):
    """A transparent solid."""

    kind: Literal["glass"] = "glass"
    medium: Medium = Field(description="Optical constants")
    roughness: float = Field(description="GGX alpha; 0 is smooth")


class OpaqueSurface(Model):
    """An opaque surface; its texture is in ``scene.json``."""

    kind: Literal["opaque"] = "opaque"
    name: str
    roughness: float = Field(description="Principled roughness")
    metallic: float = Field(description="0 dielectric, 1 metal")


class MediumRecord(Model):
    """A transparent medium."""

    kind: Literal["medium"] = "medium"
    medium: Medium = Field(description="Optical constants")


class ContinuousSymmetry(Model):
    """A symmetry under every rotation about an axis, as in BOP's ``symmetries_continuous``."""

    axis: Vector3 = Field(description="Direction in the object frame")
    offset: Vector3 = Field(description="A point on the axis, object frame [m]")


class Part(Model):
    """A part of an instance: a vessel, its liquids and the bodies in it share one instance id."""

    id: int = Field(ge=1, description="Number within the instance: 1 the body, 2 its liquid, then layers and contents")
    name: Literal["glass", "liquid", "body", "layer", "ice cube", "beads", "bubbles"]


class Volumes(Model):
    """What a glass body and its inside take."""

    glass: float = Field(gt=0.0, description="Volume of the glass, by its mesh [m^3]")
    brimful: float | None = Field(gt=0.0, description="Volume of the inside up to the brim [m^3]; null without one")
    liquid: float = Field(ge=0.0, description="Volume of all liquids in it [m^3]")


class ObjectRecord(Model):
    """One object."""

    id: int = Field(description="Instance id, as in instances.png")
    name: str
    category: str
    part_of: str | None = Field(
        default=None, exclude_if=lambda name: name is None, description="Name of the vessel that it goes with"
    )
    parts: tuple[Part, ...]
    material: Annotated[GlassMaterial | OpaqueSurface, Field(discriminator="kind")] = Field(
        description="Of a prop of several materials, that of most of its area; the others are in `scene.json`"
    )
    origin: Origin | None = Field(
        default=None, exclude_if=lambda origin: origin is None, description="Of a mesh from a user's folder"
    )
    liquid: Liquid | None = Field(description="The liquid on a vessel's floor")
    layers: tuple[Liquid, ...] = Field(
        default=(), exclude_if=lambda layers: not layers, description="Liquids that float on it, upwards"
    )
    contents: tuple[Content, ...] = Field(
        default=(), exclude_if=lambda contents: not contents, description="Ice, beads and bubbles in a vessel"
    )
    within: str | None = Field(
        default=None, exclude_if=lambda name: name is None, description="Name of the vessel that it leans in"
    )
    world_T_object: Matrix4
    size: Vector3 = Field(description="Extent of the bounding box, whose centre is the frame's origin [m]")
    symmetries_continuous: tuple[ContinuousSymmetry, ...] = Field(
        description="A ball has two: z and x generate all rotations"
    )
    symmetries_discrete: tuple[Matrix4, ...] = Field(
        default=(), description="Other motions that leave the shape unchanged, without the identity, object frame [m]"
    )
    keypoints: tuple[Vector3, ...] = Field(description="Farthest-point keypoints, object frame [m]")
    openings: tuple[tuple[Vector3, ...], ...] = Field(
        default=(), description="Mouths of a vessel, closed polygons of at most 64 points, object frame [m]"
    )
    fill_lines: tuple[tuple[Vector3, ...], ...] = Field(
        default=(), description="Where its liquid meets the wall, closed lines of at most 64 points, object frame [m]"
    )
    volumes: Volumes | None = Field(default=None, description="Of a vessel or another glass body; null for props")
    mechanics: Mechanics | None = Field(
        default=None, description="Mass, centre of gravity, inertia and friction; null in data sets of earlier versions"
    )
    touches: tuple[int, ...] | None = Field(
        default=None,
        description="Ids of what it touches where its scene has a pile, 1 is the table; null where objects stand apart",
    )


class ObjectsFile(Model):
    """All objects of a scene, by ascending id."""

    schema_version: Literal["glassware/objects/1"] = OBJECTS_SCHEMA
    objects: tuple[ObjectRecord, ...]
    materials: tuple[Annotated[MediumRecord | OpaqueSurface, Field(discriminator="kind")], ...] = Field(
        default=(),
        description="Indexed by `material` of layers.exr: air, then the materials of table and objects",
    )


def objects_file(scene: Scene, points: SceneKeypoints) -> ObjectsFile:
    """Return the records of a scene's objects, with the keypoints of its labels."""
    rows = zip(scene.objects, points.local, strict=True)
    return ObjectsFile(
        objects=tuple(_record(item, local, scene) for item, local in rows),
        materials=tuple(_material_record(material) for material in materials_of(scene)),
    )


def _material_record(material: Medium | OpaqueMaterial) -> MediumRecord | OpaqueSurface:
    return MediumRecord(medium=material) if isinstance(material, Medium) else _opaque(material)


def _record(item: SceneObject, local: np.ndarray, scene: Scene) -> ObjectRecord:
    symmetry = symmetry_of(item)
    axes = ((0.0, 0.0, 1.0),) * symmetry.turns + ((1.0, 0.0, 0.0),) * symmetry.ball
    return ObjectRecord(
        id=item.id,
        name=item.name,
        category=item.category,
        part_of=item.part_of,
        parts=_parts(item),
        material=_material(item),
        origin=item.origin,
        liquid=None if isinstance(item, Prop) else item.liquid,
        layers=() if isinstance(item, Prop) else item.layers,
        contents=() if isinstance(item, Prop) else item.contents,
        within=item.within,
        world_T_object=item.world_T_object,
        size=item.size,
        symmetries_continuous=tuple(ContinuousSymmetry(axis=axis, offset=(0.0, 0.0, 0.0)) for axis in axes),
        symmetries_discrete=tuple(symmetry.motions[1:]),
        keypoints=tuple(tuple(point) for point in local.tolist()),
        openings=_lines(openings(item)),
        fill_lines=_lines(fill_lines(item)),
        volumes=_volumes(item),
        mechanics=mechanics_of(item, wetted_surfaces(scene.objects, item)),
        touches=_touched(item, scene.rest),
    )


def _touched(item: SceneObject, rest: Rest | None) -> tuple[int, ...] | None:
    return None if rest is None or rest.given_up else touched(rest, item.id)


def _lines(lines: tuple[np.ndarray, ...]) -> tuple[tuple[Vector3, ...], ...]:
    return tuple(tuple((x, y, z) for x, y, z in line.tolist()) for line in lines)


def _volumes(item: SceneObject) -> Volumes | None:
    if isinstance(item, Prop):
        return None
    brimful = None
    if isinstance(item, Vessel):
        brimful = brimful_volume(np.array(item.inner))
    elif isinstance(item, MeshVessel) and item.cavities:
        brimful = sum(cavity.volume for cavity in item.cavities)
    liquid = sum(one.volume for one in item.liquids)
    return Volumes(glass=volume_of(glass_solid(item)), brimful=brimful, liquid=liquid)


def _parts(item: SceneObject) -> tuple[Part, ...]:
    if isinstance(item, Prop):
        return (Part(id=1, name="body"),)
    names = ["glass", *(["liquid"] if item.liquid else []), *("layer" for _ in item.layers)]
    names += [content.kind for content in item.contents]
    return tuple(Part.model_validate({"id": number, "name": name}) for number, name in enumerate(names, start=1))


def _material(item: SceneObject) -> GlassMaterial | OpaqueSurface:
    if not isinstance(item, Prop):
        return GlassMaterial(medium=item.glass, roughness=item.roughness)
    return _opaque(item.material)


def _opaque(surface: OpaqueMaterial) -> OpaqueSurface:
    return OpaqueSurface(name=surface.name, roughness=surface.roughness, metallic=surface.metallic)
