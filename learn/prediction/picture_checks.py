"""Pictures that cannot be what they are said to be: dark ones, one eye twice, swapped eyes, pairs not rectified.

What two pictures say of their cameras is found by matching features (Lowe, "Distinctive Image Features from
Scale-Invariant Keypoints", IJCV 2004), and compared with the poses and intrinsic matrices that came with them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ...core.errors import InputError
from ..data.views import CameraView

#: Most that a picture is enlarged to the network's size [1]: beyond, it shows too little.
_LARGEST = 2.0
#: A picture is dark where all but a hundredth of its values are below this, of 255: the noise of sensors.
_DARK = 12.0
#: It is white where all but a hundredth are above this.
_WHITE = 250.0
#: It is blank where its values differ by less than this (standard deviation of a sensor's noise in good light).
_BLANK = 1.5
#: Width to which smaller pictures are enlarged, so that features have room, and that below which nothing is matched: a
#: pixel is more than what is asked for there [px].
_WIDTH, _LEAST_WIDTH = 640, 96
#: Contrast of features that are taken, a quarter of OpenCV's default: tables and walls have little.
_CONTRAST = 0.01
#: Ratio of the best to the second-best match (Lowe, figure 11).
_RATIO = 0.8
#: Matches from which something is said.
_LEAST_MATCHES = 12
#: Share of the picture's width that matches may lie beside the epipolar line, in the median: 3 px of 640.
_BESIDE = 3.0 / 640.0
#: Shift along the epipolar line from which a match says on which side it is [width]: 2 px of 640.
_SHIFTED = 2.0 / 640.0
#: Fraction of matches behind the cameras from which the eyes are swapped.
_BEHIND = 0.8
#: A pair is not rectified where at least the first fraction of its matches lie on a plane of distances from their
#: epipolar lines, and at most the second one on these lines. Wrong matches lie anywhere.
_ON_PLANE, _ON_LINES = 0.6, 0.3
#: Rounds of the fit of that plane, by least absolute distances (iteratively reweighted least squares).
_ROUNDS = 30


def check_large_enough(picture: np.ndarray, size: tuple[int, int] | None, where: Path | str) -> None:
    """Raise InputError for a picture that has to be enlarged too far to the (height, width) of a network."""
    height, width = picture.shape[:2]
    if size is not None and max(size[0] / height, size[1] / width) > _LARGEST:
        least = f"a picture of at least {math.ceil(size[1] / _LARGEST)} x {math.ceil(size[0] / _LARGEST)} px"
        raise InputError(where, least, f"{width} x {height} px")


def check_light(picture: np.ndarray, where: Path | str) -> None:
    """Raise InputError where a picture is dark, white or blank."""
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    low, high = np.percentile(grey, [1.0, 99.0])
    if high < _DARK:
        found = f"a dark one: 99 of 100 pixels are below {high + 1:.0f} of 255 (lens covered, exposure too short?)"
        raise InputError(where, "a picture in which something shows", found)
    if low > _WHITE:
        found = f"a white one: 99 of 100 pixels are above {low - 1:.0f} of 255 (exposure too long?)"
        raise InputError(where, "a picture in which something shows", found)
    if grey.std() < _BLANK:
        raise InputError(where, "a picture in which something shows", f"a blank one of about {grey.mean():.0f} of 255")


@dataclass(frozen=True, eq=False)
class Matches:
    """Features of a first picture found in a second one."""

    beside: np.ndarray  #: (n,) distance of each from its epipolar line, downwards [widths]
    at: np.ndarray  #: (n, 2) where each is in the second picture [widths]
    shift: np.ndarray  #: (n,) along the line, from the point at infinity towards nearer ones [widths]


def check_pair(views: Sequence[CameraView], paths: Sequence[Path | str]) -> None:
    """Refuse a pair of pictures that are one, are swapped, or do not fit their cameras.

    Parameters
    ----------
    views : 2 CameraView
        The pictures of pinhole cameras; the first is the reference.
    paths : 2 Path
        Their files, for the message.

    Raises
    ------
    InputError
        Saying what the matches show. Where there are too few, nothing is said.
    """
    first, second = views
    eye = Path(paths[0]).name
    if first.picture.shape == second.picture.shape and np.array_equal(first.picture, second.picture):
        raise InputError(paths[1], f"the picture of another camera than {eye}", "the same picture: one eye twice")
    width = first.picture.shape[1]
    if width < _LEAST_WIDTH:
        return
    found = matched(first, second)
    if len(found.shift) < _LEAST_MATCHES:
        return
    sided = found.shift[(np.abs(found.shift) > _SHIFTED) & (np.abs(found.beside) < _BESIDE)]
    behind = int((sided < 0.0).sum())
    if len(sided) >= _LEAST_MATCHES and behind > _BEHIND * len(sided):
        expected = f"the eyes in order, {eye} first from the camera on the left"
        raise InputError(paths[1], expected, f"them swapped: {behind} of {len(sided)} matched points lie behind them")
    plane = _plane(found)
    on_lines, on_plane = (float((np.abs(one) < _BESIDE).mean()) for one in (found.beside, found.beside - plane))
    if on_plane > _ON_PLANE and on_lines < _ON_LINES:
        middle = float(np.median(plane)) * width
        side = f"{abs(middle):.1f} px {'below' if middle > 0.0 else 'above'}"
        if abs(middle) < 0.5 * _BESIDE * width:
            side = f"up to {float(np.abs(plane).max()) * width:.1f} px beside"
        expected = f"the points of {eye} on the rows (epipolar lines) that the cameras give, as of a rectified pair"
        raise InputError(paths[1], expected, f"them {side} (--camera FILE takes a calibration)")


def _plane(found: Matches) -> np.ndarray:
    """Return the distances from the epipolar lines as a linear function of the place, (n,) [widths]."""
    sides = np.concatenate([found.at, np.ones((len(found.at), 1))], axis=1)
    weight = np.ones(len(sides))
    fitted = np.zeros(len(sides))
    for _ in range(_ROUNDS):
        root = np.sqrt(weight)
        fitted = sides @ np.linalg.lstsq(root[:, None] * sides, root * found.beside, rcond=None)[0]
        weight = 1.0 / np.maximum(np.abs(found.beside - fitted), 0.1 * _BESIDE)
    return fitted


def matched(first: CameraView, second: CameraView) -> Matches:
    """Return the features of one picture that are found in another, against the epipolar lines of their cameras.

    A point at infinity is seen in the second picture at K' R K^-1 p, and nearer ones farther towards the epipole
    K' t (Hartley & Zisserman, *Multiple View Geometry*, section 9.2).
    """
    points, others = _matched_points(first.picture, second.picture)
    if not len(points):
        return Matches(np.zeros(0), np.zeros((0, 2)), np.zeros(0))
    second_T_first = np.linalg.inv(second.world_T_camera) @ first.world_T_camera
    rays = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ np.linalg.inv(first.K).T
    far = rays @ second_T_first[:3, :3].T @ second.K.T
    towards = second.K @ second_T_first[:3, 3]
    far_px = far[:, :2] / far[:, 2:]
    # Direction in which a point moves as it comes nearer: the derivative of its pixel by 1 / depth at infinity.
    along = (towards[:2] - far_px * towards[2]) / far[:, 2:]
    along = along / np.linalg.norm(along, axis=1, keepdims=True).clip(1e-12)
    moved = others - far_px
    width = second.picture.shape[1]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across = across * np.where(across[:, 1:] < 0.0, -1.0, 1.0)  # downwards
    return Matches((moved * across).sum(1) / width, others / width, (moved * along).sum(1) / width)


def _matched_points(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pixels of matched features, (n, 2) each: those that are each other's best match."""
    scale = max(1.0, _WIDTH / first.shape[1])
    detector = cv2.SIFT.create(contrastThreshold=_CONTRAST)
    found = []
    for picture in (first, second):
        grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        if scale > 1.0:
            grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        found.append(detector.detectAndCompute(grey, None))
    (points, features), (other_points, other_features) = found
    if features is None or other_features is None or min(len(features), len(other_features)) < 2:
        return np.zeros((0, 2)), np.zeros((0, 2))
    there, back = _best(features, other_features), _best(other_features, features)
    pairs = [(a, b) for a, b in there.items() if back.get(b) == a]
    if not pairs:
        return np.zeros((0, 2)), np.zeros((0, 2))
    where = [np.array([points[a].pt for a, _ in pairs]), np.array([other_points[b].pt for _, b in pairs])]
    first_points, second_points = ((one + 0.5) / scale - 0.5 for one in where)
    return first_points, second_points


def _best(features: np.ndarray, others: np.ndarray) -> dict[int, int]:
    matches = cv2.BFMatcher(cv2.NORM_L2).knnMatch(features, others, k=2)
    return {one.queryIdx: one.trainIdx for one, other in matches if one.distance < _RATIO * other.distance}
