"""The map of a room: its surfaces as they are seen from the table's centre."""

from __future__ import annotations

import cv2
import numpy as np

from ..description.surroundings import RoomEnvironment
from .room_surfaces import room_surfaces
from .sphere import texel_directions

# Rows that are cast at once: the arrays of one cast stay in a processor's cache.
_STRIP = 128
# Rays per texel and direction on edges; elsewhere one ray goes through the middle of a texel.
_SUPERSAMPLING = 2
#: A texel is on an edge where the radiance of its 3 x 3 neighbourhood, in some primary, ranges over more than this
#: fraction of the largest value.
EDGE_CONTRAST = 0.1


def bake_room(room: RoomEnvironment, height: int = 512, edge_contrast: float = EDGE_CONTRAST) -> np.ndarray:
    """Return the radiance of a room seen from its table's centre, without ``rotation`` and ``strength``.

    Parameters
    ----------
    room : RoomEnvironment
        The room.
    height : int
        Rows of the map. From 512 on a mullion, 5 cm wide and up to 8 m away, covers a whole texel, so that one ray a
        texel finds every edge; in smaller maps mullions are partly missed.
    edge_contrast : float
        Contrast from which a texel is supersampled; below 0 all are.

    Returns
    -------
    (height, 2 * height, 3) float32
        Linear Rec.709 [kcd/m^2], laid out as `sphere` says. A texel is the mean of 2 x 2 rays on edges, and the
        radiance along its middle elsewhere.
    """
    surfaces, eye = room_surfaces(room), np.array([room.eye], dtype=np.float32)
    strips = [texel_directions(height, slice(k, k + _STRIP)).reshape(-1, 3) for k in range(0, height, _STRIP)]
    pixels = np.concatenate([surfaces.radiance(eye, rays) for rays in strips])
    edges = np.flatnonzero(_contrast(pixels.reshape(height, 2 * height, 3)) > edge_contrast)
    places = (np.arange(_SUPERSAMPLING) + 0.5) / _SUPERSAMPLING
    rays = (_directions(height, edges, u, v) for u in places for v in places)
    pixels[edges] = sum(surfaces.radiance(eye, some) for some in rays) / np.float32(_SUPERSAMPLING**2)
    return pixels.reshape(height, 2 * height, 3)


def _contrast(pixels: np.ndarray) -> np.ndarray:
    """Return the range over the largest value in each 3 x 3 neighbourhood, the most over the primaries, (h, w)."""
    wrapped, window = np.concatenate([pixels[:, -1:], pixels, pixels[:, :1]], axis=1), np.ones((3, 3), np.uint8)
    high, low = (reach(wrapped, window, borderType=cv2.BORDER_REPLICATE)[:, 1:-1] for reach in (cv2.dilate, cv2.erode))
    ranges = (high - low) / np.maximum(high, np.finfo(np.float32).tiny)
    return np.maximum(np.maximum(ranges[..., 0], ranges[..., 1]), ranges[..., 2])


def _directions(height: int, texels: np.ndarray, u: float, v: float) -> np.ndarray:
    """Return the unit vectors at a place in some texels, given by their numbers, (n,) -> (n, 3) float32."""
    row, column = np.divmod(texels, 2 * height)
    theta = (np.pi * (np.arange(height) + u) / height)[row]
    phi = np.pi * (np.arange(2 * height) + v) / height
    flat = np.sin(theta)
    return np.stack([flat * np.cos(phi)[column], flat * np.sin(phi)[column], np.cos(theta)], axis=1).astype(np.float32)
