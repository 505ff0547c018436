"""Table, environment and area lights, as data."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from ...core.assets import Asset
from ...core.model import Matrix4, MeshField, Model, Reflectance, Rgb, Unit, Vector3
from .material import OpaqueMaterial, PictureTexture

PositiveSide = Annotated[float, Field(gt=0.0, le=100.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Wall = Literal["+x", "-x", "+y", "-y", "ceiling"]


#: What flat prints on tables are.
PrintKind = Literal["sheet", "newspaper", "card", "markers", "board", "mat", "sticker", "tape", "stain"]


class TablePrint(Model):
    """Something flat on a table that is no object: it changes what the table's top looks like, and nothing else."""

    kind: PrintKind = Field(description="What it is, such as 'sheet' or 'markers'")
    centre: tuple[float, float] = Field(description="Its middle on the table's top, x and y [m]")
    angle: float = Field(default=0.0, description="Turn of its width from the x axis, about +z [rad]")
    size: tuple[PositiveSide, PositiveSide] = Field(description="Width and height [m]")
    material: OpaqueMaterial = Field(description="Its texture is shown once, whatever its repeats")

    @model_validator(mode="after")
    def _flat(self) -> TablePrint:
        if self.material.base_colour.kind == "vertices":
            raise ValueError("material: expected a texture, found colours of vertices")
        if self.material.emission is not None:
            raise ValueError("material: expected one that does not shine, found an emission")
        return self

    @property
    def corners(self) -> np.ndarray:
        """Its corners on the table's top, (4, 2) float64, counter-clockwise [m]."""
        half = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * self.size
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return half @ np.array([[cos, sin], [-sin, cos]]) + self.centre


class Table(Model):
    """The table: a board whose top is at z = 0. Texture coordinates are in metres."""

    mesh: MeshField
    material: OpaqueMaterial
    size: tuple[float, float, float] = Field(
        description="Extent along x and y, and from the top down to its lowest point, such as a cloth's hem [m]"
    )
    kind: str = Field(
        default="plain", exclude_if=lambda kind: kind == "plain", description="What it is, such as 'wood' or 'cloth'"
    )
    prints: tuple[TablePrint, ...] = Field(
        default=(), exclude_if=lambda prints: prints == (), description="Flat things on its top; later ones lie above"
    )

    @model_validator(mode="after")
    def _shown(self) -> Table:
        if self.prints and (self.mesh.uv is None or self.material.base_colour.kind == "vertices"):
            raise ValueError("prints: expected a table with a texture and its coordinates, found one without")
        return self


class Window(Model):
    """A light source: a rectangle on a wall or the ceiling of a room."""

    kind: Literal["window", "lamp"] = Field(
        default="window", description="A view to the outside, or an evenly lit diffuser (ceiling lamp, soft box)"
    )
    wall: Wall
    centre: tuple[float, float] = Field(
        description="Centre on the wall, from the room's corner: along it and up (ceiling: x, y) [m]"
    )
    size: tuple[float, float] = Field(description="Width and height [m]")
    radiance: Rgb = Field(description="Radiance of the sky outside or of the lamp, linear Rec.709 [kcd/m^2]")
    bars: int = Field(default=0, ge=0, le=6, description="Number of mullions across each direction")


class Panel(Model):
    """A flat opaque rectangle on a wall: a door, a picture, a board."""

    wall: Wall
    centre: tuple[float, float] = Field(description="Centre on the wall, as for `Window` [m]")
    size: tuple[float, float] = Field(description="Width and height [m]")
    colour: Reflectance = Field(description="Linear Rec.709 reflectance")


class Block(Model):
    """An opaque box that stands in a room: a cupboard, a shelf, a sofa's part."""

    lower: Vector3 = Field(description="Smallest coordinates, from the room's corner [m]")
    upper: Vector3 = Field(description="Largest coordinates, from the room's corner [m]")
    colour: Reflectance = Field(description="Linear Rec.709 reflectance")


#: What a surface of a room belongs to.
RoomPart = Literal["wall", "floor", "ceiling", "window", "lamp", "picture", "furniture", "table-leg"]
#: Ids of the surfaces of a room in labels, above those of all objects: multiples of 32, which halves hold exactly.
ROOM_IDS: dict[RoomPart, int] = {
    "wall": 65248,
    "floor": 65280,
    "ceiling": 65312,
    "window": 65344,
    "lamp": 65376,
    "picture": 65408,
    "furniture": 65440,
    "table-leg": 65472,
}
#: Ids from here on are those of surroundings.
FIRST_ROOM_ID = 65248
#: What a room is used for.
RoomUse = Literal["plain", "kitchen", "laboratory", "dining-room", "study"]


class Detail(Model):
    """A small opaque body in a room: a leg, a door of a cupboard, a book, the housing of a lamp."""

    part: RoomPart
    shape: Literal["box", "cylinder"] = Field(default="box", description="A cylinder's axis is its local z")
    room_T_detail: Matrix4
    size: Vector3 = Field(description="Extent along its own axes [m]; of a cylinder, both diameters and the length")
    colour: Reflectance = Field(description="Linear Rec.709 reflectance")
    finish: Literal["plain", "wood"] = Field(default="plain", description="One colour, or wood of that mean colour")


class RoomPicture(Model):
    """A picture that covers walls or floor of a room: their reflectance, from place to place."""

    texture: PictureTexture
    size: tuple[PositiveSide, PositiveSide] = Field(description="Width and height of what the picture shows [m]")


class RoomEnvironment(Model):
    """A box-shaped room with windows, lamps and furniture, around the table or as a map at infinity."""

    kind: Literal["room"] = "room"
    at_infinity: bool = Field(
        default=True,
        exclude_if=lambda at_infinity: at_infinity,
        description="Whether the room is seen from the table's centre, as a map without depth; else its walls and "
        "furniture are surfaces in their places",
    )
    use: RoomUse = Field(default="plain", exclude_if=lambda use: use == "plain", description="What it is used for")
    details: tuple[Detail, ...] = Field(
        default=(), exclude_if=lambda details: details == (), description="Small bodies, only of rooms in their places"
    )
    floor_tile: float = Field(
        default=0.0, ge=0.0, exclude_if=lambda side: side == 0.0, description="Side of the floor's tiles [m]; 0: none"
    )
    wall_picture: RoomPicture | None = Field(default=None, exclude_if=lambda picture: picture is None)
    floor_picture: RoomPicture | None = Field(
        default=None, exclude_if=lambda picture: picture is None, description="Goes before boards and tiles"
    )
    size: Vector3 = Field(description="Inner extent along x, y, z [m]")
    eye: Vector3 = Field(description="Where the table's centre is in the room, from a corner [m]")
    wall_colours: tuple[Reflectance, ...] = Field(
        min_length=6, max_length=6, description="Reflectance of +x -x +y -y ceiling floor"
    )
    windows: tuple[Window, ...] = Field(min_length=1, description="Windows and lamps")
    panels: tuple[Panel, ...] = ()
    blocks: tuple[Block, ...] = ()
    board_width: float = Field(default=0.0, ge=0.0, description="Width of the floor's boards [m]; 0 for none")
    seed: int = Field(ge=0, description="Seed of the small variation on walls and floor")
    rotation: float = Field(default=0.0, description="Turn about +z [rad]")
    strength: float = Field(default=1.0, gt=0.0, description="Factor on all radiance")


class SkyEnvironment(Model):
    """An open sky with a sun and a ground."""

    kind: Literal["sky"] = "sky"
    sun_elevation: float = Field(gt=0.0, le=1.5707963267948966, description="Elevation of the sun [rad]")
    sun_illuminance: float | None = Field(
        default=None,
        ge=0.0,
        description="Illuminance of a plane that faces the sun, under a clear sky [klx]; without it the sun is a soft "
        "disc of `sun_radiance`",
    )
    sun_radiance: float = Field(
        default=0.0, ge=0.0, description="Luminance of a soft disc's middle, relative to the zenith's"
    )
    sun_radius: float = Field(gt=0.0, le=1.5707963267948966, description="Angular radius of the disc [rad]")
    turbidity: float = Field(ge=1.7, le=10.0, description="Haze (Preetham et al. 1999), 2 clear to 10 hazy")
    cloudiness: Unit = Field(description="Fraction of the sky covered by clouds")
    ground: Reflectance = Field(description="Reflectance of the ground, lit by this sky")
    seed: int = Field(ge=0, description="Seed of the clouds and the skyline")
    rotation: float = Field(default=0.0, description="Turn about +z [rad]; 0 has the sun at azimuth 0")
    strength: float = Field(default=1.0, gt=0.0, description="Factor on all radiance")


class PictureEnvironment(Model):
    """An equirectangular environment map from a file (EXR or HDR), +z up."""

    kind: Literal["picture"] = "picture"
    asset: Asset
    rotation: float = 0.0
    strength: float = Field(default=1.0, gt=0.0)


class ConstantEnvironment(Model):
    """The same radiance from every direction (a white furnace, an overcast day without a horizon)."""

    kind: Literal["constant"] = "constant"
    radiance: tuple[NotNegative, NotNegative, NotNegative] = Field(
        default=(1.0, 1.0, 1.0), description="Linear Rec.709"
    )
    strength: float = Field(default=1.0, gt=0.0, description="Factor on all radiance")

    @property
    def rotation(self) -> float:
        """Turn about +z [rad], as the other environments have it: none."""
        return 0.0


Environment = Annotated[
    RoomEnvironment | SkyEnvironment | PictureEnvironment | ConstantEnvironment, Field(discriminator="kind")
]


#: Kinds of lamps. A rectangle is light of no particular source, in the unit of its environment.
LampKind = Literal["rectangle", "bulb", "desk-lamp", "tube", "panel", "soft-box"]


class AreaLight(Model):
    """A rectangle that emits light on one side, along its local +z."""

    kind: LampKind = Field(default="rectangle", description="What it stands for (`lamps.LAMPS` has their limits)")
    world_T_light: Matrix4
    size: tuple[float, float] = Field(description="Extent along its local x and y [m]")
    radiance: Rgb = Field(description="Linear Rec.709; of a lamp [kcd/m^2]")
