"""Registration: the depth of the left infrared camera, in the pixels of the colour camera."""

from __future__ import annotations

import numpy as np

from ...procedural.description.camera import Camera

#: Largest number of colour pixels across that one infrared pixel covers [px].
_WIDEST = 16


def registered(Z: np.ndarray, infrared: Camera, colour: Camera, shift: float, alike: float = 0.0) -> np.ndarray:
    """Return depth in the pixels of a colour camera with the same axes, (H, W) float32 [m]; NaN where there is none.

    Each pixel covers the rectangle into which its corners project at its depth, and the nearest surface wins. So a
    foreground throws a shadow onto what the colour camera sees and the infrared camera does not. Of the depths of that
    surface the one whose pixel projects closest to the middle is taken: the nearest would be the one with the most
    noise towards the camera, and on coarse colour pixels, which nine infrared ones cover, too near by 1.5 of its
    standard deviations.

    Parameters
    ----------
    Z : (h, w) float32
        Planar depth of the infrared camera [m]; NaN where there is none.
    infrared, colour : Camera
        The two cameras; the left eyes count.
    shift : float
        x of the infrared camera in the colour camera's frame [m].
    alike : float
        Largest difference of the inverse depths of one surface [1/m].
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
    middle_u, middle_v = 0.5 * (left + right), 0.5 * (top + bottom)
    pixels, depths, offsets = [], [], []
    for down in range(int(count_v.max(initial=0))):
        for across in range(int(count_u.max(initial=0))):
            u, v = first_u + across, first_v + down
            inside = (across < count_u) & (down < count_v) & (u >= 0) & (u < colour.width) & (v >= 0)
            inside &= v < colour.height
            pixels.append((v * colour.width + u)[inside])
            depths.append(depth[inside])
            offsets.append(np.hypot(u - middle_u, v - middle_v)[inside])
    size, shape = colour.height * colour.width, (colour.height, colour.width)
    if not pixels:
        return np.full(shape, np.nan, np.float32)
    found = _chosen(np.concatenate(pixels), np.concatenate(depths), np.concatenate(offsets), alike, size)
    return found.reshape(shape).astype(np.float32)


def _chosen(pixel: np.ndarray, depth: np.ndarray, offset: np.ndarray, alike: float, size: int) -> np.ndarray:
    """Return for each of `size` pixels the depth with the least offset on its nearest surface; NaN without any."""
    nearest = np.full(size, np.inf)
    np.minimum.at(nearest, pixel, depth)
    same = 1.0 / nearest[pixel] - 1.0 / depth <= alike
    pixel, depth, offset = pixel[same], depth[same], offset[same]
    last = np.lexsort((-depth, -offset))  # the least offset, and of equal ones the nearest depth, is written last
    found = np.full(size, np.nan)
    found[pixel[last]] = depth[last]
    return found


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
