"""Roughness, metalness and shading normals of a material's maps, as one array for the renderer.

Normal maps follow the convention of OpenGL or of DirectX: the green channel points up in the picture, or down (glTF
2.0, section 3.9.3, has the former). Heights become normals by central differences over a texture that repeats.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...core.assets import checked_path
from ..description.material import BumpMap, ChannelMap, NormalMap, OpaqueMaterial
from .picture_files import read_numbers

#: Longest side of the array [px]: four float32 numbers per texel, 64 MB at most.
MOST_TEXELS = 2048
#: Steepest slope that is shaded [1]: of a normal that leans by 80 degrees. Steeper ones are damage, or noise of a
#: compressed picture around the horizon.
STEEPEST = 5.67
_CHANNELS = {"grey": 0, "red": 0, "green": 1, "blue": 2}


def bake_maps(material: OpaqueMaterial) -> np.ndarray:
    """Return what a material's maps say: slopes along u and v, roughness, metalness.

    Parameters
    ----------
    material : OpaqueMaterial
        A material with at least one map; what it has no map of is the same everywhere.

    Returns
    -------
    (h, w, 4) float32
        The shading normal is along (-slope u, -slope v, 1); roughness and metalness in [0, 1]. The first row is the
        lower edge of the picture, as in `textures.bake`.

    Raises
    ------
    InputError
        If a picture is missing or unreadable, or its digest is not the recorded one.
    """
    planes = [
        _slopes(material),
        _numbers(material.roughness_map, material.roughness),
        _numbers(material.metallic_map, material.metallic),
    ]
    height, width = (max(plane.shape[axis] for plane in planes) for axis in (0, 1))
    sized = [_resized(plane, height, width) for plane in planes]
    return np.ascontiguousarray(np.concatenate(sized, axis=2), np.float32)


def mean_roughness(material: OpaqueMaterial) -> float:
    """Return a material's roughness, averaged over its map."""
    return (
        material.roughness
        if material.roughness_map is None
        else float(_numbers(material.roughness_map, material.roughness).mean())
    )


def mean_metallic(material: OpaqueMaterial) -> float:
    """Return a material's metalness, averaged over its map."""
    return (
        material.metallic
        if material.metallic_map is None
        else float(_numbers(material.metallic_map, material.metallic).mean())
    )


def _numbers(channel: ChannelMap | None, factor: float) -> np.ndarray:
    if channel is None:
        return np.full((1, 1, 1), factor, np.float32)
    stored = _upright(read_numbers(checked_path(channel.asset)))
    plane = stored[..., _CHANNELS[channel.channel], None]
    return np.clip(factor * (1.0 - plane if channel.inverted else plane), 0.0, 1.0).astype(np.float32)


def _slopes(material: OpaqueMaterial) -> np.ndarray:
    """Return the slopes of a surface along u and v, (h, w, 2) float32."""
    if material.normal_map is not None:
        return slopes_of_normals(_upright(read_numbers(checked_path(material.normal_map.asset))), material.normal_map)
    if material.bump_map is not None:
        return slopes_of_heights(
            _upright(read_numbers(checked_path(material.bump_map.asset)))[..., 0], material.bump_map
        )
    return np.zeros((1, 1, 2), np.float32)


def slopes_of_normals(stored: np.ndarray, record: NormalMap) -> np.ndarray:
    """Return the slopes that stored normals, (h, w, 3) in [0, 1], stand for: (h, w, 2) float32."""
    normal = 2.0 * stored.astype(np.float32) - 1.0
    if record.convention == "directx":
        normal[..., 1] *= -1.0
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = np.where(length > 0.1, normal / np.maximum(length, 0.1), np.array([0.0, 0.0, 1.0], np.float32))
    slopes = -normal[..., :2] / np.maximum(normal[..., 2:], 1e-3)
    return np.clip(record.strength * slopes, -STEEPEST, STEEPEST).astype(np.float32)


def slopes_of_heights(heights: np.ndarray, record: BumpMap) -> np.ndarray:
    """Return the slopes of heights, (h, w) in [0, 1] with the lower edge first, over a repeat of side 1."""
    rows, columns = heights.shape
    along_u = (np.roll(heights, -1, axis=1) - np.roll(heights, 1, axis=1)) * (0.5 * columns)
    along_v = (np.roll(heights, -1, axis=0) - np.roll(heights, 1, axis=0)) * (0.5 * rows)
    slopes = record.depth * np.stack([along_u, along_v], axis=2)
    return np.clip(slopes, -STEEPEST, STEEPEST).astype(np.float32)


def _upright(stored: np.ndarray) -> np.ndarray:
    """Return a picture, (h, w, 3), with its lower edge first and of at most `MOST_TEXELS` a side."""
    height, width = stored.shape[:2]
    scale = MOST_TEXELS / max(height, width)
    if scale < 1.0:
        size = max(1, round(width * scale)), max(1, round(height * scale))
        stored = cv2.resize(stored, size, interpolation=cv2.INTER_AREA)
    return stored[::-1]


def _resized(plane: np.ndarray, height: int, width: int) -> np.ndarray:
    if plane.shape[:2] == (height, width):
        return plane
    if plane.shape[:2] == (1, 1):
        return np.broadcast_to(plane, (height, width, plane.shape[2]))
    return cv2.resize(plane, (width, height), interpolation=cv2.INTER_LINEAR).reshape(height, width, plane.shape[2])
