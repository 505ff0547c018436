"""Registration: the depth of the left infrared camera, in the pixels of the colour camera."""

from __future__ import annotations

import numpy as np

from ...procedural.description.camera import Camera

#: Largest number of colour pixels across that one infrared pixel covers [px].
_WIDEST = 16


def registered(Z: np.ndarray, infrared: Camera, colour: Camera, shift: float) -> np.ndarray:
    """Return depth in the pixels of a colour camera with the same axes, (H, W) float32 [m]; NaN where there is none.

    Each pixel covers the rectangle into which its corners project at its depth, and the nearest depth wins. So a
    foreground throws a shadow onto what the colour camera sees and the infrared camera does not.

    Parameters
    ----------
    Z : (h, w) float32
        Planar depth of the infrared camera [m]; NaN where there is none.
    infrared, colour : Camera
        The two cameras; the left eyes count.
    shift : float
        x of the infrared camera in the colour camera's frame [m].
    """
    rows, columns = np.nonzero(np.isfinite(Z))
    depth = Z[rows, columns].astype(np.float64)
    (cx, cy), (ux, uy) = infrared.centre, colour.centre
    left, right = (colour.fx * ((columns + side - cx) / infrared.fx + shift / depth) + ux for side in (-0.5, 0.5))
    top, bottom = (colour.fy * (rows + side - cy) / infrared.fy + uy for side in (-0.5, 0.5))
    first_u, first_v = np.rint(left).astype(int), np.rint(top).astype(int)
    # From the pixel of one corner to that of the other, both included, as the vendor's library has it: neighbours
    # overlap by up to a pixel, and leave no cracks.
    count_u = np.clip(np.rint(right).astype(int) - first_u + 1, 1, _WIDEST)
    count_v = np.clip(np.rint(bottom).astype(int) - first_v + 1, 1, _WIDEST)
    found = np.full(colour.height * colour.width, np.inf)
    for down in range(int(count_v.max(initial=0))):
        for across in range(int(count_u.max(initial=0))):
            u, v = first_u + across, first_v + down
            inside = (across < count_u) & (down < count_v) & (u >= 0) & (u < colour.width) & (v >= 0)
            inside &= v < colour.height
            np.minimum.at(found, v[inside] * colour.width + u[inside], depth[inside])
    found[np.isinf(found)] = np.nan
    return found.reshape(colour.height, colour.width).astype(np.float32)


def projected(Z: np.ndarray, colour: Camera, infrared: Camera, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Return where the points of colour pixels are in the infrared picture: column and row, (H, W) float each [px].

    Parameters
    ----------
    Z : (H, W) float32
        Planar depth of the colour camera [m]; points at infinity are moved by no parallax.
    colour, infrared, shift
        As for `registered`.
    """
    grid = np.indices(Z.shape).astype(np.float64)
    rows, columns = grid[0], grid[1]
    (cx, cy), (ux, uy) = infrared.centre, colour.centre
    column = infrared.fx * ((columns - ux) / colour.fx - shift / Z) + cx
    return column, infrared.fy * (rows - uy) / colour.fy + cy
