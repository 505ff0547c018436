"""A contact sheet of another project's data set: a row per view, with its pictures, depths, masks, boxes, keypoints."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ...annotate.boxes import EDGES, box_corners
from ...annotate.projection import project_camera, transformed
from ...core.images import depth_colours, id_colour, id_colours, normal_colours
from ..preview.contact_sheet import depth_caption
from ..readers.source_view import SourceObject, SourceView

#: Width of a picture, gap, height of a line of captions [px].
_CELL, _GAP, _LINE = 320, 6, 22
_BACKGROUND, _TEXT, _EMPTY = (24, 24, 27), (225, 225, 228), (45, 45, 48)
_COLUMNS = ("left", "right", "depth", "sensor depth", "normals", "instances or classes", "boxes, keypoints")
_KEYPOINT = (80, 225, 95)
#: Drawing coordinates carry this many fractional bits.
_SHIFT = 4


def source_sheet(title: str, views: Sequence[tuple[str, SourceView]]) -> np.ndarray:
    """Return the sheet of some views with their names, (H, W, 3) uint8; a column that none of them has is left out."""
    rows = [(name, _cells(view)) for name, view in views]
    shown = [column for column in _COLUMNS if any(cells[column] is not None for _, cells in rows)]
    width = len(shown) * (_CELL + _GAP) + _GAP
    bands = [_captions(width, [(title, _GAP)]), _captions(width, [(name, _left(i)) for i, name in enumerate(shown)])]
    for name, cells in rows:
        height = max(cell.shape[0] for cell in cells.values() if cell is not None)
        band = np.full((height + _GAP, width, 3), _BACKGROUND, np.uint8)
        for number, column in enumerate(shown):
            cell = cells[column]
            place = band[:height, _left(number) : _left(number) + _CELL]
            place[:] = _EMPTY
            if cell is not None:
                place[: cell.shape[0]] = cell
            else:
                _write(place, "none", (_CELL // 2 - 20, height // 2))
        bands += [_captions(width, [(name, _GAP)]), band]
    return np.concatenate(bands)


def _cells(view: SourceView) -> dict[str, np.ndarray | None]:
    left = _small(view.picture)
    ids = view.instances if view.instances is not None else view.classes
    found: dict[str, np.ndarray | None] = dict.fromkeys(_COLUMNS)
    found |= {
        "left": left,
        "right": None if view.right is None else _small(view.right),
        "depth": _depth(view.Z, ids),
        "sensor depth": _depth(view.sensor_Z, ids),
        "normals": None if view.normals is None else _small(normal_colours(np.nan_to_num(view.normals)), False),
        "instances or classes": None if ids is None else _small(id_colours(ids), False),
    }
    drawable = [item for item in view.objects or () if item.keypoints is not None or item.size is not None]
    if drawable and view.camera.K is not None:
        picture = (left * 0.75).astype(np.uint8)
        for item in drawable:
            _draw(picture, item, view.camera.K, _CELL / view.picture.shape[1])
        found["boxes, keypoints"] = picture
    return found


def _depth(Z: np.ndarray | None, ids: np.ndarray | None) -> np.ndarray | None:
    if Z is None:
        return None
    known = np.where(np.isnan(Z), np.inf, Z)
    marked = np.zeros(Z.shape, np.uint16) if ids is None else ids.astype(np.uint16)
    colours, (near, far) = depth_colours(known, marked)
    cell = _small(colours, False)
    _write(cell, depth_caption(known, near, far), (6, cell.shape[0] - 8))
    return cell


def _draw(picture: np.ndarray, item: SourceObject, K: np.ndarray, scale: float) -> None:
    if item.camera_T_object is not None and item.size is not None:
        pixels, Z = project_camera(transformed(item.camera_T_object, box_corners(tuple(item.size))), K)
        if (Z > 0.0).all():
            for a, b in EDGES:
                ends = [_fixed(pixels[corner], scale) for corner in (a, b)]
                cv2.line(picture, ends[0], ends[1], id_colour(item.id), 1, cv2.LINE_AA, _SHIFT)
    if item.keypoints is not None:
        for pixel in item.keypoints.pixels:
            cv2.circle(picture, _fixed(pixel, scale), 3 << _SHIFT, _KEYPOINT, -1, cv2.LINE_AA, _SHIFT)


def _fixed(pixel: np.ndarray, scale: float) -> tuple[int, int]:
    """Return an image coordinate in the small picture, as fixed point; edges are scaled, and not centres."""
    x, y = np.clip((pixel + 0.5) * scale - 0.5, -(1 << 14), 1 << 14)
    return round(float(x) * (1 << _SHIFT)), round(float(y) * (1 << _SHIFT))


def _small(picture: np.ndarray, smooth: bool = True) -> np.ndarray:
    """Return a picture at the width of the cells; label images are never interpolated."""
    height = max(1, round(picture.shape[0] * _CELL / picture.shape[1]))
    blend = cv2.INTER_AREA if picture.shape[1] > _CELL else cv2.INTER_CUBIC
    return cv2.resize(picture, (_CELL, height), interpolation=blend if smooth else cv2.INTER_NEAREST)


def _captions(width: int, texts: Sequence[tuple[str, int]]) -> np.ndarray:
    band = np.full((_LINE, width, 3), _BACKGROUND, np.uint8)
    for text, left in texts:
        _write(band, text, (left, _LINE - 7))
    return band


def _write(picture: np.ndarray, text: str, at: tuple[int, int]) -> None:
    shown = text.encode("ascii", "replace").decode()
    cv2.putText(picture, shown, at, cv2.FONT_HERSHEY_SIMPLEX, 0.44, _TEXT, 1, cv2.LINE_AA)


def _left(column: int) -> int:
    return _GAP + column * (_CELL + _GAP)
