"""What light transport hands on: pictures and per-pixel geometry of one view, as NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Geometry:
    """What straight camera rays through the exact pixel centres meet, for one camera (H x W pixels, n objects).

    "First" is the first surface, glass included; "background" is the first opaque surface. Object ``i`` of the stacks
    is ``scene.objects[i]``.
    """

    Z: np.ndarray  #: (H, W) float32, planar depth of the first surface [m]; +inf where there is none
    normal: (
        np.ndarray
    )  #: (H, W, 3) float32, unit normal of the first surface, camera frame, facing the camera; 0 for none
    id: np.ndarray  #: (H, W) uint16, instance id of the first surface
    background_Z: np.ndarray  #: (H, W) float32, planar depth of the first opaque surface [m]; +inf where there is none
    background_id: np.ndarray  #: (H, W) uint16, instance id of the first opaque surface
    transmittance: np.ndarray  #: (H, W, 3) float32, Fresnel times absorption along the straight ray to the background
    crossed: np.ndarray  #: (n, H, W) bool, the straight ray meets the object at all (its whole silhouette in the frame)
    reached: np.ndarray  #: (n, H, W) bool, ... and meets no opaque surface of another object (or the table) before


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered view: stereo pictures in linear Rec.709 radiance, and the left camera's geometry."""

    left: np.ndarray  #: (H, W, 3) float32
    right: np.ndarray  #: (H, W, 3) float32
    left_noisy: np.ndarray | None  #: (H, W, 3) float32, before the denoiser; None where none ran
    right_noisy: np.ndarray | None  #: (H, W, 3) float32
    geometry: Geometry
    seconds: dict[str, float]  #: time spent on "picture", "geometry", "denoise" [s]
