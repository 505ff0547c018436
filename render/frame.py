"""What light transport hands on: pictures and per-pixel geometry of one view, as NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, Field

from ..core.model import Model

#: What a surface is a part of, by its code in layers: an opaque body, or one of a vessel's interfaces.
PARTS = ("opaque", "outside", "wet_wall", "liquid_surface")
#: How a refracted ray ended, by its code: it left the scene, met an opaque surface, or met too many interfaces.
SURROUNDINGS, HIT, LOST = 0, 1, 2


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
class Layers:
    """All surfaces along the straight rays through the pixel centres, in order, as far as K of them.

    A layer that a ray does not have is empty: Z +inf, everything else 0.
    """

    Z: np.ndarray  #: (K, H, W) float32, planar depth [m]
    normal: np.ndarray  #: (K, H, W, 3) float16, unit normal, camera frame, facing the camera
    id: np.ndarray  #: (K, H, W) uint16, instance id
    part: np.ndarray  #: (K, H, W) uint8, index into `PARTS`
    material: np.ndarray  #: (K, H, W) uint16, what the ray goes on in: index into `materials_of(scene)`, 0 is air
    entering: np.ndarray  #: (K, H, W) bool, against the surface's own normal: into glass, into liquid from air, ...
    count: np.ndarray  #: (H, W) uint16, surfaces that the ray really meets, those beyond K as well


@dataclass(frozen=True, eq=False)
class Refraction:
    """Where the rays through the pixel centres really go: refracted at every interface, to the first opaque surface."""

    state: np.ndarray  #: (H, W) uint8, `SURROUNDINGS`, `HIT` or `LOST`
    hit: np.ndarray  #: (H, W, 3) float32, world: the point [m], for `SURROUNDINGS` the unit direction to it; 0 for lost
    Z: np.ndarray  #: (H, W) float32, planar depth of the point in the camera frame [m]; +inf where there is none
    id: np.ndarray  #: (H, W) uint16, instance id of the opaque surface; 0 where there is none
    flow: np.ndarray  #: (H, W, 2) float32, where the point appears without glass, less the pixel [px]; NaN: nowhere
    bounces: np.ndarray  #: (H, W) uint16, interfaces met
    transmittance: np.ndarray  #: (H, W, 3) float16, share of light by Fresnel and absorption along the ray


def _known(noise: float | None) -> float | None:
    return None if noise is None or isnan(noise) else noise


class Sampling(Model):
    """Samples and noise of one picture before the denoiser."""

    spp: int = Field(description="Samples per pixel")
    noise: Annotated[float | None, BeforeValidator(_known)] = Field(
        description="Relative error, estimated: root of the expected mean of (I - R)^2 / (R^2 + 0.01); null: unknown"
    )


@dataclass(frozen=True)
class LightCheck:
    """How pictures from a scene's stored light compare with path-traced ones, in random pixels of its views."""

    scene_id: int
    mode: str  #: what the pictures were made with: "shared", or "path" where the check failed
    difference: float  #: how much brighter they are from stored light, as a share of the mean light
    standard_error: float  #: of the difference
    bound: float  #: most that the difference may be, beyond three standard errors
    pixels: int  #: pixels compared
    nodes: int  #: places that light was stored at
    paths: int  #: paths that found it


@dataclass(frozen=True, eq=False)
class SurfaceLight:
    """The light that arrives at n places of a scene's opaque surfaces."""

    id: np.ndarray  #: (n,) uint16, instance id of the surface's object; 0 for the back of a lamp
    position: np.ndarray  #: (n, 3) float32, world [m]
    normal: np.ndarray  #: (n, 3) float32, world, on the side that the light arrives at
    irradiance: np.ndarray  #: (n, 3) float32, linear Rec.709 radiance times steradians
    paths: np.ndarray  #: (n,) uint32, paths that each is the mean of


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered view: stereo pictures in linear Rec.709 radiance, and the left camera's geometry."""

    left: np.ndarray  #: (H, W, 3) float32
    right: np.ndarray  #: (H, W, 3) float32
    left_noisy: np.ndarray | None  #: (H, W, 3) float32, before the denoiser; None where none ran
    right_noisy: np.ndarray | None  #: (H, W, 3) float32
    geometry: Geometry
    seconds: dict[str, float]  #: time spent on "picture", "geometry", "refraction", "denoise" [s]
    sampling: tuple[Sampling, Sampling] | None = None  #: of the left and the right picture; None where not rendered
    layers: Layers | None = None  #: of the left camera; None where none were asked for
    refraction: Refraction | None = None  #: of the left camera; None where it was not asked for
