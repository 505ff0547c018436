"""What the index says of depth and polarisation cameras, against their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..format import layout
from ..format.sensor_files import read_numbers
from ..format.views_table import ViewRow
from ..stored_view import StoredView
from .fault import Fault, unlike

#: Errors of a depth that is right, and of one that is in front or behind [m]; width of a rim [px]; fewest pixels of an
#: object with numbers [1]: as docs/format.md states them.
_RIGHT, _FAR, _RIM, _FEWEST = 0.010, 0.020, 7, 100
#: Sums of doubles, of up to some millions of pixels [1].
EXACT = 1e-9
#: Rounding of halves in a degree of polarisation [1].
ROUNDING = 1e-3
#: Weights of linear Rec.709 in luminance (ITU-R BT.709-6).
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: The numbers of an object, in this order.
_NUMBERS = ("missing", "right", "behind", "front", "rim")


def sensor_row_faults(row: ViewRow, view: StoredView) -> list[Fault]:
    """Compare a view's row of the index with the files of its depth and polarisation cameras.

    Rows of earlier versions lack some of the fields.
    """
    record, stored = view.camera_record(), view.instances()
    masks = [stored == number for number in row.object_ids]
    found = _path_faults(row, view.folder)
    if record.depth_camera is not None and row.sensor_depth is not None:
        found += _depth_faults(row, view, masks, len(record.depth_camera.reasons))
    if record.polarisation_camera is not None and row.stokes is not None:
        found += _degree_faults(row, view, masks)
    return found


def _path_faults(row: ViewRow, folder: Path) -> list[Fault]:
    """Check that a path is that of a file of this view."""
    found: list[Fault] = []
    files = (layout.SENSOR_DEPTH, layout.SENSOR_VALID, layout.IR_LEFT, layout.IR_RIGHT, layout.STOKES)
    for name in files:
        stored = getattr(row, Path(name).stem)
        there = f"{row.path}/{name}" if (folder / name).is_file() else None
        if stored is not None or name in (layout.SENSOR_DEPTH, layout.STOKES):
            found += unlike("index", layout.SCENE_VIEWS, f"view {row.view} {Path(name).stem}", there, stored)
    return found


def _depth_faults(row: ViewRow, view: StoredView, masks: list[np.ndarray], reasons: int) -> list[Fault]:
    reported, Z = view.sensor_depth().astype(np.float64), view.depth()
    numbers = np.array([_numbers(reported, Z, mask) for mask in masks]).reshape(-1, len(_NUMBERS))
    expected: dict[str, object] = {"sensor_measured": 1.0 - np.isnan(reported).mean()}
    if row.sensor_reasons is not None:
        reason = read_numbers(view.folder / layout.SENSOR_VALID)
        expected["sensor_reasons"] = [float((reason == number).mean()) for number in range(reasons)]
    expected |= {f"sensor_{name}": numbers[:, k] for k, name in enumerate(_NUMBERS)}
    return _unlike_fields(row, expected, EXACT)


def _numbers(reported: np.ndarray, Z: np.ndarray, mask: np.ndarray) -> list[float]:
    """Return the numbers of an object; NaN for those that it has not."""
    if mask.sum() < _FEWEST:
        return [np.nan] * len(_NUMBERS)
    missing = np.isnan(reported)
    seen = mask & ~missing & np.isfinite(Z)
    # As the index does: both as they are stored.
    error = reported[seen].astype(np.float32) - Z[seen]
    parts = [np.abs(error) <= _RIGHT, error > _FAR, error < -_FAR]
    inside = _inside(mask)
    rim, inner = (missing[part].mean() if part.any() else np.nan for part in (mask & ~inside, inside))
    fractions = [float(part.mean()) if part.size else np.nan for part in parts]
    return [float(missing[mask].mean()), *fractions, float(rim / inner) if inner > 0.0 else np.nan]


def _inside(mask: np.ndarray) -> np.ndarray:
    """Return the pixels whose square of `_RIM` px on each side, as far as it is in the picture, is in a mask."""
    sums = np.pad(mask.astype(np.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    (top, bottom), (left, right) = (_ends(side) for side in mask.shape)
    counts = sums[bottom][:, right] - sums[top][:, right] - sums[bottom][:, left] + sums[top][:, left]
    return counts == np.outer(bottom - top, right - left)


def _ends(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where the window of each pixel begins and ends along a side of the picture."""
    places = np.arange(side)
    return np.maximum(places - _RIM, 0), np.minimum(places + _RIM + 1, side)


def _degree_faults(row: ViewRow, view: StoredView, masks: list[np.ndarray]) -> list[Fault]:
    light = view.stokes().vector.astype(np.float64) @ _LUMINANCE
    with np.errstate(divide="ignore", invalid="ignore"):
        degree = np.nan_to_num(np.hypot(light[..., 1], light[..., 2]) / light[..., 0])
    medians = [float(np.median(degree[mask])) if mask.sum() >= _FEWEST else np.nan for mask in masks]
    return _unlike_fields(row, {"polarisation_degree": medians}, ROUNDING)


def _unlike_fields(row: ViewRow, expected: dict[str, object], tolerance: float) -> list[Fault]:
    """Return a fault for each field that differs; null is NaN."""
    found: list[Fault] = []
    for name, value in expected.items():
        stored = np.array(getattr(row, name), np.float64)  # None is NaN
        found += unlike("index", layout.SCENE_VIEWS, f"view {row.view} {name}", np.array(value), stored, tolerance)
    return found
