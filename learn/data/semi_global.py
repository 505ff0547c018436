"""Depth of a stereo pair by semi-global matching: what needs no training.

(Hirschmüller, "Stereo Processing by Semiglobal Matching and Mutual Information", PAMI 2008, with the block matching
cost of OpenCV.)
"""

from __future__ import annotations

import cv2
import numpy as np

from .views import CameraView

#: Side of the blocks that are compared [px].
_BLOCK = 5
#: Costs of a change of disparity by one pixel, and by more, for each of the block's values (OpenCV's example).
_SMALL_CHANGE, _LARGE_CHANGE = 8, 32
#: Nearest depth that is looked for, as a multiple of focal length times baseline over the width: a disparity of a
#: third of the picture.
_MOST_DISPARITY = 1.0 / 3.0
#: Disparities are found in steps of 1/16 px, and their number is a multiple of 16.
_STEP = 16
#: How much better the best match is than any other [%]; greatest difference of both directions [px]; smallest speckle
#: that is kept [px^2] and the change of disparity within it [px].
_UNIQUE, _BOTH_WAYS, _SPECKLE, _SPECKLE_RANGE = 5, 1, 30, 2


def semi_global_depth(left: CameraView, right: CameraView) -> np.ndarray:
    """Return the depth of the left picture of a rectified pair, (H, W) float32 [m]; 0 where no match was found.

    Glass has no colours of its own, so what is matched is what is seen through it, as with a stereo camera.
    """
    # That of an infinitely far point: less than 0 where principal points are moved apart, for pictures that were wider.
    least = round(float(left.K[0, 2] - right.K[0, 2]))
    width = left.picture.shape[1] + max(-least, 0)
    most = max(_STEP, int(width * _MOST_DISPARITY) // _STEP * _STEP)
    matcher = cv2.StereoSGBM.create(
        minDisparity=least,
        numDisparities=most,
        blockSize=_BLOCK,
        P1=_SMALL_CHANGE * 3 * _BLOCK**2,
        P2=_LARGE_CHANGE * 3 * _BLOCK**2,
        disp12MaxDiff=_BOTH_WAYS,
        uniquenessRatio=_UNIQUE,
        speckleWindowSize=_SPECKLE,
        speckleRange=_SPECKLE_RANGE,
        mode=cv2.STEREO_SGBM_MODE_SGBM,
    )
    # Beside the picture there is nothing to match: a border lets the first columns have all disparities.
    before, after = max(most + least, 0), max(-least, 0)
    padded = (cv2.copyMakeBorder(view.picture, 0, 0, before, after, cv2.BORDER_REPLICATE) for view in (left, right))
    columns = slice(before, before + left.picture.shape[1])
    disparity = matcher.compute(*padded)[:, columns].astype(np.float32) / _STEP
    baseline = np.linalg.norm(right.world_T_camera[:3, 3] - left.world_T_camera[:3, 3])
    disparity += np.float32(right.K[0, 2] - left.K[0, 2])
    known = disparity > 0.0
    return np.where(known, left.K[0, 0] * baseline / np.where(known, disparity, 1.0), 0.0).astype(np.float32)


def filled_depth(depth: np.ndarray) -> np.ndarray:
    """Return depth with its holes (0) filled by the farther of the next known depths to the left and to the right.

    Holes lie where a near surface hides a far one from one eye. A row without any has the median of the picture.
    """
    known = depth > 0.0
    if not known.any():
        return np.ones_like(depth)
    columns = np.arange(depth.shape[1])
    before = np.maximum.accumulate(np.where(known, columns, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, columns, depth.shape[1])[:, ::-1], axis=1)[:, ::-1]
    left = np.where(before >= 0, np.take_along_axis(depth, np.maximum(before, 0), 1), 0.0)
    right = np.where(after < depth.shape[1], np.take_along_axis(depth, np.minimum(after, depth.shape[1] - 1), 1), 0.0)
    filled = np.where(known, depth, np.maximum(left, right))
    return np.where(filled > 0.0, filled, np.median(depth[known])).astype(np.float32)
