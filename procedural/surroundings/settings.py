"""Settings of the environment and the area lights."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model, Ordered, Unit
from ...core.units import ANGLE, Angle, Length
from ...core.user_text import UserPath
from .sun import LARGEST_SUN, SMALLEST_SUN, SUN_RADIUS

# A range of a uniform draw: smallest and largest value, with the limits of both.
_Elevation = Annotated[float, Field(ge=0.1, le=math.pi / 2), ANGLE]
ElevationRange = Annotated[tuple[_Elevation, _Elevation], Ordered]


#: Kinds of lamps that are drawn (`lamps.LAMPS`).
DrawnKind = Literal["bulb", "desk-lamp", "tube", "panel", "soft-box"]


#: Uses of furnished rooms that are drawn.
DrawnUse = Literal["kitchen", "laboratory", "dining-room", "study"]


class EnvironmentSettings(Model):
    """The environment map: from a file of the user or of the package, a procedural room or a procedural sky."""

    hdri_dir: UserPath | None = Field(
        default=None, description="Folder of environment maps (EXR, HDR, panoramas in JPEG); none by default"
    )
    hdri_share: Unit = Field(
        default=1.0, description="Probability that a scene is lit by a file, if there is a folder, 0 to 1"
    )
    hdri_calibrated: bool = Field(
        default=False,
        description="Whether the files hold kcd/m^2; otherwise each is scaled to an illuminance that such a place has",
    )
    shipped_share: Unit = Field(
        default=0.5,
        description="Probability that a scene without a file of that folder is lit by one of the eight maps of the "
        "package; otherwise its environment is procedural",
    )
    room_share: Unit = Field(
        default=0.7, description="Probability that a procedural environment is a room; otherwise it is a sky"
    )
    room_depth: bool = Field(
        default=False,
        description="Whether a procedural room is furnished and has its walls in their places, with depth and "
        "parallax, for twice the time of a picture; otherwise it is a map at infinity",
    )
    room_uses: tuple[DrawnUse, ...] = Field(
        default=("kitchen", "laboratory", "dining-room", "study"),
        min_length=1,
        description="What such rooms are used for, each as often as it is named",
    )
    texture_dir: UserPath | None = Field(
        default=None,
        description="Folder of pictures and materials for procedural rooms, in subfolders `walls` and `floors`; their "
        "pictures in colour are used",
    )
    sun_radius: Angle = Field(
        default=SUN_RADIUS,
        ge=SMALLEST_SUN,
        le=LARGEST_SUN,
        description="Angular radius of the sun in drawn skies [rad], from the real 0.27 degrees to 5 degrees. "
        "Path tracing finds the caustics of a sun of 0.035 (2 degrees) with far fewer samples; its shadows and "
        "caustics are softer",
    )


class LightSettings(Model):
    """Random lamps around the table, indoors; under an open sky there are none."""

    max_count: int = Field(
        default=3,
        ge=0,
        le=16,
        description="Largest number of lamps in a scene; 0 to this many are drawn, fewer where the room has no place",
    )
    kinds: tuple[DrawnKind, ...] = Field(
        default=("bulb", "desk-lamp", "tube", "panel", "soft-box"),
        min_length=1,
        description="Kinds that lamps are drawn from; each has the sizes, flux and colour of real ones",
    )
    elevation: ElevationRange = Field(
        default=(math.radians(25.0), math.radians(80.0)),
        description="Range of the elevation seen from the table's centre [rad], 0.1 to pi/2",
    )
    margin: Length = Field(
        default=0.1, ge=0.0, le=20.0, description="Gap between the farthest camera and any lamp [m], 0 to 20"
    )
    spread: Length = Field(
        default=1.0, ge=0.0, le=20.0, description="Largest extra distance beyond the gap [m], 0 to 20 (a hall)"
    )
    aim: Length = Field(
        default=0.2,
        ge=0.0,
        le=2.0,
        description="Largest distance of the aimed-at point from the centre [m], 0 to 2; at most half the light's own",
    )
