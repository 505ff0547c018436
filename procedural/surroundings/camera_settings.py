"""Settings of the stereo cameras: how they are placed, and what they are."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from ...core.model import Model, Ordered
from ...core.units import ANGLE, LENGTH, Angle, Length, degrees
from ...core.user_text import UserPath
from ..description.camera import LONGEST_SIDE
from .camera_presets import known_preset, with_preset
from .intrinsics import Intrinsics

#: Picture width that `CameraSettings.focal` is given for [px].
FOCAL_WIDTH = 640
#: Views of the paper's grid (`camera_poses`), and most views of a scene: their folders are named by three digits.
GRID_VIEWS, MOST_VIEWS = 57, 1000
#: Farthest that a principal point may be from the middle of the picture [fraction of the side]. Those of real cameras
#: are within a twentieth; K of a picture half or twice the size is off by a quarter or more.
OFF_CENTRE = 0.1
#: Largest turn away from the point looked at [rad]: no drawn camera looks backwards.
MOST_TILT = 0.5

# Ten times as far away, the objects are a hundredth of the picture.
_Factor = Annotated[float, Field(ge=1.0, le=10.0)]
_Elevation = Annotated[float, Field(ge=0.0, le=math.pi / 2), ANGLE]
_Azimuth = Annotated[float, Field(ge=-2.0 * math.pi, le=2.0 * math.pi), ANGLE]
_Distance = Annotated[float, Field(gt=0.0, le=20.0), LENGTH]
#: A focal length [px]: pictures of 32 px have one of some 30.
_Focal = Annotated[float, Field(ge=1.0, le=1e6)]
#: Widest field of view [rad], that of the least `CameraSettings.focal`.
FOV = math.radians(162.0)
#: A row of a matrix.
Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]
#: A matrix by rows.
Matrix3Rows = tuple[Row3, Row3, Row3]
Matrix4Rows = tuple[Row4, Row4, Row4, Row4]


class CameraSettings(Model):
    """The stereo cameras: on the paper's grid, in ranges of directions and distances, or at poses from a file."""

    views: int = Field(
        default=10,
        ge=1,
        le=MOST_VIEWS,
        description="Stereo pairs of a scene: 1 to 57 on the grid (57 is the paper's whole grid), otherwise up to 1000",
    )
    preset: Annotated[str, AfterValidator(known_preset)] | None = Field(
        default=None,
        description="Camera whose size, intrinsics and baseline are taken where they are not set: d415, d435, keypose, "
        "syn-todd or zed2",
    )
    width: int = Field(default=640, ge=1, le=16384, description="Picture width, 1 to 16384 [px]")
    height: int = Field(default=480, ge=1, le=16384, description="Picture height, 1 to 16384 [px]")
    scale: float = Field(
        default=1.0, ge=0.01, le=4.0, description="Pictures of this many times the width and height, of the same view"
    )
    focal: float = Field(
        default=613.9624633789062,
        ge=50.0,
        le=20000.0,
        description="Focal length of a picture 640 px wide, 50 to 20000 [px] (162 to 1.8 degrees across); scales with "
        "the width (Syn-TODD). `fx` or `K` takes its place",
    )
    fov: Annotated[float, Field(gt=0.0, le=FOV), ANGLE] | None = Field(
        default=None, description="Horizontal field of view [rad], 0 to 162 degrees, such as 69deg; in place of `fx`"
    )
    fx: _Focal | None = Field(default=None, description="Focal length along x at the picture's own size [px]")
    fy: _Focal | None = Field(default=None, description="Focal length along y [px]; by default `fx`")
    cx: float | None = Field(
        default=None, description="Principal point along x [px], 0 in the middle of the first pixel; by default central"
    )
    cy: float | None = Field(default=None, description="Principal point along y [px]; by default central")
    K: Matrix3Rows | None = Field(
        default=None, description="Intrinsic matrix at the picture's own size, by rows [px]; in place of fx fy cx cy"
    )
    baseline: Length = Field(
        default=0.06499999761581421, gt=0.0, le=1.0, description="Left to right camera [m], 0 to 1 (Syn-TODD)"
    )
    elevation: Annotated[tuple[_Elevation, _Elevation], Ordered] | None = Field(
        default=None,
        description="Range of the height over the horizon at which cameras stand, seen from the point looked at [rad], "
        "0 to 90 degrees: a camera that looks down by 30 degrees has 30deg. Cameras leave the grid for random "
        "directions where this, the azimuth or the distance is given",
    )
    azimuth: Annotated[tuple[_Azimuth, _Azimuth], Ordered] | None = Field(
        default=None,
        description="Range of the direction in which cameras stand, counter-clockwise from the table's x axis [rad]; "
        "all around by default",
    )
    distance: Annotated[tuple[_Distance, _Distance], Ordered] | None = Field(
        default=None,
        description="Range of the distance to the point looked at, up to 20 [m]; by default all objects are in view",
    )
    poses: UserPath | None = Field(
        default=None,
        description="File of camera poses (world_T_camera; OpenCV axes, metres, the origin on the middle of the "
        "table's top with z up): 4x4 matrices as text, JSON, YAML or NPY, TUM lines, or hand-eye lists. `views` of "
        "them are used, all by default",
    )
    world_T_poses: Matrix4Rows | None = Field(
        default=None, description="Pose of the frame of `poses` on the table, 4x4 by rows; by default they are the same"
    )
    slack: Annotated[tuple[_Factor, _Factor], Ordered] = Field(
        default=(1.0, 1.35),
        description="Range of the distance over the shortest that shows all objects, 1 to 10; without `distance`",
    )
    min_distance: Length = Field(
        default=0.3,
        gt=0.0,
        le=20.0,
        description="Shortest distance to the point looked at [m], 0 to 20; without `distance`",
    )
    lowest_elevation: Angle = Field(
        default=math.radians(10.0),
        ge=0.0,
        le=math.radians(80.0),
        description="Elevation of the lowest ring [rad], 0 to 80 degrees; the other rings follow in equal steps",
    )
    min_height: Length = Field(
        default=0.05, ge=0.0, le=20.0, description="Lowest height of a camera over the table [m], 0 to 20"
    )
    angle_jitter: Angle = Field(
        default=0.0,
        ge=0.0,
        le=0.5,
        description="Largest change of elevation and azimuth of a view on the grid [rad], 0 to 0.5",
    )
    target_jitter: Length = Field(
        default=0.0, ge=0.0, le=1.0, description="Largest change of the point looked at, per axis [m], 0 to 1"
    )
    look_jitter: Angle = Field(
        default=0.0,
        ge=0.0,
        le=MOST_TILT,
        description="Largest angle between the looking direction and the point looked at [rad], 0 to 0.5",
    )
    white_balance: Literal["off", "grey-world", "light"] = Field(
        default="light",
        description="Colour of the 8-bit pictures: that of the light (off), or balanced as a camera does: by the mean "
        "of the picture (grey-world) or by the light that falls on the table (light)",
    )
    highlights: Literal["clip", "soft"] = Field(
        default="soft",
        description="What is brighter than white in the 8-bit pictures: white (clip), or compressed from 0.7 on, as "
        "film and cameras do, so that windows show a view (soft)",
    )
    roll: Angle = Field(default=0.0, ge=0.0, le=math.pi, description="Largest turn about the optical axis [rad]")

    @model_validator(mode="before")
    @classmethod
    def _preset(cls, given: Any) -> Any:
        return with_preset(given) if isinstance(given, dict) else given

    @model_validator(mode="after")
    def _fit_together(self) -> CameraSettings:
        _check_intrinsics(self)
        _check_placing(self)
        return self

    @property
    def in_ranges(self) -> bool:
        """Whether cameras stand in random directions rather than on the grid."""
        return any(one is not None for one in (self.elevation, self.azimuth, self.distance))

    def intrinsics(self) -> Intrinsics:
        """Return the intrinsics of the pictures."""
        lens = _unscaled(self)
        if self.scale == 1.0:
            return lens
        return lens.resized(*(max(1, round(self.scale * side)) for side in (lens.width, lens.height)))


def _unscaled(settings: CameraSettings) -> Intrinsics:
    fx, fy, cx, cy = settings.fx, settings.fy, settings.cx, settings.cy
    if settings.K is not None:
        (fx, _, cx), (_, fy, cy), _ = settings.K
    if settings.fov is not None:
        fx = 0.5 * settings.width / math.tan(0.5 * settings.fov)  # from edge to edge
    if fx is None:
        fx = settings.focal * settings.width / FOCAL_WIDTH
    return Intrinsics(
        width=settings.width,
        height=settings.height,
        fx=fx,
        fy=fx if fy is None else fy,
        cx=(settings.width - 1) / 2 if cx is None else cx,
        cy=(settings.height - 1) / 2 if cy is None else cy,
    )


def _check_intrinsics(settings: CameraSettings) -> None:
    single = [name for name in ("fx", "fy", "cx", "cy") if getattr(settings, name) is not None]
    if settings.K is not None:
        if single:
            raise ValueError(f"K: expected it or fx fy cx cy, found it with {', '.join(single)}")
        _check_matrix(settings.K)
    if settings.fov is not None and (single or settings.K is not None):
        raise ValueError(f"fov: expected it or K or fx fy cx cy, found it with {'K' if settings.K else single[0]}")
    if settings.fy is not None and settings.fx is None:
        raise ValueError(f"fy: expected fx beside it, found {settings.fy:g} alone")
    _check_centre(_unscaled(settings), "K" if settings.K is not None else "")
    longest = settings.scale * max(settings.width, settings.height)
    if round(longest) > LONGEST_SIDE:
        most = LONGEST_SIDE / max(settings.width, settings.height)
        raise ValueError(f"scale: expected at most {most:.4g}, pictures of {LONGEST_SIDE} px, found {settings.scale:g}")
    narrowest = min(settings.intrinsics().half_angles())
    if settings.look_jitter >= narrowest:
        limit = degrees(0.9 * narrowest)
        raise ValueError(
            f"look_jitter: expected at most {limit}, so that the objects stay in the picture, "
            f"found {degrees(settings.look_jitter)}"
        )


def _check_matrix(K: Matrix3Rows) -> None:
    (fx, skew, _), (below, fy, _), last = K
    if (skew, below, last) != (0.0, 0.0, (0.0, 0.0, 1.0)):
        raise ValueError(f"K: expected rows fx 0 cx, 0 fy cy, 0 0 1, found {[list(row) for row in K]}")
    if not (1.0 <= fx <= 1e6 and 1.0 <= fy <= 1e6):
        raise ValueError(f"K: expected focal lengths of 1 to 1e6 px, found {fx:g} and {fy:g}")


def _check_centre(lens: Intrinsics, matrix: str) -> None:
    """Refuse a principal point that belongs to a picture of another size."""
    for name, value, side, extent in (("cx", lens.cx, "width", lens.width), ("cy", lens.cy, "height", lens.height)):
        low, high = (0.5 * (extent - 1) + sign * OFF_CENTRE * extent for sign in (-1, 1))
        if not low <= value <= high:
            likely = max(1, round(2.0 * value + 1.0))
            raise ValueError(
                f"{matrix or name}: expected {f'{name} of ' if matrix else ''}{low:.1f} to {high:.1f} px in a picture "
                f"of {side} {extent} (a {side} of {likely} would fit it), found {value:g}"
            )


def _check_placing(settings: CameraSettings) -> None:
    """Refuse placements that exclude each other: the grid, ranges, and poses from a file."""
    ranges = [name for name in ("elevation", "azimuth", "distance") if getattr(settings, name) is not None]
    jitters = [
        name for name in ("angle_jitter", "target_jitter", "look_jitter", "roll") if getattr(settings, name) > 0.0
    ]
    if settings.poses is not None and ranges + jitters:
        raise ValueError(f"{(ranges + jitters)[0]}: expected none beside cameras.poses, found a value")
    if settings.poses is None and settings.world_T_poses is not None:
        raise ValueError("world_T_poses: expected cameras.poses beside it, found it alone")
    if ranges and settings.angle_jitter > 0.0:
        found = degrees(settings.angle_jitter)
        raise ValueError(f"angle_jitter: expected 0 beside the range of {ranges[0]}, found {found}")
    if settings.azimuth is not None and settings.azimuth[1] - settings.azimuth[0] > 2.0 * math.pi + 1e-9:
        found = degrees(settings.azimuth[1] - settings.azimuth[0])
        raise ValueError(f"azimuth: expected a range of at most 360deg, found {found}")
    if not ranges and settings.poses is None and settings.views > GRID_VIEWS:
        raise ValueError(
            f"views: expected less than or equal to {GRID_VIEWS} on the grid (cameras.elevation, azimuth or distance "
            f"leave it), found {settings.views}"
        )
