"""What a drawn picture keeps: pixels without noise to the last bit, caustics and props to a few per cent."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from glassware.procedural.description.picture import Picture
from glassware.procedural.surroundings.colour import luminance
from glassware.render.cache.scene_cache import make_tracer
from glassware.render.pictures.picture import PATH_TRACER, denoise_image, trace_picture
from glassware.render.renderer import Renderer
from glassware.render.scene.loaded_scene import load

#: Few samples make many fireflies.
SPP = 6


def _inner(mask: np.ndarray) -> np.ndarray:
    return cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1).astype(bool)


@pytest.mark.parametrize("light", ["path", "shared"])
def test_pixels_that_see_the_surroundings_are_not_changed_by_filters(
    backend, optical_bench, monkeypatch, light
) -> None:
    monkeypatch.setattr(optical_bench, "BOARD", (0.6, 0.6, 0.02))  # what is stored grows with the board
    ball = optical_bench.ball(0.05, 4, (0.0, 0.0, 0.06))
    camera = optical_bench.camera((0.5, 0.0, 0.15), (0.0, 0.0, 0.1))
    scene = optical_bench.scene(ball, optical_bench.medium(1.5), camera)
    frame = Renderer(scene.model_copy(update={"picture": Picture(spp=SPP, light=light)})).frame(0)
    surroundings = _inner(frame.geometry.id == 0)
    assert surroundings.sum() > 300
    assert frame.left_noisy is not None
    assert (frame.left != frame.left_noisy).any()
    np.testing.assert_array_equal(frame.left[surroundings], frame.left_noisy[surroundings])


@pytest.mark.slow
def test_stored_light_keeps_what_path_tracing_finds_on_each_object(backend, drawn) -> None:
    camera = {"views": 1, "width": 160, "height": 120}
    scene = drawn(101, vessel_count=(3, 3), prop_count=(3, 3), cameras=camera, picture={"spp": 20, "light": "shared"})
    loaded = load(scene, for_cache=True)
    tracer, check, _ = make_tracer(loaded)
    assert check.mode == "shared"
    ids = Renderer(scene).frame(0).geometry.id
    clean = luminance(denoise_image(trace_picture(loaded, scene.cameras[0], "left", 1, tracer)))
    many = load(scene.model_copy(update={"picture": Picture(spp=512, light="path")}), for_cache=True)
    paths = [trace_picture(many, scene.cameras[0], "left", seed, PATH_TRACER) for seed in (2, 3)]
    reference = luminance(0.5 * (paths[0].radiance + paths[1].radiance))
    # The channels of rare light are correlated: their standard errors add up.
    noise = luminance(0.5 * np.sqrt(paths[0].variance + paths[1].variance))
    regions = [_inner(ids == item.id) for item in scene.objects]
    shown = [region for region in regions if region.sum() > 60]
    assert len(shown) >= 4
    for region in shown:
        level = reference[region].sum()
        ratio, error = clean[region].sum() / level, np.sqrt((noise[region] ** 2).sum()) / level
        # 2 %, or three standard errors of the reference; the picture's own noise of 20 samples is as large as 2 %.
        assert abs(ratio - 1.0) < 0.04 + 3.0 * error, ratio
