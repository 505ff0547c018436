"""Results of rendering: pictures and per-pixel geometry of one view, as NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

from ..core.html import html_images
from ..core.images import LINEAR, Tone, common_tone, depth_colours, id_colours, normal_colours, srgb8
from ..core.margin import Sides
from ..core.model import Model
from ..procedural.description.camera import Camera

#: One eye of a stereo camera.
Eye = Literal["left", "right"]
#: Both eyes, in the order of a `Frame`'s pairs.
EYES: tuple[Eye, Eye] = ("left", "right")

#: Part that a surface belongs to, by its code in layers: an opaque body, or one of a vessel's interfaces.
PARTS = ("opaque", "outside", "wet_wall", "liquid_surface", "liquid_interface", "content")
#: How a refracted ray ends, by its code: it leaves the scene, hits an opaque surface, or meets too many interfaces.
SURROUNDINGS, HIT, LOST = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Geometry:
    """What straight camera rays through the exact pixel centres hit, for one camera (H x W pixels, n objects).

    "First" is the first surface, glass included; "background" is the first opaque surface. Object ``i`` of the stacks
    is ``scene.objects[i]``.
    """

    Z: np.ndarray  #: (H, W) float32, planar depth of the first surface [m]; +inf for nothing
    #: (H, W, 3) float32, unit normal of the first surface, camera frame, facing the camera; 0 for nothing
    normal: np.ndarray
    id: np.ndarray  #: (H, W) uint16, instance id of the first surface
    background_Z: np.ndarray  #: (H, W) float32, planar depth of the first opaque surface [m]; +inf for nothing
    background_id: np.ndarray  #: (H, W) uint16, instance id of the first opaque surface
    transmittance: np.ndarray  #: (H, W, 3) float32, Fresnel times absorption along the straight ray to the background
    crossed: np.ndarray  #: (n, H, W) bool, the straight ray crosses the object (its whole silhouette in the frame)
    reached: np.ndarray  #: (n, H, W) bool, ... and no opaque surface of another object or the table before


@dataclass(frozen=True, eq=False)
class Layers:
    """The first K surfaces along the straight rays through the pixel centres, in order.

    Layers beyond a ray's last surface are empty: Z +inf, everything else 0.
    """

    Z: np.ndarray  #: (K, H, W) float32, planar depth [m]
    normal: np.ndarray  #: (K, H, W, 3) float16, unit normal, camera frame, facing the camera
    id: np.ndarray  #: (K, H, W) uint16, instance id
    part: np.ndarray  #: (K, H, W) uint8, index into `PARTS`
    material: np.ndarray  #: (K, H, W) uint16, material behind the surface: index into `materials_of(scene)`, 0 is air
    entering: np.ndarray  #: (K, H, W) bool, whether the ray enters the body, against the surface's normal
    count: np.ndarray  #: (H, W) uint16, number of surfaces along the ray, including those beyond K


@dataclass(frozen=True, eq=False)
class Transmission:
    """What the first K surfaces along straight rays pass on, in their order; N rays, row by row.

    Empty layers have id 0 and pass on everything.
    """

    id: np.ndarray  #: (K, N) uint16, instance id
    material: np.ndarray  #: (K, N) uint16, material behind the surface: index into `materials_of(scene)`, 0 is air
    surface: np.ndarray  #: (K, N) float32, 1 - Fresnel reflectance; 0 of an opaque surface
    segment: np.ndarray  #: (K, N, 3) float32, what absorption leaves on the way to the surface from the one before


@dataclass(frozen=True, eq=False)
class Refraction:
    """Where refracted rays through the pixel centres end: at the first opaque surface, or outside the scene."""

    state: np.ndarray  #: (H, W) uint8, `SURROUNDINGS`, `HIT` or `LOST`
    hit: np.ndarray  #: (H, W, 3) float32, world: the point [m], for `SURROUNDINGS` the unit direction to it; 0 for lost
    Z: np.ndarray  #: (H, W) float32, planar depth of the point in the camera frame [m]; +inf for nothing
    id: np.ndarray  #: (H, W) uint16, instance id of the opaque surface; 0 for nothing
    flow: np.ndarray  #: (H, W, 2) float32, projection of the point without glass minus the pixel [px]; NaN: none
    bounces: np.ndarray  #: (H, W) uint16, interfaces met
    transmittance: np.ndarray  #: (H, W, 3) float16, Fresnel times absorption along the ray


@dataclass(frozen=True, eq=False)
class Infrared:
    """What the two infrared cameras of a depth camera see, left and right (h x w pixels)."""

    pair: Camera  #: the two cameras
    #: (h, w) float32 each, radiance of the projector's light [W/(m^2 sr)]
    dots: tuple[np.ndarray, np.ndarray]
    #: (h, w) float32 each, radiance of ambient light in the unit of the pictures, 1 kcd/m^2 in drawn scenes
    ambient: tuple[np.ndarray, np.ndarray]
    Z: np.ndarray  #: (h, w) float32, planar depth of the left camera's first surfaces [m]; +inf for nothing
    lit: np.ndarray  #: (h, w) bool, whether nothing opaque is between them and the projector
    shared: np.ndarray  #: (h, w) bool, whether nothing opaque is between them and the right camera
    daylight: bool = False  #: whether ambient light is daylight, a part of which is beyond red


@dataclass(frozen=True, eq=False)
class Beams:
    """What comes back along the beams of a time-of-flight camera: k rays in each of h x w pixels."""

    camera: Camera  #: the device, as a camera whose left eye counts
    weight: np.ndarray  #: (k,) float32, part of a pixel's beam; all but the last, which is the mirrored one, sum to 1
    #: (k, h, w) float32, returned light of each ray, as the reflectance of a matte surface that faces the device over
    #: its squared distance [1/m^2]; 0 for none
    strength: np.ndarray
    path: np.ndarray  #: (k, h, w) float32, optical length of the way to the return [m]; +inf for none
    Z: np.ndarray  #: (h, w) float32, planar depth of first surfaces [m]; +inf for nothing


@dataclass(frozen=True, eq=False)
class StokesPicture:
    """The polarisation of the light that the left camera sees, in the frame of the picture (docs/polarisation.md)."""

    vector: np.ndarray  #: (H, W, 4, 3) float32, s0 to s3 in linear Rec.709, in the unit of the pictures' radiance
    error: np.ndarray  #: (H, W, 4) float32, standard error of the luminance of each, estimated


class PictureNoise(Model):
    """Samples and noise of one eye's picture before the denoiser."""

    spp: int = Field(description="Samples per pixel")
    noise: float | None = Field(
        description="Relative error, estimated: root of the expected mean of (I - R)^2 / (R^2 + 0.01); null: unknown"
    )


@dataclass(frozen=True, eq=False)
class LineOfSight:
    """Distances along the straight rays from one point through n others to what they meet; +inf for nothing."""

    first_distance: np.ndarray  #: (n,) float64, to the first surface [m]
    opaque_distance: np.ndarray  #: (n,) float64, to the first opaque surface [m]


@dataclass(frozen=True, eq=False)
class Oversize:
    """The pictures of a view with a margin around its frame, which are those of the frame in its inside.

    A lens that distorts sees parts of it (`dataset.cameras`).
    """

    margin: Sides  #: columns and rows beyond the left, the top, the right and the bottom border [px]
    left: np.ndarray  #: (H + top + bottom, W + left + right, 3) float32
    right: np.ndarray
    Z: np.ndarray  #: float32, planar depth of the left camera's first surfaces [m]; +inf for nothing
    raw: tuple[np.ndarray, np.ndarray] | None = None  #: `Frame.raw` of this size; None without a sensor


#: What was done about a region whose light from the irradiance cache is off: the whole scene is path traced, its
#: object is, or others are and it is within the bound since then; null where nothing had to be done.
Remedy = Literal["scene path traced", "object path traced", "other objects path traced"]


@dataclass(frozen=True)
class RegionCheck:
    """Comparison of pictures from the irradiance cache with path-traced ones, in random pixels of one region."""

    id: int  #: of the object that the pixels show
    #: "all" for a vessel; "lit" or "shaded", the more and the less lit half of a prop; "caustic", "shadow" or "open" of
    #: the table
    part: str
    pixels: int  #: pixels compared
    difference: float  #: mean difference of the cached pictures, over the region's mean radiance [1]
    standard_error: float  #: of the difference [1]
    remedy: Remedy | None = None  #: what was done about a region that is listed as beyond the bound


@dataclass(frozen=True)
class LightCheck:
    """Comparison of pictures from a scene's irradiance cache with path-traced ones, region by region."""

    scene_id: int
    mode: str  #: how the pictures are rendered: "shared" (from the cache), or "path" if the check failed
    difference: float  #: mean over the regions of the difference of the cached pictures [1]
    standard_error: float  #: of that mean [1]
    bound: float  #: maximum difference of a region, where three standard errors are less [1]
    pixels: int  #: pixels compared
    nodes: int  #: cache points
    paths: int  #: paths that filled the cache
    photons: int = 0  #: photons that the cache's caustics are made of
    regions: tuple[RegionCheck, ...] = ()
    failed: tuple[RegionCheck, ...] = ()  #: regions beyond the bound when all light was read from the cache ...
    traced: tuple[int, ...] = ()  #: ... and objects whose light is path traced because of that


@dataclass(frozen=True, eq=False)
class SurfaceLight:
    """The irradiance cache of a scene, exported: n points on its opaque surfaces."""

    id: np.ndarray  #: (n,) uint16, instance id of the surface's object; 0 for the back of an area light
    position: np.ndarray  #: (n, 3) float32, world [m]
    normal: np.ndarray  #: (n, 3) float32, world, on the side that receives the light
    irradiance: np.ndarray  #: (n, 3) float32, linear Rec.709 radiance times steradians
    paths: np.ndarray  #: (n,) uint32, number of paths that each point is the mean of


@dataclass(frozen=True, eq=False)
class Draft:
    """A first look at a scene: a small, noisy picture of the first view's left eye, without caustics."""

    radiance: np.ndarray  #: (h, w, 3) float32, linear Rec.709
    exposure: float  #: factor from radiance to displayed light
    tone: Tone  #: white balance and highlights

    @property
    def picture(self) -> np.ndarray:
        """The 8-bit picture, (h, w, 3) uint8 red, green, blue."""
        return srgb8(self.radiance, self.exposure, self.tone)


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered view: stereo pictures in linear Rec.709 radiance, and the geometry of the left camera."""

    view: int  #: number of the camera in ``scene.cameras``
    left: np.ndarray  #: (H, W, 3) float32
    right: np.ndarray  #: (H, W, 3) float32
    left_noisy: np.ndarray | None  #: (H, W, 3) float32, before the denoiser; None without denoising
    right_noisy: np.ndarray | None  #: (H, W, 3) float32
    geometry: Geometry
    seconds: dict[str, float]  #: time spent on "picture", "geometry", "refraction", "denoise" [s]
    sampling: tuple[PictureNoise, PictureNoise] | None = None  #: of left and right; None without pictures
    layers: Layers | None = None  #: of the left camera; None if not requested
    refraction: Refraction | None = None  #: of the left camera; None if not requested
    infrared: Infrared | None = None  #: of the stereo depth camera; None without one
    beams: Beams | None = None  #: of the time-of-flight camera; None without one
    stokes: StokesPicture | None = None  #: of the left camera; None without a polarisation camera
    #: (H, W, 3) float32 each: what the sensors of the left and the right camera make of the same light, raw red, green
    #: and blue in the unit of radiance (`procedural.description.sensitivities`); None without sensitivities
    raw: tuple[np.ndarray, np.ndarray] | None = None
    oversize: Oversize | None = None  #: both pictures with a margin; None if not requested
    exposure: float = 1.0  #: factor from radiance to the linear value that sRGB encodes, for display
    tone: Tone = LINEAR  #: white balance and highlights, for display
    scene: object | None = None  #: the `Scene` that was rendered; None in a frame made by hand

    def __repr__(self) -> str:
        """Return one line: view, size, samples and noise, never the arrays."""
        height, width = self.left.shape[:2]
        noise = "" if self.sampling is None else f", {self.sampling[0].spp} samples per pixel"
        if self.sampling is not None and self.sampling[0].noise is not None:
            noise += f", noise {self.sampling[0].noise:.3g}"
        return f"Frame(view {self.view}: {width}x{height}{noise})"

    def _repr_html_(self) -> str:
        """Show both pictures, depth, normals and ids in a notebook."""
        geometry, tone = self.geometry, common_tone(self.tone, self.left, self.exposure)
        depth, (near, far) = depth_colours(geometry.Z, geometry.id)
        return html_images(
            [
                (f"view {self.view}, left", srgb8(self.left, self.exposure, tone)),
                ("right", srgb8(self.right, self.exposure, tone)),
                (f"depth Z, {near:.2f} to {far:.2f} m", depth),
                ("normals", normal_colours(geometry.normal)),
                ("instance ids", id_colours(geometry.id)),
            ]
        )
