"""The equirectangular map of directions that every environment is baked to.

Row 0 lies at the pole +z, the last row at -z; column c has the azimuth phi = 2 pi (c + 1/2) / W from +x towards +y.
Seen from inside, with +z up, the azimuth grows to the left: the map is the mirror image of a panorama photograph.
"""

from __future__ import annotations

import cv2
import numpy as np


def texel_directions(height: int, rows: slice = slice(None), offset: tuple[float, float] = (0.5, 0.5)) -> np.ndarray:
    """Return the directions of texels.

    Parameters
    ----------
    height : int
        Rows of the whole map; it has twice as many columns.
    rows : slice
        The requested rows.
    offset : (float, float)
        Position within each texel, along the row's and the column's index, in [0, 1); the centre by default.

    Returns
    -------
    (h, 2 * height, 3) float32
        Unit vectors.
    """
    theta = np.pi * (np.arange(height)[rows] + offset[0]) / height
    phi = 2.0 * np.pi * (np.arange(2 * height) + offset[1]) / (2 * height)
    out = np.empty((len(theta), len(phi), 3), dtype=np.float32)
    out[..., 0] = np.sin(theta)[:, None] * np.cos(phi)
    out[..., 1] = np.sin(theta)[:, None] * np.sin(phi)
    out[..., 2] = np.cos(theta)[:, None]
    return out


def solid_angles(height: int) -> np.ndarray:
    """Return the exact solid angle of one texel in each row, (height,) float64 [sr]."""
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return (edges[:-1] - edges[1:]) * np.pi / height


def cosine_weights(height: int) -> np.ndarray:
    """Return the exact integral of max(cos theta, 0) over one texel in each row, (height,) float64 [sr]."""
    up = np.maximum(np.cos(np.pi * np.arange(height + 1) / height), 0.0)
    return 0.5 * (up[:-1] ** 2 - up[1:] ** 2) * np.pi / height


def softened(pixels: np.ndarray, deviation: float = 1.0) -> np.ndarray:
    """Return a map blurred by a Gaussian kernel, without a seam.

    A camera sees a texel over several pixels, and edges that are sharp to one texel show as stairs. At a standard
    deviation of 1 texel a straight edge is free of them to the eye.

    Parameters
    ----------
    pixels : (h, 2 * h, 3) float32
        The map.
    deviation : float
        Standard deviation of the kernel [texel].
    """
    margin = 4 * int(np.ceil(deviation))
    soft = cv2.GaussianBlur(_wrapped(pixels, margin), (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(soft[:, margin:-margin])


def doubled(pixels: np.ndarray) -> np.ndarray:
    """Return a map with twice the rows and columns, by bilinear interpolation; (h, 2 * h, ...) -> (2 h, 4 h, ...)."""
    wide = cv2.resize(_wrapped(pixels, 1), None, fx=2.0, fy=2.0, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(wide[:, 2:-2])


def _wrapped(pixels: np.ndarray, margin: int) -> np.ndarray:
    return np.concatenate([pixels[:, -margin:], pixels, pixels[:, :margin]], axis=1)
