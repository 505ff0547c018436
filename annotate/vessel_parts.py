"""What of a vessel each pixel shows: its glass, its wet wall, its liquid's surface, its content, its mouth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..procedural.description.camera import Camera
from ..render.frame import PARTS, Layers
from .projection import project


@dataclass(frozen=True, eq=False)
class VesselParts:
    """Masks of one vessel in a picture: whether the straight ray through a pixel's centre crosses a part of it.

    Surfaces behind an opaque one do not count, and parts overlap: most rays through the liquid cross the glass as well.
    """

    glass: np.ndarray  #: (H, W) bool, the wall, dry or wet
    wet_wall: np.ndarray  #: (H, W) bool, the wall where the liquid touches it
    liquid_surface: np.ndarray  #: (H, W) bool, the top of the liquid
    content: np.ndarray  #: (H, W) bool, liquids, ice, beads and bubbles
    opening: np.ndarray  #: (H, W) bool, inside the edge of the mouth, whatever is in front of it


#: The bit of each part in ``vessel_parts.png``.
PART_BITS = {"glass": 1, "wet_wall": 2, "liquid_surface": 4, "content": 8, "opening": 16}


def vessel_parts(
    layers: Layers, object_id: int, mouths: Sequence[np.ndarray], camera: Camera, turbid: Sequence[int] = ()
) -> VesselParts:
    """Return the masks of a vessel's parts.

    Parameters
    ----------
    layers : Layers
        Surfaces along the straight rays of the camera.
    object_id : int
        The vessel.
    mouths : sequence of (n, 3) float
        Its mouths as polygons, world frame [m].
    camera : Camera
        The camera; its left eye.
    turbid : sequence of int
        Materials whose surfaces are opaque (`opaque_media`).
    """
    shape = (layers.count.shape[0], layers.count.shape[1])
    there = (layers.id == object_id).any(axis=0)  # rays that meet it, a few percent of the picture
    Z, ids, kinds, material = (x[:, there] for x in (layers.Z, layers.id, layers.part, layers.material))
    opaque = (kinds == PARTS.index("opaque")) | np.isin(material, turbid)
    opaque &= np.isfinite(Z)
    behind = np.cumsum(opaque, axis=0) - opaque > 0
    own = (ids == object_id) & np.isfinite(Z) & ~behind
    masks = {part: np.zeros(shape, bool) for part in PARTS[1:]}
    for part, mask in masks.items():
        mask[there] = (own & (kinds == PARTS.index(part))).any(axis=0)
    wet, top = masks["wet_wall"], masks["liquid_surface"]
    held = masks["liquid_interface"] | masks["content"]
    opening = np.zeros(shape, bool)
    for mouth in mouths:
        opening |= polygon_mask(project(mouth, camera.K, camera.world_T_camera)[0], shape)
    return VesselParts(
        glass=masks["outside"] | wet, wet_wall=wet, liquid_surface=top, content=wet | top | held, opening=opening
    )


def part_bits(parts: Sequence[VesselParts], shape: tuple[int, int]) -> np.ndarray:
    """Return the parts of all vessels as bits, (H, W) uint16 (`PART_BITS`)."""
    bits = np.zeros(shape, np.uint16)
    for one in parts:
        for name, bit in PART_BITS.items():
            bits[getattr(one, name)] |= np.uint16(bit)
    return bits


def polygon_mask(pixels: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the pixels whose centres are inside a polygon, (n, 2) [px]; none where a corner is behind the camera."""
    mask = np.zeros(shape, bool)
    if not np.isfinite(pixels).all():
        return mask
    height, width = shape
    left, right = np.clip(np.floor([pixels[:, 0].min(), pixels[:, 0].max() + 1]), 0, width).astype(int)
    top, bottom = np.clip(np.floor([pixels[:, 1].min(), pixels[:, 1].max() + 1]), 0, height).astype(int)
    v, u = np.mgrid[top:bottom, left:right]
    inside = np.zeros(u.shape, bool)
    for (u0, v0), (u1, v1) in zip(pixels, np.roll(pixels, -1, axis=0), strict=True):
        if v0 != v1:  # even-odd rule: edges that a ray to the right crosses
            inside ^= ((v0 > v) != (v1 > v)) & (u < u0 + (v - v0) * (u1 - u0) / (v1 - v0))
    mask[top:bottom, left:right] = inside
    return mask
