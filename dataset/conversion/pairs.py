"""Whether the right picture of a pair shows what depth and baseline say."""

from __future__ import annotations

import cv2
import numpy as np

from ..readers.source_view import SourceView

#: Fewest pixels that both pictures show, for a comparison to mean something.
_FEWEST = 100
#: Standard deviation of the blur before the comparison [px]: depths of sensors are off by parts of a pixel.
_BLUR = 1.0


def pair_agreement(view: SourceView) -> tuple[float, float] | None:
    """Return how alike the two pictures are, by the depth of each pixel and without it; None where that is unknown.

    Both are correlations of grey levels, 1 for the same picture. In a pair that is one the first is greater: glass,
    mirrors and what only one camera sees are few. Where it is not, the right picture is that of another camera, or
    depth, K or baseline is wrong.

    Parameters
    ----------
    view : SourceView
        A view with a right picture, its baseline, K and depth.
    """
    camera, Z = view.camera, view.Z
    if view.right is None or Z is None or camera.K is None or camera.baseline is None:
        return None
    height, width = Z.shape
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    known = np.isfinite(Z)
    there = x - np.where(known, camera.K[0, 0] * camera.baseline / np.where(known, Z, 1.0), 0.0).astype(np.float32)
    shown = known & (there >= 0.0)
    if np.count_nonzero(shown) < _FEWEST:
        return None
    left, right = _grey(view.picture), _grey(view.right)
    moved = cv2.remap(right, there, y, cv2.INTER_LINEAR)
    return _alike(left[shown], moved[shown]), _alike(left[shown], right[shown])


def _grey(picture: np.ndarray) -> np.ndarray:
    return cv2.GaussianBlur(picture.mean(axis=-1).astype(np.float32), (0, 0), _BLUR)


def _alike(a: np.ndarray, b: np.ndarray) -> float:
    """Return the correlation of two sets of values; 0 where one of them is constant."""
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / scale if scale > 0.0 else 0.0
