"""Pictures, cameras and labels at another size than they were stored in."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from ..targets.objects import ViewObject
from .ground_truth import Truth
from .views import CameraView


def scaled_view(view: CameraView, size: tuple[int, int] | None) -> CameraView:
    """Return a view at another size; its camera sees the same, with pixels of another shape where sides differ.

    The picture is averaged over the area of each new pixel where it shrinks, and interpolated where it grows.

    Parameters
    ----------
    view : CameraView
        The view.
    size : (int, int), optional
        Height and width [px]; None leaves it as it is.
    """
    if size is None or size == view.picture.shape[:2]:
        return view
    height, width = size
    shrinks = height <= view.picture.shape[0] and width <= view.picture.shape[1]
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    # In floating point, because OpenCV's interpolation of bytes is off by up to 0.7.
    picture = np.rint(cv2.resize(view.picture.astype(np.float32), (width, height), interpolation=method))
    picture = picture.astype(np.uint8)
    return CameraView(picture, view.world_T_camera, scaled_K(view.K, view.picture.shape[:2], size))


def scaled_K(K: np.ndarray, old: tuple[int, int], new: tuple[int, int]) -> np.ndarray:
    """Return the intrinsic matrix after a picture was scaled.

    Pixel (0, 0) has its centre at (0, 0), so its outer corner (-1/2, -1/2) is what stays: with the scale s,
    u' = s (u + 1/2) - 1/2.

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


def scaled_truth(truth: Truth, size: tuple[int, int] | None) -> Truth:
    """Return labels at another size: each new pixel has those of the old pixel that its centre lies in.

    Labels are never mixed: between two depths there is no surface, and between two objects no third.
    """
    old = truth.Z.shape
    if size is None or size == old:
        return truth
    rows, columns = (_nearest(before, after) for before, after in zip(old, size, strict=True))
    instances, Z = (np.ascontiguousarray(values[rows][:, columns]) for values in (truth.instances, truth.Z))
    return replace(truth, instances=instances, Z=Z, objects=tuple(_seen(item, instances) for item in truth.objects))


def _nearest(before: int, after: int) -> np.ndarray:
    """Return the old pixel that the centre of each new one lies in; of two as near, the second."""
    return (2 * np.arange(after) + 1) * before // (2 * after)


def _seen(item: ViewObject, instances: np.ndarray) -> ViewObject:
    return replace(item, visible=int((instances == item.id).sum()))
