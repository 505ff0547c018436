"""Pictures with a margin around the frame: only the margin is traced, as the frame is there already."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.margin import Sides, in_frame
from ..core.randomness import stream_seed
from ..procedural.description.camera import Camera
from .frame import EYES, Eye, Oversize
from .labels.geometry import trace_geometry
from .pictures.film import Film
from .pictures.guides import trace_guides
from .pictures.picture import (
    PATH_TRACER,
    NoisyImage,
    Source,
    Tracer,
    add_even,
    check_finite,
    check_media,
    denoise_image,
)
from .scene.loaded_scene import LoadedScene
from .scene.rays import pinhole


def with_margin(camera: Camera, margin: Sides) -> Camera:
    """Return a camera of the same pose and focal lengths that sees a margin around the frame."""
    left, top, right, bottom = margin
    (cx, cy), size = camera.centre, (camera.width + left + right, camera.height + top + bottom)
    return camera.model_copy(update={"width": size[0], "height": size[1], "centre": (cx + left, cy + top)})


def trace_oversize(
    loaded: LoadedScene,
    view: int,
    margin: Sides,
    noisy: Sequence[NoisyImage],
    clean: Sequence[np.ndarray],
    tracer: Tracer = PATH_TRACER,
) -> Oversize:
    """Return both pictures of a view with a margin, and the left camera's depth.

    The denoiser sees frame and margin together, but the frame stays what it is without.

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
    tracer : Tracer
        That of the frame.
    """
    scene, pictures = loaded.description, []
    camera = scene.cameras[view]
    for eye, inner, done in zip(EYES, noisy, clean, strict=True):
        seed = stream_seed(scene.seed, scene.scene_id, f"render/{view}/{eye}/margin")
        image = trace_margin(loaded, camera, eye, seed, margin, inner, tracer)
        picture = denoise_image(image, scene.picture.fireflies) if scene.picture.denoise else image.radiance.copy()
        in_frame(picture, margin)[:] = done
        pictures.append(picture)
    left, right = pictures
    return Oversize(margin, left, right, trace_geometry(loaded, with_margin(camera, margin)).Z)


def trace_margin(
    loaded: LoadedScene,
    camera: Camera,
    eye: Eye,
    seed: int,
    margin: Sides,
    inner: NoisyImage,
    tracer: Tracer = PATH_TRACER,
) -> NoisyImage:
    """Render the margin around one eye's frame, with as many samples a pixel as the frame has on average.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    camera : Camera
        The stereo pair, without the margin.
    eye : {"left", "right"}
        Which of the two.
    seed : int
        Of the margin's samples, another one than the frame's.
    margin : Sides
        Around the frame.
    inner : NoisyImage
        The frame (`pictures.picture.trace_picture`), which the result has in its inside.
    tracer : Tracer
        That of the frame.

    Raises
    ------
    MediumError, LightError
        As `pictures.picture.trace_picture`.
    """
    wide = with_margin(camera, margin)
    guides = trace_guides(loaded, wide, eye)
    outside = np.ones((wide.height, wide.width), bool)
    in_frame(outside, margin)[:] = False
    film = Film(outside.size)
    source = Source(loaded, pinhole(wide, eye), camera.exposure, seed, tracer)
    counts = add_even(source, film, outside.ravel(), inner.sampling.spp)
    check_media(counts, eye)
    shape = (wide.height, wide.width, 3)
    with np.errstate(invalid="ignore", over="ignore"):  # the frame has no samples here, and is filled in next
        radiance, variance = (x.astype(np.float32).T.reshape(shape) for x in (film.means, film.variance))
    in_frame(radiance, margin)[:] = inner.radiance
    in_frame(variance, margin)[:] = inner.variance
    check_finite(radiance, variance, guides.instance, eye)
    return NoisyImage(
        radiance, variance, guides, inner.sampling, camera.exposure, violations=float(counts[0] / counts[1])
    )
