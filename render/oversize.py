"""Pictures with a margin around the frame: only the margin is traced, as the frame is there already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Literal

import numpy as np

from ..core.margin import Sides, in_frame
from ..core.randomness import stream_seed
from ..procedural.description.camera import Camera
from .frame import EYES, Eye, Oversize
from .labels.geometry import trace_geometry
from .pictures.guides import Guides
from .pictures.picture import NoisyImage, Tracer, denoise_image, trace_picture
from .scene.loaded_scene import LoadedScene

#: Part of the frame beside the margin that the denoiser sees with it [px]: four times the widest window of its
#: corrections (`pictures.denoise`).
_AROUND = 32
#: Rows and columns of a picture with a margin.
Region = tuple[slice, slice]


def strips(camera: Camera, margin: Sides) -> list[tuple[Region, Camera]]:
    """Return the margin in strips above, below, left and right of the frame, each with the camera that sees it alone.

    Strips without a pixel are left out. The corners belong to those above and below. Regions are those of the picture
    with its margin.
    """
    left, top, right, bottom = margin
    width, height = left + camera.width + right, top + camera.height + bottom
    frame, across = (top, top + camera.height), (left, left + camera.width)
    areas = (
        ((0, top), (0, width)),
        ((frame[1], height), (0, width)),
        (frame, (0, left)),
        (frame, (across[1], width)),
    )
    cx, cy = camera.centre
    found = []
    for (y, below), (x, beyond) in areas:
        if below > y and beyond > x:
            place = {"width": beyond - x, "height": below - y, "centre": (cx + left - x, cy + top - y)}
            found.append(((slice(y, below), slice(x, beyond)), camera.model_copy(update=place)))
    return found


def trace_oversize(
    loaded: LoadedScene,
    view: int,
    margin: Sides,
    noisy: Sequence[NoisyImage],
    clean: Sequence[np.ndarray],
    Z: np.ndarray,
    tracer: Tracer,
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
    """
    scene, pictures = loaded.description, []
    camera = scene.cameras[view]
    for eye, inner, done in zip(EYES, noisy, clean, strict=True):
        image = _with_margin(loaded, view, eye, margin, inner, tracer)
        picture = image.radiance.copy()
        if scene.picture.denoise:
            for region, _ in strips(camera, margin):
                picture[region] = _denoised(image, region, scene.picture.fireflies)
        in_frame(picture, margin)[:] = done
        pictures.append(picture)
    parts = [(region, trace_geometry(loaded, part).Z) for region, part in strips(camera, margin)]
    return Oversize(margin, *pictures, Z=_joined(Z, margin, parts))


def _with_margin(
    loaded: LoadedScene, view: int, eye: Eye, margin: Sides, inner: NoisyImage, tracer: Tracer
) -> NoisyImage:
    """Return a noisy picture with its margin, whose noise is drawn from streams of its own."""
    scene, images = loaded.description, []
    for number, (region, part) in enumerate(strips(scene.cameras[view], margin)):
        seed = stream_seed(scene.seed, scene.scene_id, f"render/{view}/{eye}/margin/{number}")
        images.append((region, trace_picture(loaded, part, eye, seed, tracer)))

    def joined(name: str) -> np.ndarray:
        return _joined(getattr(inner, name), margin, [(region, getattr(image, name)) for region, image in images])

    def guide(name: str) -> np.ndarray:
        parts = [(region, getattr(image.guides, name)) for region, image in images]
        return _joined(getattr(inner.guides, name), margin, parts)

    guides = Guides(**{item.name: guide(item.name) for item in fields(Guides)})
    return NoisyImage(joined("radiance"), joined("variance"), guides, inner.sampling, inner.exposure, inner.violations)


def _denoised(image: NoisyImage, region: Region, fireflies: Literal["keep", "remove"]) -> np.ndarray:
    """Return a region of a picture without noise, by what is up to `_AROUND` around it."""
    around = tuple(slice(max(part.start - _AROUND, 0), part.stop + _AROUND) for part in region)
    guides = Guides(**{item.name: getattr(image.guides, item.name)[around] for item in fields(Guides)})
    seen = replace(image, radiance=image.radiance[around], variance=image.variance[around], guides=guides)
    rows, columns = (
        slice(part.start - seen.start, part.stop - seen.start) for part, seen in zip(region, around, strict=True)
    )
    return denoise_image(seen, fireflies)[rows, columns]


def _joined(frame: np.ndarray, margin: Sides, parts: Sequence[tuple[Region, np.ndarray]]) -> np.ndarray:
    """Return an array of a frame, (H, W, ...), with its margin's parts around it."""
    left, top, right, bottom = margin
    whole = np.pad(frame, ((top, bottom), (left, right), *[(0, 0)] * (frame.ndim - 2)))
    for region, values in parts:
        whole[region] = values
    return whole
