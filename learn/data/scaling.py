"""Resizing of images, cameras and ground truth to the size of a network, and of its predictions back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from ..targets.objects import ViewObject
from .ground_truth import GroundTruth
from .views import CameraView

FitRule = Literal["letterbox", "stretch"]
#: Value of pixels beside a picture of another shape: the middle of the range, about where networks have their mean.
BORDER = 128

_Size = tuple[int, int]


@dataclass(frozen=True)
class Fit:
    """Where a picture lies in one of another size; sizes are height and width [px]."""

    old: _Size
    inner: _Size  #: of the picture in the new one
    new: _Size
    top: int
    left: int

    @property
    def inside(self) -> tuple[slice, slice]:
        """The rows and columns of the new picture that show the old one."""
        (height, width), top, left = self.inner, self.top, self.left
        return slice(top, top + height), slice(left, left + width)


def fitted(old: _Size, new: _Size | None, rule: FitRule = "letterbox") -> Fit:
    """Return how a picture is put into another size.

    Parameters
    ----------
    old : (int, int)
        Height and width [px].
    new : (int, int), optional
        Those wanted; None keeps the old ones.
    rule : str
        ``letterbox``: as large as possible at its own shape, in the middle, with a grey border; ``stretch``: all of the
        new picture, whose pixels then have another aspect ratio.
    """
    if new is None or rule == "stretch":
        return Fit(old, new or old, new or old, 0, 0)
    scale = min(after / before for before, after in zip(old, new, strict=True))
    height, width = (max(1, min(after, round(scale * before))) for before, after in zip(old, new, strict=True))
    return Fit(old, (height, width), new, (new[0] - height) // 2, (new[1] - width) // 2)


def scaled_view(view: CameraView, size: _Size | None, rule: FitRule = "letterbox") -> CameraView:
    """Return a view at another size; its camera keeps the field of view.

    Images are reduced by averaging over the area of each new pixel, and enlarged by bilinear interpolation.

    Parameters
    ----------
    view : CameraView
        The view.
    size, rule : (int, int), str
        As in `fitted`.
    """
    fit = fitted((view.picture.shape[0], view.picture.shape[1]), size, rule)
    if fit.old == fit.new:
        return view
    inner = _resized(view.picture, fit.inner)
    picture = inner
    if fit.inner != fit.new:
        picture = np.full((*fit.new, 3), BORDER, np.uint8)
        picture[fit.inside] = inner
    return CameraView(picture, view.world_T_camera, fitted_K(view.K, fit))


def fitted_K(K: np.ndarray, fit: Fit) -> np.ndarray:
    """Return the intrinsic matrix of a picture put into another one."""
    moved = scaled_K(K, fit.old, fit.inner)
    return np.array([[1.0, 0.0, fit.left], [0.0, 1.0, fit.top], [0.0, 0.0, 1.0]]) @ moved


def scaled_K(K: np.ndarray, old: _Size, new: _Size) -> np.ndarray:
    """Return the intrinsic matrix of a resized image.

    Pixel (0, 0) has its centre at (0, 0), so its outer corner (-1/2, -1/2) is the fixed point: u' = s (u + 1/2) - 1/2
    with the scale s.

    Parameters
    ----------
    K : (3, 3) float
        Intrinsic matrix [px].
    old, new : (int, int)
        Height and width before and after [px].
    """
    across, down = new[1] / old[1], new[0] / old[0]
    scale = np.array([[across, 0.0, (across - 1.0) / 2.0], [0.0, down, (down - 1.0) / 2.0], [0.0, 0.0, 1.0]])
    return scale @ K


def scaled_ground_truth(labels: GroundTruth, size: _Size | None, rule: FitRule = "letterbox") -> GroundTruth:
    """Return ground truth at another size, by nearest neighbour: depths and ids are never averaged.

    A border has no surface: the id 0 and infinite depth.
    """
    fit = fitted((labels.Z.shape[0], labels.Z.shape[1]), size, rule)
    if fit.old == fit.new:
        return labels
    instances, Z = (_fitted_values(values, fit, empty) for values, empty in ((labels.instances, 0), (labels.Z, np.inf)))
    return replace(labels, instances=instances, Z=Z, objects=tuple(_recounted(o, instances) for o in labels.objects))


def scaled_depth(depth: np.ndarray, size: _Size | None, rule: FitRule = "letterbox") -> np.ndarray:
    """Return measured depth at another size, by nearest neighbour, (H, W) [m]; 0 where it is unknown or beside it."""
    known = np.where(np.isfinite(depth), depth, 0.0)
    fit = fitted((depth.shape[0], depth.shape[1]), size, rule)
    return known if fit.old == fit.new else _fitted_values(known, fit, 0.0)


def restored(values: np.ndarray, fit: Fit) -> np.ndarray:
    """Return maps (..., H', W') of a network at the size of the stored picture, by nearest neighbour, (..., H, W)."""
    rows, columns = (_nearest(before, after) for before, after in zip(fit.inner, fit.old, strict=True))
    return np.ascontiguousarray(values[(..., *fit.inside)][..., rows[:, None], columns])


def restored_points(points: np.ndarray, fit: Fit) -> np.ndarray:
    """Return image coordinates (x, y), (..., 2), of a network in the stored picture [px]."""
    scale = np.array([fit.old[1] / fit.inner[1], fit.old[0] / fit.inner[0]])
    return (points - np.array([fit.left, fit.top]) + 0.5) * scale - 0.5


def _resized(picture: np.ndarray, size: _Size) -> np.ndarray:
    height, width = size
    if size == picture.shape[:2]:
        return picture
    shrinks = height <= picture.shape[0] and width <= picture.shape[1]
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    # In floating point, because OpenCV's interpolation of bytes has errors of up to 0.7.
    return np.rint(cv2.resize(picture.astype(np.float32), (width, height), interpolation=method)).astype(np.uint8)


def _fitted_values(values: np.ndarray, fit: Fit, empty: float) -> np.ndarray:
    rows, columns = (_nearest(before, after) for before, after in zip(fit.old, fit.inner, strict=True))
    found = np.full(fit.new, empty, values.dtype)
    found[fit.inside] = values[rows][:, columns]
    return found


def _nearest(before: int, after: int) -> np.ndarray:
    """Return the old pixel that contains the centre of each new pixel; on an edge the second of both."""
    return (2 * np.arange(after) + 1) * before // (2 * after)


def _recounted(item: ViewObject, instances: np.ndarray) -> ViewObject:
    return replace(item, visible=int((instances == item.id).sum()))
