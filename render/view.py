"""One view of a scene: both pictures, denoised, and the geometry that labels come from."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from ..core.randomness import stream_seed
from .frame import EYES, Eye, Frame
from .labels.geometry import trace_straight
from .labels.refraction import trace_refraction
from .pictures.denoise import denoise, spread_fireflies
from .pictures.picture import PATH_TRACER, NoisyImage, Tracer, trace_picture
from .scene.loaded_scene import LoadedScene


def render_view(kernel: LoadedScene, view: int, tracer: Tracer = PATH_TRACER) -> Frame:
    """Render a view of the loaded scene.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene.
    view : int
        Index into the scene's cameras.
    tracer : Tracer
        How light is found: by paths, or as stored (`light.scene_light.shared_light`).

    Returns
    -------
    Frame
        Depends on the scene's description and the view alone: not on other views or what was rendered before.
    """
    scene = kernel.description
    camera, seconds = scene.cameras[view], {}
    start = perf_counter()
    seeds: dict[Eye, int] = {eye: stream_seed(scene.seed, scene.scene_id, f"render/{view}/{eye}") for eye in EYES}
    left, right = (trace_picture(kernel, camera, eye, seed, tracer) for eye, seed in seeds.items())
    seconds["picture"] = perf_counter() - start

    start = perf_counter()
    geometry, layers = trace_straight(kernel, camera, scene.picture.layers)
    seconds["geometry"] = perf_counter() - start

    start = perf_counter()
    refraction = trace_refraction(kernel, [camera])[0] if scene.picture.refraction else None
    seconds["refraction"] = perf_counter() - start

    start = perf_counter()
    denoised = scene.picture.denoise
    frame = Frame(
        left=clean(left) if denoised else left.radiance,
        right=clean(right) if denoised else right.radiance,
        left_noisy=left.radiance if denoised else None,
        right_noisy=right.radiance if denoised else None,
        geometry=geometry,
        seconds=seconds,
        sampling=(left.sampling, right.sampling),
        layers=layers if scene.picture.layers else None,
        refraction=refraction,
    )
    seconds["denoise"] = perf_counter() - start
    return frame


def clean(noisy: NoisyImage) -> np.ndarray:
    """Return the picture without fireflies and noise, (H, W, 3) float32."""
    return denoise(spread_fireflies(noisy.radiance, noisy.variance), np.clip(noisy.albedo, 0.0, 1.0), noisy.normal)
