"""Resizing of images, cameras and ground truth."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from ..targets.objects import ViewObject
from .ground_truth import GroundTruth
from .views import CameraView


def scaled_view(view: CameraView, size: tuple[int, int] | None) -> CameraView:
    """Return a view at another size; its camera keeps the field of view, so the aspect ratio of pixels may change.

    Images are reduced by averaging over the area of each new pixel, and enlarged by bilinear interpolation.

    Parameters
    ----------
    view : CameraView
        The view.
    size : (int, int), optional
        Height and width [px]; None keeps the stored size.
    """
    if size is None or size == view.picture.shape[:2]:
        return view
    height, width = size
    shrinks = height <= view.picture.shape[0] and width <= view.picture.shape[1]
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    # In floating point, because OpenCV's interpolation of bytes has errors of up to 0.7.
    picture = np.rint(cv2.resize(view.picture.astype(np.float32), (width, height), interpolation=method))
    picture = picture.astype(np.uint8)
    return CameraView(picture, view.world_T_camera, scaled_K(view.K, view.picture.shape[:2], size))


def scaled_K(K: np.ndarray, old: tuple[int, int], new: tuple[int, int]) -> np.ndarray:
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


def scaled_ground_truth(labels: GroundTruth, size: tuple[int, int] | None) -> GroundTruth:
    """Return ground truth at another size, by nearest neighbour: depths and ids are never averaged."""
    old = labels.Z.shape
    if size is None or size == old:
        return labels
    rows, columns = (_nearest(before, after) for before, after in zip(old, size, strict=True))
    instances, Z = (np.ascontiguousarray(values[rows][:, columns]) for values in (labels.instances, labels.Z))
    return replace(labels, instances=instances, Z=Z, objects=tuple(_recounted(o, instances) for o in labels.objects))


def _nearest(before: int, after: int) -> np.ndarray:
    """Return the old pixel that contains the centre of each new pixel; on an edge the second of both."""
    return (2 * np.arange(after) + 1) * before // (2 * after)


def _recounted(item: ViewObject, instances: np.ndarray) -> ViewObject:
    return replace(item, visible=int((instances == item.id).sum()))
