"""The description of a scene: frozen, typed, free of any renderer.

Metres, radians; world frame right-handed, z up, table top at z = 0. ``a_T_b`` takes coordinates in b to coordinates
in a. These models are what ``scene.json`` holds (`procedural.scene.scene_file` reads and writes it).
"""

from __future__ import annotations

from html import escape
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag

from ...core.arguments import check_type, number, point, whole_number
from ...core.errors import InputError
from ...core.html import convex_outline, html_table, svg_plan
from ...core.images import id_colour
from ...core.mesh import Mesh, joined, turned
from ...core.model import Matrix4, MeshField, Model, Profile, Vector3
from ...core.pose import look_at
from ...core.setting_errors import suggest
from ...core.user_text import counted
from ..optics.catalogue import dyed, glass_named
from ..optics.medium import AIR, Medium
from .camera import Camera
from .material import OpaqueMaterial
from .picture import Picture
from .surroundings import AreaLight, Environment, Table

#: Version of the description; the last part changes when an old reader would be misled.
SCENE_SCHEMA = "glassware/scene/1"
#: Instance ids: 0 is nothing, 1 the table, objects from 2 (a vessel and its liquid are one instance).
TABLE_ID, FIRST_OBJECT_ID = 1, 2


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


class GlassBody(Model):
    """A transparent solid, with or without a liquid in it; the frame's origin is the centre of its bounding box."""

    id: int = Field(ge=FIRST_OBJECT_ID, description="Instance id")
    name: str = Field(description="Unique in the scene")
    category: str = Field(description="Such as 'tumbler', 'bottle', 'prism'")
    glass: Medium = Field(description="The medium that the body is made of")
    roughness: float = Field(ge=0.0, le=1.0, description="GGX alpha of the glass; 0 is smooth")
    liquid: Liquid | None = None
    interfaces: tuple[Interface, ...] = Field(
        description="The surfaces that light meets, each once; normals of outside and wet_wall point out of the glass, "
        "those of liquid_surface into the air"
    )
    size: Vector3 = Field(description="Extent of the bounding box in the object frame [m]")
    symmetric: bool = Field(default=False, description="Whether it is a solid of revolution about its z axis")
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


class PropPart(Model):
    """Faces of a prop's mesh that have a material of their own."""

    faces: int = Field(ge=0, description="Number of faces; the parts follow each other in the list of the mesh's faces")
    material: OpaqueMaterial


class Origin(Model):
    """Where a mesh comes from."""

    file: str = Field(description="The mesh file, below the folder that the user gave")
    layout: str = Field(description="How the folder is laid out, such as shapenet, gso, ycb, bop or plain")
    licence: str = Field(default="unknown", description="Licence, if the file or its folder says so")
    metres_per_unit: float = Field(gt=0.0, description="Length of the file's unit here [m]")
    centre: Vector3 = Field(description="The object frame's origin, in the file's axes and unit")
    up: Literal["y", "z"] = Field(default="z", description="The file's axis that is z here; y is turned about x")


class Prop(Model):
    """An opaque object; the frame's origin is the centre of its bounding box."""

    id: int = Field(ge=FIRST_OBJECT_ID, description="Instance id")
    name: str = Field(description="Unique in the scene")
    category: str = Field(description="Shape, or the file that the mesh came from")
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


def _kind_of_body(body: object) -> str:
    """Return the type of a glass body in a scene file, or of one made by hand: a vessel has profiles."""
    if isinstance(body, dict):
        return "vessel" if body.keys() & {"wall", "outer", "inner"} else "body"
    return "vessel" if isinstance(body, Vessel) else "body"


class Scene(Model):
    """Table, objects, light, cameras and picture settings."""

    schema_version: Literal["glassware/scene/1"] = SCENE_SCHEMA
    seed: int = Field(ge=0, description="Seed of the data set")
    scene_id: int = Field(ge=0, description="Number of the scene in the data set")
    table: Table
    vessels: tuple[
        Annotated[Annotated[Vessel, Tag("vessel")] | Annotated[GlassBody, Tag("body")], Discriminator(_kind_of_body)],
        ...,
    ] = Field(description="Vessels and other transparent bodies")
    props: tuple[Prop, ...]
    environment: Environment
    lights: tuple[AreaLight, ...]
    cameras: tuple[Camera, ...] = Field(min_length=1)
    picture: Picture

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """Glass bodies and props in the order of their ids."""
        return tuple(sorted((*self.vessels, *self.props), key=lambda item: item.id))

    def with_glass(self, name: str, glass: Medium | str, roughness: float | None = None) -> Scene:
        """Return a copy in which a vessel is of another glass.

        Parameters
        ----------
        name : str
            Name of the vessel.
        glass : Medium or str
            A medium, or its name in the catalogue (`optics.catalogue.glasses`), such as ``"lead crystal"``.
        roughness : float, optional
            GGX alpha of the glass; unchanged by default.

        Raises
        ------
        InputError
            Where there is no such vessel or glass, or the roughness is not within 0 and 1.
        """
        check_type("glass", glass, (str, Medium), "a Medium, or its name in the catalogue")
        if roughness is not None:
            roughness = number("roughness", roughness, 0.0, 1.0)
        medium = glass_named(glass) if isinstance(glass, str) else glass
        return self._with_body(self._body(name).with_media(glass=medium, roughness=roughness))

    def with_dye(self, name: str, dye: str, concentration: float) -> Scene:
        """Return a copy in which a dye is dissolved in a vessel's liquid (`optics.catalogue.dyed`).

        Parameters
        ----------
        name : str
            Name of the vessel.
        dye : str
            Name of the dye (`optics.dyes.DYES`), such as ``"brilliant blue FCF"``.
        concentration : float
            Of the dye [kg/m^3], 0 to 1000; a soft drink has 0.002 to 0.1.

        Raises
        ------
        InputError
            Where there is no such vessel or dye, the vessel is empty, or the concentration is impossible.
        """
        body = self._body(name)
        if body.liquid is None:
            raise InputError(f"{name}, liquid", "a vessel that holds one", "an empty one")
        return self._with_body(body.with_media(liquid=dyed(body.liquid.medium, dye, concentration)))

    def with_camera(self, view: int, eye: Vector3, target: Vector3 = (0.0, 0.0, 0.0)) -> Scene:
        """Return a copy in which a camera is at another place and looks at a point, +z up in the picture.

        Parameters
        ----------
        view : int
            Number of the camera.
        eye, target : (float, float, float)
            Place of its left eye, and the point in the middle of its picture, world frame [m].

        Raises
        ------
        InputError
            Where there is no such camera, eye or target is no point, or they are the same point.
        """
        view = whole_number("view", view, 0, len(self.cameras) - 1)
        place, aim = point("camera, eye", eye), point("camera, target", target)
        if np.allclose(place, aim, rtol=0.0, atol=1e-9):
            raise InputError("camera, target", "a point away from the eye", aim.tolist())
        moved = self.cameras[view].model_copy(update={"world_T_camera": look_at(place, aim)})
        return self.model_copy(update={"cameras": (*self.cameras[:view], moved, *self.cameras[view + 1 :])})

    def _body(self, name: str) -> GlassBody:
        check_type("vessel", name, str, "the name of a vessel")
        names = [body.name for body in self.vessels]
        if name not in names:
            known = ", ".join(names) or "nothing, as the scene has no vessel"
            raise InputError("vessel", f"one of {known}{suggest(name, names)}", repr(name))
        return self.vessels[names.index(name)]

    def _with_body(self, body: GlassBody) -> Scene:
        vessels = tuple(body if other.id == body.id else other for other in self.vessels)
        return self.model_copy(update={"vessels": vessels})

    def __repr__(self) -> str:
        """Return one line: the seed, what is in the scene, and the pictures' size."""
        counts = (("vessel", self.vessels), ("prop", self.props), ("camera", self.cameras))
        vessels, props, cameras = (counted(len(some), name) for name, some in counts)
        surroundings = {"picture": "map"}.get(self.environment.kind, self.environment.kind)
        sizes = sorted({f"{camera.width}x{camera.height}" for camera in self.cameras})
        seed = f"seed {self.seed}/{self.scene_id}"
        return f"Scene({seed}: {vessels}, {props}, {surroundings}, {cameras} {' '.join(sizes)})"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Show a plan of the table from above and a list of the objects in a notebook; nothing is rendered."""
        length, width, _ = self.table.size
        board = 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])
        outlines = [("", board, "#e8e0d4")]
        for item in self.objects:
            mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
            places = mesh.vertices @ item.world_T_object[:3, :3].T + item.world_T_object[:3, 3]
            outlines.append((str(item.id), convex_outline(places[:, :2]), "#" + bytes(id_colour(item.id)).hex()))
        rows = [(item.id, item.name, repr(item).partition(": ")[2].rstrip(")")) for item in self.objects]
        text = f"<p>{escape(repr(self))}</p>"
        return text + svg_plan(outlines) + html_table(("id", "name", "what"), rows)


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


def materials_of(scene: Scene) -> tuple[Medium | OpaqueMaterial, ...]:
    """Return the materials of a scene, each once: air, the table's, then those of the objects by their ids.

    Labels name them by their place in this list. Of a glass body, the glass comes before the liquid.
    """
    found: list[Medium | OpaqueMaterial] = [AIR]
    for material in [scene.table.material, *(part for item in scene.objects for part in _materials_of_object(item))]:
        if material not in found:
            found.append(material)
    return tuple(found)


def _materials_of_object(item: SceneObject) -> list[Medium | OpaqueMaterial]:
    if isinstance(item, Prop):
        return [piece.material for piece in item.pieces]
    media = [medium for interface in item.interfaces for medium in (interface.back, interface.front)]
    return [item.glass, *([item.liquid.medium] if item.liquid else []), *media]
