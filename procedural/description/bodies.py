"""The bodies of a scene: glass vessels with their liquids, other transparent solids, and opaque props."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, Self

from pydantic import Field

from ...core.errors import InputError
from ...core.mesh import Mesh, joined, turned
from ...core.model import Matrix4, MeshField, Model, Profile, Vector3
from ..optics.medium import Medium
from .material import OpaqueMaterial

#: Instance ids: 0 is nothing, 1 the table, objects from 2 (a vessel and its liquid are one instance).
TABLE_ID, FIRST_OBJECT_ID = 1, 2
PART_OF = "Name of the vessel that it goes with and moves with: of caps, labels, stands"


def _is_none(value: object) -> bool:
    return value is None


def _is_one(value: int) -> bool:
    return value == 1


def _is_empty(value: object) -> bool:
    return not value


class Interface(Model):
    """A surface between two media. Its normals point from `back` to `front`."""

    part: Literal["outside", "wet_wall", "liquid_surface", "liquid_interface", "content"] = Field(
        description="air|glass, glass|liquid, liquid|air, liquid|liquid (normals up), and the surfaces of what is in a "
        "vessel (normals out of it)"
    )
    mesh: MeshField
    front: Medium = Field(description="The medium that the normals point into")
    back: Medium = Field(description="The medium behind")
    roughness: float = Field(default=0.0, ge=0.0, le=1.0, description="GGX alpha; 0 is smooth")
    # The next two are left out of files where there is nothing to say: what has neither stays what it was.
    content: int | None = Field(
        default=None, exclude_if=_is_none, ge=0, description="Of part `content`: number of the body in `contents`"
    )
    opaque: OpaqueMaterial | None = Field(
        default=None,
        exclude_if=_is_none,
        description="How the surface looks where no light passes: that of a turbid liquid, from the other medium",
    )
    seen_from_back: bool = Field(
        default=False, exclude_if=_is_empty, description="Whether the turbid liquid is in front, not behind"
    )


class Liquid(Model):
    """What a vessel holds."""

    medium: Medium
    level: float = Field(description="Height at which it would stand with a flat surface, object frame [m]")
    centre: float = Field(description="Height of the surface on the vessel's axis, object frame [m]")
    contact: float = Field(description="Height of the line where the surface meets the wall, object frame [m]")
    up: Vector3 | None = Field(
        default=None,
        exclude_if=_is_none,
        description="In a vessel that leans: the direction in its frame along which heights are measured; z without it",
    )
    contact_angle: float = Field(description="Angle inside the liquid between wall and surface at that line [rad]")
    fill: float = Field(gt=0.0, le=1.0, description="Fraction of the vessel's brimful volume")
    volume: float = Field(gt=0.0, description="Volume [m^3]")
    turbid: bool = Field(
        default=False,
        exclude_if=_is_empty,
        description="Whether no light travels in it here: its surfaces are opaque, with the colour of the liquid",
    )


class Content(Model):
    """A transparent body in a vessel, or many of one kind; its surfaces are the interfaces with its number."""

    kind: Literal["ice cube", "beads", "bubbles"]
    count: int = Field(default=1, ge=1, exclude_if=_is_one, description="Bodies of this kind that it stands for")
    medium: Medium = Field(description="What it is made of; air in a bubble")
    centre: Vector3 = Field(description="Middle of its bounding box, object frame of the vessel [m]")
    size: Vector3 = Field(description="Extent of its bounding box in that frame [m]")
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
    liquid: Liquid | None = Field(default=None, description="The liquid that stands on its floor")
    layers: tuple[Liquid, ...] = Field(
        default=(), exclude_if=_is_empty, description="The liquids that float on it, upwards, each lighter"
    )
    contents: tuple[Content, ...] = Field(default=(), exclude_if=_is_empty, description="Transparent bodies in it")
    redrawn: int = Field(
        default=0,
        ge=0,
        exclude_if=_is_empty,
        description="How often contents were drawn for it that did not fit, and drawn again",
    )
    within: str | None = Field(
        default=None, exclude_if=_is_none, description="Name of the vessel that it stands in, such as a rod's"
    )
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
        description="Motions that leave it unchanged but for small irregularities, without the identity [m]; where "
        "there are none they are found from the shape",
    )
    world_T_object: Matrix4

    @property
    def liquids(self) -> tuple[Liquid, ...]:
        """All liquids in it, from the floor up."""
        return () if self.liquid is None else (self.liquid, *self.layers)

    def __repr__(self) -> str:
        """Return one line: id, name, media and size."""
        held = " under ".join(liquid.medium.name for liquid in self.liquids)
        media = self.glass.name + (f" with {held}" if held else "")
        return f"{type(self).__name__}({self.id} {self.name!r}: {self.category} of {media}, {_millimetres(self.size)})"

    __str__ = __repr__

    def with_media(
        self, glass: Medium | None = None, liquid: Medium | None = None, roughness: float | None = None
    ) -> Self:
        """Return a copy with another glass, lowest liquid or roughness (GGX alpha) in all its fields.

        Shapes stay the same, also that of the liquid's surface, whatever the capillary constants of the new liquid.
        """
        glass = glass or self.glass
        roughness = self.roughness if roughness is None else roughness
        content = self.liquid
        if liquid is not None:
            if content is None:
                raise InputError(f"{self.name}, liquid", "a body that holds one", "an empty one")
            content = content.model_copy(update={"medium": liquid})
        before = None if self.liquid is None else self.liquid.medium

        def changed(part: Interface) -> Interface:
            update: dict[str, Medium | float] = {}
            for side in ("front", "back"):
                medium = getattr(part, side)
                update[side] = content.medium if content is not None and medium == before else medium
            if part.part in ("outside", "wet_wall"):
                update |= {"back": glass, "roughness": roughness}
            return part.model_copy(update=update)

        changes = {"glass": glass, "liquid": content, "roughness": roughness}
        return self.model_copy(update=changes | {"interfaces": tuple(changed(part) for part in self.interfaces)})


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
    surrounding: Medium | None = Field(
        default=None, exclude_if=_is_none, description="The medium before these faces; air without it"
    )
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
    within: str | None = Field(
        default=None, exclude_if=_is_none, description="Name of the vessel that it stands in, such as a straw's"
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
    parts = [interface.mesh for interface in body.interfaces if interface.part in ("outside", "wet_wall")]
    return joined(parts, f"{body.name}-glass")


def liquid_solid(body: GlassBody, number: int = 0, others: Iterable[tuple[Mesh, Medium]] = ()) -> Mesh:
    """Return the closed surface of a liquid's body, object frame, normals out of the liquid.

    Parameters
    ----------
    body : GlassBody
        The vessel.
    number : int
        Which of its liquids, from the floor up.
    others : iterable of (Mesh, Medium)
        Surfaces of bodies that stand in it, object frame, each with the medium before it (`edits.standing_in`).

    Raises
    ------
    ValueError
        Where the body holds no such liquid.
    """
    if not -len(body.liquids) <= number < len(body.liquids):
        raise ValueError(f"{body.name}: expected a liquid {number} in it, found {len(body.liquids)}")
    medium = body.liquids[number].medium
    before = [(part.mesh, part.front) for part in body.interfaces]
    sides = [part.mesh for part in body.interfaces if part.back == medium]
    sides += [turned(mesh) for mesh, front in (*before, *others) if front == medium]
    return joined(sides, f"{body.name}-liquid")


def is_filled(item: SceneObject) -> bool:
    """Return whether something is in a body that keeps its place only while the body stands: a liquid, beads, ice."""
    return isinstance(item, GlassBody) and (item.liquid is not None or bool(item.contents))


def content_solid(body: GlassBody, number: int) -> Mesh:
    """Return the closed surface of one of a vessel's contents, object frame, normals out of it."""
    return joined([part.mesh for part in body.interfaces if part.content == number], f"{body.name}-content-{number}")
