"""The bodies of a scene: glass vessels with their liquids, other transparent solids, and opaque props."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field

from ...core.errors import InputError
from ...core.mesh import Mesh, joined, turned
from ...core.model import Matrix4, MeshField, Model, Profile, Vector3
from ..optics.medium import AIR, Medium
from .material import OpaqueMaterial

#: Instance ids: 0 is nothing, 1 the table, objects from 2 (a vessel and its liquid are one instance).
TABLE_ID, FIRST_OBJECT_ID = 1, 2
PART_OF = "Name of the vessel that it goes with and moves with: of caps, labels, stands"


class Interface(Model):
    """A surface between two media. Its normals point from `back` to `front`."""

    part: Literal["outside", "wet_wall", "liquid_surface"] = Field(
        description="air|glass, glass|liquid, liquid|air: the two media that it separates"
    )
    mesh: MeshField
    front: Medium = Field(description="The medium that the normals point into")
    back: Medium = Field(description="The medium behind")
    roughness: float = Field(default=0.0, ge=0.0, le=1.0, description="GGX alpha; 0 is smooth")


class Liquid(Model):
    """What a vessel holds."""

    medium: Medium
    level: float = Field(description="Height at which it would stand with a flat surface, object frame [m]")
    centre: float = Field(description="Height of the surface on the vessel's axis, object frame [m]")
    contact: float = Field(description="Height of the line where the surface meets the wall, object frame [m]")
    contact_angle: float = Field(description="Angle inside the liquid between wall and surface at that line [rad]")
    fill: float = Field(gt=0.0, le=1.0, description="Fraction of the vessel's brimful volume")
    volume: float = Field(gt=0.0, description="Volume [m^3]")


class Origin(Model):
    """Where a mesh comes from."""

    file: str = Field(description="The mesh file, below the folder that the user gave")
    layout: str = Field(description="How the folder is laid out, such as shapenet, gso, ycb, bop or plain")
    licence: str = Field(default="unknown", description="Licence, if the file or its folder says so")
    metres_per_unit: float = Field(gt=0.0, description="Length of the file's unit here [m]")
    centre: Vector3 = Field(description="The object frame's origin, in the file's axes and unit")
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = Field(
        default="z", description="The file's axis that is z here; y and -z are turned about x, x about y"
    )


class GlassBody(Model):
    """A transparent solid, with or without a liquid in it; the frame's origin is the centre of its bounding box."""

    id: int = Field(ge=FIRST_OBJECT_ID, description="Instance id")
    name: str = Field(description="Unique in the scene")
    category: str = Field(description="Such as 'tumbler', 'bottle', 'prism'")
    part_of: str | None = Field(default=None, exclude_if=lambda name: name is None, description=PART_OF)
    glass: Medium = Field(description="The medium that the body is made of")
    roughness: float = Field(ge=0.0, le=1.0, description="GGX alpha of the glass; 0 is smooth")
    liquid: Liquid | None = None
    interfaces: tuple[Interface, ...] = Field(
        description="The surfaces that light meets, each once; normals of outside and wet_wall point out of the glass, "
        "those of liquid_surface into the air"
    )
    size: Vector3 = Field(description="Extent of the bounding box in the object frame [m]")
    symmetric: bool = Field(default=False, description="Whether it is a solid of revolution about its z axis")
    origin: Origin | None = Field(
        default=None, exclude_if=lambda origin: origin is None, description="Of a mesh from a file"
    )
    symmetries: tuple[Matrix4, ...] = Field(
        default=(),
        exclude_if=lambda symmetries: not symmetries,
        description="Motions that leave it unchanged but for small irregularities, without the identity [m]; where there "
        "are none they are found from the shape",
    )
    world_T_object: Matrix4

    def __repr__(self) -> str:
        """Return one line: id, name, media and size."""
        media = self.glass.name + (f" with {self.liquid.medium.name}" if self.liquid else "")
        return f"{type(self).__name__}({self.id} {self.name!r}: {self.category} of {media}, {_millimetres(self.size)})"

    __str__ = __repr__

    def with_media(
        self, glass: Medium | None = None, liquid: Medium | None = None, roughness: float | None = None
    ) -> Self:
        """Return a copy with another glass, liquid or roughness (GGX alpha) in all its fields; shapes stay the same.

        Also the liquid's surface keeps its shape, whatever the capillary constants of the new liquid.
        """
        glass = glass or self.glass
        roughness = self.roughness if roughness is None else roughness
        content = self.liquid
        if liquid is not None:
            if content is None:
                raise InputError(f"{self.name}, liquid", "a body that holds one", "an empty one")
            content = content.model_copy(update={"medium": liquid})
        media = {"outside": (AIR, glass, roughness)}
        if content is not None:
            media |= {
                "wet_wall": (content.medium, glass, roughness),
                "liquid_surface": (AIR, content.medium, 0.0),
            }
        fields = ("front", "back", "roughness")
        interfaces = tuple(
            part.model_copy(update=dict(zip(fields, media[part.part], strict=True))) for part in self.interfaces
        )
        changes = {"glass": glass, "liquid": content, "roughness": roughness, "interfaces": interfaces}
        return self.model_copy(update=changes)


class Vessel(GlassBody):
    """A glass solid of revolution about its z axis, which its wall's profile describes."""

    wall: float = Field(gt=0.0, description="Smallest thickness of the glass, across the wall [m]")
    outer: Profile = Field(description="Outside, from the axis at the base up to the rim's crown [m]")
    inner: Profile = Field(description="Inside, from the axis at the floor up to the rim's crown [m]")
    # Every vessel is one, so scene files do not say it.
    symmetric: bool = Field(default=True, exclude=True)


class Cavity(Model):
    """A place where a solid holds liquid as it stands."""

    floor: float = Field(description="Height of its lowest point, object frame [m]")
    brim: float = Field(description="Height at which liquid would flow out, object frame [m]")
    volume: float = Field(gt=0.0, description="Volume up to the brim [m^3]")


class MeshVessel(GlassBody):
    """A glass solid of any shape, such as one from a file, with the cavities that it has as it stands."""

    solid: MeshField = Field(description="The closed surface of the glass, whatever is in it")
    wall: float | None = Field(gt=0.0, description="Smallest thickness of the wall around the cavities [m]")
    cavities: tuple[Cavity, ...] = Field(description="Where it holds liquid, the largest first; none in solid glass")


class PropPart(Model):
    """Faces of a prop's mesh that have a material of their own."""

    faces: int = Field(ge=0, description="Number of faces; the parts follow each other in the list of the mesh's faces")
    material: OpaqueMaterial
    name: str = Field(default="", exclude_if=lambda name: not name, description="What part it is, such as 'handle'")


class Prop(Model):
    """An opaque object; the frame's origin is the centre of its bounding box."""

    id: int = Field(ge=FIRST_OBJECT_ID, description="Instance id")
    name: str = Field(description="Unique in the scene")
    category: str = Field(description="Shape, or the file that the mesh came from")
    part_of: str | None = Field(default=None, exclude_if=lambda name: name is None, description=PART_OF)
    mesh: MeshField
    material: OpaqueMaterial = Field(description="Of the whole mesh; of its part with most area where it has parts")
    # Left out of files where there are none: scenes of one material stay what they were.
    parts: tuple[PropPart, ...] = Field(
        default=(), exclude_if=lambda parts: not parts, description="Parts with materials of their own, or none"
    )
    origin: Origin | None = Field(
        default=None, exclude_if=lambda origin: origin is None, description="Of a mesh from a file"
    )
    size: Vector3 = Field(description="Extent of the bounding box in the object frame [m]")
    symmetric: bool = Field(default=False, description="Whether it is a solid of revolution about its z axis")
    symmetries: tuple[Matrix4, ...] = Field(
        default=(),
        exclude_if=lambda symmetries: not symmetries,
        description="Motions that leave it unchanged, as the mesh's collection states them, without the identity [m]; "
        "where there are none they are found from the shape",
    )
    world_T_object: Matrix4

    @property
    def pieces(self) -> tuple[PropPart, ...]:
        """The parts; where there are none, one of all faces."""
        return self.parts or (PropPart(faces=len(self.mesh.faces), material=self.material),)

    def __repr__(self) -> str:
        """Return one line: id, name, material and size."""
        what = f"{self.category} of {self.material.name}"
        return f"Prop({self.id} {self.name!r}: {what}, {_millimetres(self.size)})"

    __str__ = __repr__


def _millimetres(size: Vector3) -> str:
    """Return an extent as text, such as ``80x80x120 mm``."""
    return "x".join(f"{1e3 * side:.0f}" for side in size) + " mm"


#: Everything with an instance id of its own.
SceneObject = GlassBody | Prop


def glass_solid(body: GlassBody) -> Mesh:
    """Return the closed surface of the glass alone, object frame, normals out of the glass."""
    parts = {interface.part: interface.mesh for interface in body.interfaces}
    return joined([mesh for part, mesh in parts.items() if part != "liquid_surface"], f"{body.name}-glass")


def liquid_solid(body: GlassBody) -> Mesh:
    """Return the closed surface of the liquid's body, object frame, normals out of the liquid.

    Raises
    ------
    ValueError
        Where the body holds no liquid.
    """
    parts = {interface.part: interface.mesh for interface in body.interfaces}
    if "wet_wall" not in parts:
        raise ValueError(f"{body.name}: expected a liquid in it, found none")
    return joined([turned(parts["wet_wall"]), parts["liquid_surface"]], f"{body.name}-liquid")
