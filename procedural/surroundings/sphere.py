"""The equirectangular map of directions that every environment is baked to.

Row 0 lies at the pole +z, the last row at -z; column c has the azimuth phi = 2 pi (c + 1/2) / W from +x towards +y.
Seen from inside, with +z up, the azimuth grows to the left: the map is the mirror image of a panorama photograph.
"""

from __future__ import annotations

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
