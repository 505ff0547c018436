"""Augmentation that moves pixels: mirror images, and windows of pictures; cameras and labels follow exactly.

All views of a sample are changed in the same way, so that their epipolar geometry stays what their cameras say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...annotate.symmetries import Symmetry
from ..targets.objects import ViewObject
from .ground_truth import GroundTruth
from .settings import AugmentSettings
from .views import CameraView
from .windows import Window, cut, cut_labels

#: The mirror of the camera's and of the world's x axis.
_MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
#: An object's frame is mirrored along y: its z axis stays up, and its x axis towards the camera.
_OBJECT_MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def moved_pixels(
    views: Sequence[CameraView], labels: GroundTruth, settings: AugmentSettings, rng: np.random.Generator
) -> tuple[list[CameraView], GroundTruth]:
    """Return the views of a sample and the labels of the first one, mirrored or cut to a window by chance.

    Parameters
    ----------
    views : sequence of CameraView
        Of the same size.
    labels : GroundTruth
        Of the first view, at its size.
    settings : AugmentSettings
        `flip` is the probability of a mirror image, `zoom` the range of the picture's width over the window's.
    rng : numpy.random.Generator
        Random generator.
    """
    found = list(views)
    if rng.uniform() < settings.flip:
        found, labels = [mirrored_view(view) for view in found], mirrored_labels(labels)
    zoom, down, across = rng.uniform(*settings.zoom), *rng.uniform(size=2)
    height, width = found[0].picture.shape[:2]
    size = max(1, round(height / zoom)), max(1, round(width / zoom))
    top, left = round(down * (height - size[0])), round(across * (width - size[1]))
    window = Window(slice(top, top + size[0]), slice(left, left + size[1]))
    return [cut(view, window) for view in found], cut_labels(labels, window)


def mirrored_view(view: CameraView) -> CameraView:
    """Return the mirror image of a view, left to right, in the mirrored world: x of world and camera change sign.

    A point (x, y, z) at column u is then (-x, y, z) at column W - 1 - u, so K's skew changes sign and its principal
    point is W - 1 - cx.
    """
    K = view.K.copy()
    K[0, 1], K[0, 2] = -K[0, 1], view.picture.shape[1] - 1 - K[0, 2]
    return CameraView(np.ascontiguousarray(view.picture[:, ::-1]), _MIRROR @ view.world_T_camera @ _MIRROR, K)


def mirrored_labels(labels: GroundTruth) -> GroundTruth:
    """Return the labels of the mirror image of a view; objects are mirrored along the y axis of their frames."""
    keypoints, surface = (
        {number: points * [1.0, -1.0, 1.0] for number, points in group.items()}
        for group in (labels.keypoints, labels.surface)
    )
    return GroundTruth(
        instances=np.ascontiguousarray(labels.instances[:, ::-1]),
        Z=np.ascontiguousarray(labels.Z[:, ::-1]),
        objects=tuple(_mirrored_object(item) for item in labels.objects),
        keypoints=keypoints,
        surface=surface,
    )


def _mirrored_object(item: ViewObject) -> ViewObject:
    motions = _OBJECT_MIRROR @ item.symmetry.motions @ _OBJECT_MIRROR
    return replace(
        item,
        camera_T_object=_MIRROR @ item.camera_T_object @ _OBJECT_MIRROR,
        symmetry=Symmetry(turns=item.symmetry.turns, ball=item.symmetry.ball, motions=motions),
    )
