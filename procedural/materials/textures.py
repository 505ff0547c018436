"""Textures become arrays: linear Rec.709 reflectances."""

from __future__ import annotations

import numpy as np

from ...core.assets import checked_path
from ..description.material import PictureTexture, ProceduralTexture, Texture, UniformTexture
from .noise import tile_grid
from .patterns import PATTERNS
from .picture_files import read_picture


def bake(texture: Texture) -> np.ndarray:
    """Return a texture as an array that tiles without a seam (pictures tile as well as their file does).

    Row i lies at v = (i + 1/2) / h and column j at u = (j + 1/2) / w: **the first row is the lower edge** of a
    picture, because texture coordinates have v upwards (as in OBJ files).

    Parameters
    ----------
    texture : Texture
        What to bake. The result depends on it and, for a picture, on its file alone.

    Returns
    -------
    (h, w, 3) float32
        Reflectance in [0, 1], linear Rec.709.

    Raises
    ------
    InputError
        Where a picture is missing, unreadable or not the one that was pinned.
    """
    match texture:
        case UniformTexture():
            return np.array(texture.colour, np.float32).reshape(1, 1, 3)
        case ProceduralTexture():
            return _procedural(texture)
        case PictureTexture():
            return np.ascontiguousarray(read_picture(checked_path(texture.asset))[::-1])


def _procedural(texture: ProceduralTexture) -> np.ndarray:
    u, v = tile_grid(texture.resolution)
    rng = np.random.Generator(np.random.PCG64(texture.seed))
    picture = PATTERNS[texture.kind](u, v, np.array(texture.colours), rng)
    return np.clip(picture, 0.0, 1.0).astype(np.float32)
