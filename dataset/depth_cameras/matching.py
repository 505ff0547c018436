"""Disparities of two infrared pictures: semi-global matching (Hirschmueller, PAMI 2008) by OpenCV, and its checks."""

from __future__ import annotations

import cv2
import numpy as np

from ...procedural.description.depth_camera import Matching
from .exposure import InfraredPictures

#: Fractional bits of OpenCV's disparities.
_FRACTION = 16.0
#: Penalties of small and of large steps between neighbours, for each pixel of the window: OpenCV's own advice.
_SMALL_STEP, _LARGE_STEP = 8, 32
#: Steps by which windows are registered to fractions of a pixel [1].
_REFINEMENTS = 3
#: Largest difference of neighbours in one island, when small ones are removed [px].
_ISLAND = 1


def matched(pictures: InfraredPictures, matching: Matching) -> np.ndarray:
    """Return the disparity of each pixel of the left picture, (h, w) float32 [px]; NaN where there is no match.

    Left pixels whose match would be outside the right picture have none.
    """
    left, right = (_eight_bits(picture, pictures.white) for picture in (pictures.left, pictures.right))
    pad = matching.disparities
    left, right = (cv2.copyMakeBorder(one, 0, 0, pad, 0, cv2.BORDER_CONSTANT, value=0) for one in (left, right))
    area = matching.block**2
    matcher = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=matching.disparities,
        blockSize=matching.block,
        P1=_SMALL_STEP * area,
        P2=_LARGE_STEP * area,
        disp12MaxDiff=matching.left_right,
        uniquenessRatio=matching.uniqueness,
        speckleWindowSize=matching.speckle,
        speckleRange=_ISLAND,
        mode=cv2.STEREO_SGBM_MODE_HH4,
    )
    found = matcher.compute(left, right)[:, pad:].astype(np.float32) / _FRACTION
    columns = np.arange(found.shape[1], dtype=np.float32)
    seen = (found > 0.0) & (found <= columns) & (_contrast(pictures, matching.block) >= matching.texture)
    fine = refined(pictures, np.where(seen, found, 0.0).astype(np.float32), matching.block)
    steps = np.rint(fine / matching.step) * matching.step
    return np.where(seen & (steps > 0.0), steps, np.nan).astype(np.float32)


def refined(pictures: InfraredPictures, disparity: np.ndarray, block: int) -> np.ndarray:
    """Return disparities with a better fraction: the shift of each window with the least squared difference.

    OpenCV's own fraction comes from three costs that ignore shifts of half a pixel (Birchfield and Tomasi 1998), and is
    off by up to 0.2 px towards whole numbers. Here each window is registered by Newton steps on its grey levels (Lucas
    and Kanade 1981), without their means. A step that leads away from the match is not taken.
    """
    left, right = (picture.astype(np.float32) for picture in (pictures.left, pictures.right))
    grid = np.indices(disparity.shape).astype(np.float32)
    rows, columns = grid[0], grid[1]
    size, fine = (block, block), disparity.copy()
    slope = 0.5 * cv2.filter2D(right, cv2.CV_32F, np.array([[-1.0, 0.0, 1.0]]))
    for _ in range(_REFINEMENTS):
        at = columns - fine
        moved, gradient = (
            cv2.remap(one, at, rows, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE) for one in (right, slope)
        )
        gradient -= cv2.blur(gradient, size)
        difference = left - moved
        energy = cv2.blur(gradient * gradient, size)
        shift = cv2.blur(difference * gradient, size) / np.maximum(energy, 1e-3)
        fine -= np.clip(shift, -0.5, 0.5)
    return np.where(np.abs(fine - disparity) <= 1.0, fine, disparity)


def _eight_bits(picture: np.ndarray, white: int) -> np.ndarray:
    """Return a picture in the 8 bits that OpenCV's matcher takes."""
    return picture.astype(np.uint8) if white == 255 else (picture * (255.0 / white) + 0.5).astype(np.uint8)


def _contrast(pictures: InfraredPictures, block: int) -> np.ndarray:
    """Return the standard deviation of each window's grey levels, in that of their noise."""
    picture, size = pictures.left.astype(np.float32), (block, block)
    mean, square = cv2.blur(picture, size), cv2.blur(picture * picture, size)
    return np.sqrt(np.maximum(square - mean * mean, 0.0)) / np.maximum(cv2.blur(pictures.noise, size), 1e-3)
