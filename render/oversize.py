"""Pictures with a margin around the frame: only the margin is traced, as the frame is there already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Literal

import numpy as np

from ..core.margin import Sides, in_frame
from ..core.randomness import stream_seed
from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene
from .frame import EYES, Eye, Oversize
from .labels.geometry import trace_geometry
from .pictures.film import Film
from .pictures.guides import Guides, trace_guides
from .pictures.picture import (
    NoisyImage,
    Source,
    Tracer,
    add_even,
    channels_of,
    check_finite,
    check_media,
    denoise_image,
    film_pictures,
)
from .scene.loaded_scene import LoadedScene
from .scene.rays import pinhole

#: Part of the frame beside the margin that the denoiser sees with it [px]: four times the widest window of its
#: corrections (`pictures.denoise`).
_AROUND = 32
#: Rows and columns of a picture with a margin.
Region = tuple[slice, slice]


def with_margin(camera: Camera, margin: Sides) -> Camera:
    """Return a camera of the same pose and focal lengths that sees a margin around the frame."""
    left, top, right, bottom = margin
    (cx, cy), width, height = camera.centre, camera.width + left + right, camera.height + top + bottom
    return camera.model_copy(update={"width": width, "height": height, "centre": (cx + left, cy + top)})


def strips(camera: Camera, margin: Sides) -> list[Region]:
    """Return the margin in strips above, below, left and right of the frame, of which the first two have the corners.

    Regions are those of the picture with its margin. Strips without a pixel are left out.
    """
    left, top, right, bottom = margin
    width, height = left + camera.width + right, top + camera.height + bottom
    rows, every = slice(top, height - bottom), slice(0, width)
    areas = (
        (top, (slice(0, top), every)),
        (bottom, (slice(height - bottom, height), every)),
        (left, (rows, slice(0, left))),
        (right, (rows, slice(width - right, width))),
    )
    return [region for thickness, region in areas if thickness]


def trace_oversize(
    loaded: LoadedScene,
    view: int,
    margin: Sides,
    noisy: Sequence[NoisyImage],
    clean: Sequence[np.ndarray],
    Z: np.ndarray,
    tracer: Tracer,
    raw: Sequence[np.ndarray] | None = None,
) -> Oversize:
    """Return both pictures of a view with a margin, and the left camera's depth.

    The denoiser sees the margin with a part of the frame, but the frame stays what it is without.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    view : int
        Number of the camera.
    margin : Sides
        Around the frame.
    noisy, clean : two of NoisyImage, two of (H, W, 3) float32
        The frame of the left and the right eye (`pictures.picture.trace_picture`), and its final picture.
    Z : (H, W) float32
        Planar depth of the frame, left eye [m].
    tracer : Tracer
        That of the frame.
    raw : two of (H, W, 3) float32, optional
        The frame's final raw response, where the scene has a sensor.
    """
    scene, pictures, seen = loaded.description, [], []
    camera = scene.cameras[view]
    for number, (eye, inner) in enumerate(zip(EYES, noisy, strict=True)):
        image = _with_margin(loaded, view, eye, margin, inner, tracer)
        pictures.append(_finished(image, scene, camera, margin, clean[number]))
        if image.of_sensor is not None and raw is not None:
            seen.append(_finished(image.of_sensor, scene, camera, margin, raw[number]))
    depth = trace_geometry(loaded, with_margin(camera, margin)).Z
    in_frame(depth, margin)[:] = Z
    return Oversize(margin, *pictures, Z=depth, raw=(seen[0], seen[1]) if seen else None)


def _finished(image: NoisyImage, scene: Scene, camera: Camera, margin: Sides, done: np.ndarray) -> np.ndarray:
    """Return a picture with its margin denoised around the frame, which is `done`."""
    picture = image.radiance.copy()
    if scene.picture.denoise:
        for region in strips(camera, margin):
            picture[region] = _denoised(image, region, scene.picture.fireflies)
    in_frame(picture, margin)[:] = done
    return picture


def _with_margin(
    loaded: LoadedScene, view: int, eye: Eye, margin: Sides, inner: NoisyImage, tracer: Tracer
) -> NoisyImage:
    """Return a noisy picture with its margin, which has as many samples a pixel as the frame has on average.

    Its noise is drawn from a stream of its own. All of it is traced at once: of so few rays, each run of a kernel takes
    longer than the rays.
    """
    scene, wide = loaded.description, with_margin(loaded.description.cameras[view], margin)
    outside = np.ones((wide.height, wide.width), bool)
    in_frame(outside, margin)[:] = False
    guides = trace_guides(loaded, wide, eye, outside)
    for item in fields(Guides):
        in_frame(getattr(guides, item.name), margin)[:] = getattr(inner.guides, item.name)
    film = Film(outside.size, channels_of(loaded))
    seed = stream_seed(scene.seed, scene.scene_id, f"render/{view}/{eye}/margin")
    source = Source(loaded, pinhole(wide, eye), wide.exposure, seed, tracer)
    counts = add_even(source, film, outside.ravel(), inner.sampling.spp)
    check_media(counts, eye)
    pictures = film_pictures(film, (wide.height, wide.width))  # the frame has no samples here, and is filled in next
    frames = [(inner.radiance, inner.variance), *([] if inner.raw is None else [inner.raw])]
    for (radiance, variance), (light, spread) in zip(pictures, frames, strict=True):
        in_frame(radiance, margin)[:], in_frame(variance, margin)[:] = light, spread
        check_finite(radiance, variance, guides.instance, eye)
    raw = pictures[1] if len(pictures) > 1 else None
    return NoisyImage(*pictures[0], guides, inner.sampling, wide.exposure, float(counts[0] / counts[1]), raw)


def _denoised(image: NoisyImage, region: Region, fireflies: Literal["keep", "remove"]) -> np.ndarray:
    """Return a region of a picture without noise, by what is up to `_AROUND` around it."""
    around = tuple(slice(max(part.start - _AROUND, 0), part.stop + _AROUND) for part in region)
    guides = Guides(**{item.name: getattr(image.guides, item.name)[around] for item in fields(Guides)})
    seen = replace(image, radiance=image.radiance[around], variance=image.variance[around], guides=guides)
    rows, columns = (
        slice(part.start - seen.start, part.stop - seen.start) for part, seen in zip(region, around, strict=True)
    )
    return denoise_image(seen, fireflies)[rows, columns]
