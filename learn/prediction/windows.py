"""Windows of a picture, at the focal length that a network was trained for, and what is found in all of them.

A network that was trained on one focal length sees things of a wide lens too small, and takes them for farther ones.
Windows of the picture, enlarged to that focal length, show them as the network knows them; each keeps its K.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data.scaling import FitRule, fitted, fitted_K
from ..data.windows import Window, whole_picture

#: Focal length of training over that of the whole picture at the network's size, from which windows are taken: the
#: augmentation of training enlarges pictures by up to 1.3.
_WIDE = 1.25
#: Least part of a window that overlaps with the next one: what is cut by one border is whole in the next window.
_OVERLAP = 0.5
#: Most windows along a side. Those of wider pictures are larger, at a shorter focal length than that of training:
#: things are so small there that enlarging does not show them.
_MOST = 6
#: Sides of a window that so many cover along a side of the picture.
_REACH = 1.0 + (_MOST - 1) * (1.0 - _OVERLAP)
#: Part of a window, from its borders inwards, in which objects count less, and by which factor at most: they are cut.
_EDGE, _CUT = 0.12, 0.4

_Size = tuple[int, int]


def windows(size: _Size, K: np.ndarray, network: _Size | None, focal: float | None, rule: FitRule) -> list[Window]:
    """Return the windows of a picture, row by row: all of it where its focal length is about that of training.

    Parameters
    ----------
    size : (int, int)
        Height and width of the picture [px].
    K : (3, 3) float
        Its intrinsic matrix [px].
    network : (int, int), optional
        Height and width at which the network was trained [px]; None: as pictures are stored.
    focal : float, optional
        Focal length of training at that size [px]; None where it is not known.
    rule : str
        How pictures are put into that size (`data.scaling.fitted`).
    """
    if network is None or focal is None:
        return [whole_picture(size)]
    if focal < _WIDE * fitted_K(K, fitted(size, network, rule))[0, 0]:
        return [whole_picture(size)]
    # Side of a window in pixels of the picture: it shows the field of view that training pictures have.
    wanted = [(side, part * K[axis, axis] / focal) for axis, side, part in _axes(size, network)]
    larger = max(1.0, *(side / (_REACH * part) for side, part in wanted))
    sides = [min(side, math.ceil(larger * part)) for side, part in wanted]
    rows, columns = (_pieces(whole_side, part) for whole_side, part in zip(size, sides, strict=True))
    return [Window(row, column) for row in rows for column in columns]


def _axes(size: _Size, network: _Size) -> list[tuple[int, int, int]]:
    return [(1, size[0], network[0]), (0, size[1], network[1])]


def _pieces(side: int, part: int) -> list[slice]:
    """Return evenly spaced parts of a side, which overlap."""
    if part >= side:
        return [slice(0, side)]
    count = 1 + math.ceil((side - part) / ((1.0 - _OVERLAP) * part))
    return [slice(start, start + part) for start in np.rint(np.linspace(0, side - part, count)).astype(int).tolist()]


@dataclass(frozen=True, eq=False)
class Found:
    """What a network finds in a picture, as arrays; objects by descending score."""

    depth: np.ndarray  #: (H, W) float32 [m]; NaN where nothing was looked at
    score: np.ndarray  #: (n,) float64, 0 to 1
    transparent: np.ndarray  #: (n,) bool: most pixels of the object are of glass or the like
    camera_T_object: np.ndarray  #: (n, 4, 4) float64 [m]
    size: np.ndarray  #: (n, 3) float64 [m]
    mask: np.ndarray  #: (n, H, W) bool
    peak: np.ndarray  #: (n, 2) float64, (x, y) [px]

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.score)

    def chosen(self, rows: Sequence[int] | np.ndarray) -> Found:
        """Return some of the objects."""
        names = ("score", "transparent", "camera_T_object", "size", "mask", "peak")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def merged(size: _Size, parts: Sequence[tuple[Window, Found]]) -> Found:
    """Return what was found in windows of a picture as one: depth blended, objects that were found twice once.

    Parameters
    ----------
    size : (int, int)
        Height and width of the picture [px].
    parts : sequence of (Window, Found)
        In pixels of each window.
    """
    if len(parts) == 1 and parts[0][1].depth.shape == size:
        return parts[0][1]
    total, weights = np.zeros(size), np.zeros(size)
    for window, found in parts:
        height, width = found.depth.shape
        weight = np.minimum(_tent(height)[:, None], _tent(width))
        total[window.rows, window.columns] += weight * found.depth
        weights[window.rows, window.columns] += weight
    depth = np.where(weights > 0.0, total / np.where(weights > 0.0, weights, 1.0), np.nan).astype(np.float32)
    together = _together(size, depth, parts)
    rank = np.concatenate([found.score * _whole(window, found, size) for window, found in parts])
    kept = _once(together, np.argsort(-rank, kind="stable"))
    return together.chosen(np.array(sorted(kept, key=lambda row: -together.score[row]), int))


def _tent(count: int) -> np.ndarray:
    places = np.arange(count) + 0.5
    return np.minimum(places, count - places)


def _together(size: _Size, depth: np.ndarray, parts: Sequence[tuple[Window, Found]]) -> Found:
    mask = np.zeros((sum(len(found) for _, found in parts), *size), bool)
    start, peaks = 0, []
    for window, found in parts:
        mask[start : start + len(found), window.rows, window.columns] = found.mask
        peaks.append(found.peak + np.array([window.columns.start, window.rows.start]))
        start += len(found)
    joined = {
        name: np.concatenate([getattr(found, name) for _, found in parts])
        for name in ("score", "transparent", "camera_T_object", "size")
    }
    return Found(depth=depth, mask=mask, peak=np.concatenate(peaks), **joined)


def _whole(window: Window, found: Found, size: _Size) -> np.ndarray:
    """Return a factor on scores: less than 1 near those borders of a window beyond which the picture goes on."""
    factor = np.ones(len(found))
    for axis, (part, side) in enumerate(((window.columns, size[1]), (window.rows, size[0]))):
        place, length = found.peak[:, axis], part.stop - part.start
        for goes_on, distance in ((part.start > 0, place), (part.stop < side, length - 1 - place)):
            if goes_on:
                factor = np.minimum(factor, np.clip(distance / (_EDGE * length), _CUT, 1.0))
    return factor


def _once(found: Found, order: np.ndarray) -> list[int]:
    """Return the objects that are left of those that are one: their middles are nearer than half of their size."""
    kept: list[int] = []
    centre, reach = found.camera_T_object[:, :3, 3], 0.5 * found.size.max(axis=1, initial=0.0)
    for row in order.tolist():
        same = [
            other
            for other in kept
            if np.linalg.norm(centre[row] - centre[other]) < max(reach[row], reach[other])
            or _overlap(found.mask[row], found.mask[other]) > 0.5
        ]
        if not same:
            kept.append(row)
    return kept


def _overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Return the intersection of two masks over the smaller one."""
    least = min(one.sum(), other.sum())
    return float((one & other).sum() / least) if least else 0.0
