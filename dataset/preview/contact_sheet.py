"""The contact sheet of a scene: a row per view, a column per kind of label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ...annotate.boxes import EDGES
from ...annotate.labels import Labels, ObjectLabel
from ...annotate.projection import project_camera
from ...core.images import depth_colours, id_colour, id_colours, normal_colours
from ...procedural.description.camera import Camera
from ...render.frame import Geometry
from .sensor_cells import Cell, SensorPreview, sensor_cells, stokes_cells

#: Largest number of rows of a sheet, so that it fits a screen.
MAX_VIEWS = 5
#: Width of a picture in the sheet, gap between pictures, height of a line of captions, width of the row captions [px].
_CELL, _GAP, _CAPTION, _GUTTER = 320, 6, 30, 56
_BACKGROUND, _TEXT_COLOUR, _EMPTY = (24, 24, 27), (225, 225, 228), (45, 45, 48)
_AXES = ((235, 60, 60), (70, 205, 80), (80, 130, 255))
_STATES = {"visible": (80, 225, 95), "through_glass": (70, 190, 255), "occluded": (240, 75, 65)}
_COLUMNS = ("left", "depth Z", "normals", "instances", "boxes, axes xyz", "keypoints")
#: Font sizes of an instance's number; the first that fits its region is used. The last is the smallest readable one.
_NUMBER_SIZES = (0.5, 0.42, 0.35, 0.3)
#: Radius of a keypoint's disc, and width of the dark ring around it [px].
_DISC, _RING = _CELL / 150, _CELL / 400
#: Height of a line of a legend [px], and colour around its discs, so that dark ones are seen.
_LINE, _RING_COLOUR = 16, (150, 150, 155)
#: Drawing coordinates carry this many fractional bits, so overlays are not rounded to pixels.
_SHIFT = 4


@dataclass(frozen=True, eq=False)
class PreviewRow:
    """One view of the sheet."""

    name: str  #: caption, such as "000"
    picture: np.ndarray  #: (H, W, 3) uint8, the left picture
    camera: Camera
    geometry: Geometry
    labels: Labels
    sensor: SensorPreview | None = None
    stokes: np.ndarray | None = None  #: (H, W, 4, 3) float32, Stokes vectors


def chosen_views(count: int, limit: int = MAX_VIEWS) -> list[int]:
    """Return the views to show of ``count`` views: evenly spaced, with the first and the last."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, limit))})


def contact_sheet(title: str, rows: Sequence[PreviewRow]) -> np.ndarray:
    """Return the sheet of some views, (H, W, 3) uint8.

    Columns: left picture; depth over the objects' range, bright is near; normals (x red, up green, towards the camera
    blue); instances with their ids; oriented boxes with the axes of each pose; keypoints by visibility. Where a row has
    the depth of a sensor: that depth, in the colours of the true one, the difference of the two, why there is none, and
    the left infrared picture if it was written. Where it has Stokes vectors: degree of linear polarisation, and the
    angle as a hue. All rows have the columns of the first one.
    """
    more = [_reported(row) for row in rows]
    columns = (*_COLUMNS, *(cell.title for cell in more[0])) if rows else _COLUMNS
    bands = [_header(title, columns)]
    for row, reported in zip(rows, more, strict=True):
        cells = _cells(row)
        height = cells[0].shape[0]
        band = np.full((height + _GAP, _left(len(columns)), 3), _BACKGROUND, np.uint8)
        _text(band, row.name, (10, height // 2 + 5))
        for column, cell in enumerate([*cells, *(_shown(one, height) for one in reported)]):
            band[:height, _left(column) : _left(column) + _CELL] = cell
        bands.append(band)
    return np.concatenate(bands)


def _reported(row: PreviewRow) -> list[Cell]:
    """Return what cameras beside the colour cameras report of a view."""
    found = [] if row.sensor is None else sensor_cells(row.geometry, row.sensor)
    return found + ([] if row.stokes is None else stokes_cells(row.stokes))


def _shown(cell: Cell, height: int) -> np.ndarray:
    """Return a cell at the sheet's size; pictures of another shape are cut or stand on the background."""
    picture = _resized(cell.picture, _CELL / cell.picture.shape[1], smooth=cell.smooth)[:height]
    if cell.tag:
        _tag(picture, cell.tag)
    if cell.legend:
        _draw_legend(picture, cell.legend)
    return np.concatenate([picture, np.full((height - len(picture), _CELL, 3), _BACKGROUND, np.uint8)])


def depth_caption(Z: np.ndarray, near: float, far: float) -> str:
    """Return the depths [m] of the ends of the colour range, with <= or >= where surfaces lie beyond."""
    hit = Z[np.isfinite(Z)]
    nearer, farther = (hit < near).any(), (hit > far).any()
    return f"{'<= ' if nearer else ''}{near:.2f} m to {'>= ' if farther else ''}{far:.2f} m"


def number_position(region: np.ndarray, width: int, height: int) -> tuple[tuple[int, int], bool]:
    """Return the position of the centre of a text in a region, (x, y), and whether the whole text lies inside.

    Of the positions where the text's rectangle is inside the region, it is the one farthest from the region's border;
    where the rectangle fits nowhere, the one farthest of all.

    Parameters
    ----------
    region : (H, W) bool
        With at least one pixel; the picture's edge is a border too.
    width, height : int
        Extent of the text [px].
    """
    inside = np.pad(region, 1).astype(np.uint8)
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    fitting = cv2.erode(inside, np.ones((height | 1, width | 1), np.uint8)) > 0
    fits = bool(fitting.any())
    y, x = np.unravel_index(np.argmax(np.where(fitting, distance, 0.0) if fits else distance), distance.shape)
    return (int(x) - 1, int(y) - 1), fits


def _cells(row: PreviewRow) -> list[np.ndarray]:
    geometry, camera = row.geometry, row.camera
    scale = _CELL / camera.width
    left = _resized(row.picture, scale, smooth=True)
    depth, (near, far) = depth_colours(geometry.Z, geometry.id)
    depth, ids = _resized(depth, scale), _resized(id_colours(geometry.id), scale)
    numbers = _resized(geometry.id, scale)
    _tag(depth, depth_caption(geometry.Z, near, far))
    # Overlays are easier to see on a darker picture.
    boxes, points = _dimmed(left), _dimmed(left)
    for label in row.labels.objects:
        _draw_id(ids, numbers == label.id, str(label.id))
        _draw_box(boxes, label, camera, scale)
    for label in row.labels.objects:
        _draw_axes(boxes, label, camera, scale)
        _draw_keypoints(points, label, scale)
    return [left, depth, _resized(normal_colours(geometry.normal), scale), ids, boxes, points]


def _header(title: str, columns: tuple[str, ...]) -> np.ndarray:
    band = np.full((2 * _CAPTION + 8, _left(len(columns)), 3), _BACKGROUND, np.uint8)
    _text(band, title, (10, 24), 0.6)
    for column, caption in enumerate(columns):
        _text(band, caption, (_left(column) + 2, _CAPTION + 28))
    x = _left(len(_COLUMNS) - 1) + 90
    for state, colour in _STATES.items():
        _disc(band, (x << _SHIFT, (_CAPTION + 23) << _SHIFT), 2.0 * _DISC, colour)
        x = _text(band, {"through_glass": "glass"}.get(state, state), (x + 8, _CAPTION + 28), 0.4) + 10
    return band


def _draw_id(picture: np.ndarray, region: np.ndarray, text: str) -> None:
    """Write a number inside a region, (H, W) bool, as large as fits; nothing where it would cover the region."""
    for size in _NUMBER_SIZES:
        (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, 1)
        if np.count_nonzero(region) < width * height:
            continue
        (x, y), fits = number_position(region, width, height)
        if fits or size == _NUMBER_SIZES[-1]:
            _text(picture, text, (x - width // 2, y + height // 2), size, (20, 20, 20))
            return


def _draw_box(picture: np.ndarray, label: ObjectLabel, camera: Camera, scale: float) -> None:
    pixels, Z = project_camera(np.array(label.box3d), camera.K)
    if (Z <= 0.0).any():
        return
    for a, b in EDGES:
        _line(picture, pixels[a], pixels[b], scale, id_colour(label.id), 1)


def _draw_axes(picture: np.ndarray, label: ObjectLabel, camera: Camera, scale: float) -> None:
    corners = np.array(label.box3d)
    length = 0.5 * np.linalg.norm(corners[7] - corners[0]) / np.sqrt(3.0)
    ends = label.camera_T_object[:3, 3] + length * np.vstack([np.zeros(3), label.camera_T_object[:3, :3].T])
    pixels, Z = project_camera(ends, camera.K)
    if (Z <= 0.0).any():
        return
    for axis, colour in enumerate(_AXES):
        _line(picture, pixels[0], pixels[1 + axis], scale, colour, 2)


def _draw_keypoints(picture: np.ndarray, label: ObjectLabel, scale: float) -> None:
    for point in label.keypoints:
        if point.pixel is None or point.state == "outside":
            continue
        centre = _fixed(point.pixel, scale)
        _disc(picture, centre, _DISC + _RING, (15, 15, 15))
        _disc(picture, centre, _DISC, _STATES[point.state])


def _disc(picture: np.ndarray, centre: tuple[int, int], radius: float, colour: tuple[int, ...]) -> None:
    # OpenCV draws circles of less than three pixels as squares on their corners.
    angles = np.arange(24) * (np.pi / 12)
    outline = centre + (radius * (1 << _SHIFT)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cv2.fillConvexPoly(picture, np.rint(outline).astype(np.int32), colour, cv2.LINE_AA, _SHIFT)


def _line(
    picture: np.ndarray, start: np.ndarray, end: np.ndarray, scale: float, colour: tuple[int, ...], width: int
) -> None:
    cv2.line(picture, _fixed(start, scale), _fixed(end, scale), colour, width, cv2.LINE_AA, _SHIFT)


def _fixed(pixel: np.ndarray | tuple[float, float], scale: float) -> tuple[int, int]:
    """Return an image coordinate in a picture of another size, as fixed point with `_SHIFT` fractional bits.

    Pixel edges, not centres, are scaled: ``u' + 0.5 = (u + 0.5) scale``.
    """
    # OpenCV overflows far outside the picture.
    limit = 1 << 14
    x, y = (max(-limit, min(limit, (float(value) + 0.5) * scale - 0.5)) for value in pixel)
    return round(x * (1 << _SHIFT)), round(y * (1 << _SHIFT))


def _resized(picture: np.ndarray, scale: float, smooth: bool = False) -> np.ndarray:
    """Return a picture resized to the cells' width; label images are never interpolated."""
    blend = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
    height = max(1, round(picture.shape[0] * scale))
    return cv2.resize(picture, (_CELL, height), interpolation=blend if smooth else cv2.INTER_NEAREST)


def _dimmed(picture: np.ndarray) -> np.ndarray:
    return (picture * 0.75).astype(np.uint8)


def _tag(picture: np.ndarray, text: str) -> None:
    """Write in the lower left corner, on a dark background."""
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.42, 1)
    bottom = picture.shape[0]
    picture[max(0, bottom - height - 12) :, : width + 12] = _BACKGROUND
    _text(picture, text, (6, bottom - 7), 0.42)


def _draw_legend(picture: np.ndarray, legend: tuple[tuple[str, tuple[int, int, int]], ...]) -> None:
    """Write names with the discs of their colours in the lower left corner, from the bottom upwards."""
    for line, (name, colour) in enumerate(legend[: (len(picture) - 8) // _LINE]):
        (width, _), _ = cv2.getTextSize(name, cv2.FONT_HERSHEY_SIMPLEX, 0.4, 1)
        bottom = len(picture) - line * _LINE
        picture[bottom - _LINE : bottom, : width + 26] = _BACKGROUND
        _disc(picture, (10 << _SHIFT, (bottom - 8) << _SHIFT), 2.0 * _DISC, _RING_COLOUR)
        _disc(picture, (10 << _SHIFT, (bottom - 8) << _SHIFT), 1.6 * _DISC, colour)
        _text(picture, name, (20, bottom - 4), 0.4)


def _text(
    picture: np.ndarray, text: str, at: tuple[int, int], size: float = 0.48, colour: tuple[int, ...] = _TEXT_COLOUR
) -> int:
    """Write text whose baseline starts at a point; return the x coordinate of its end."""
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
    return at[0] + cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, 1)[0][0]


def _left(column: int) -> int:
    return _GUTTER + column * (_CELL + _GAP)
