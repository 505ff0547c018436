"""Rims do not go dark: a lossless glass in even light of radiance 1 cannot be seen at all (the white furnace)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_dilation
from scipy.stats import binom

from glassware.core.mesh import Mesh
from glassware.procedural.description.picture import Picture
from glassware.render.frame import Geometry
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import trace_picture
from glassware.render.scene.loaded_scene import load

#: Paths may be as long as this, and roulette ends none: what is lost is only light that is caught in the glass.
DEPTH = 1024
#: A path in clear glass brings back 1 up to the rounding of its factors eta^2, some 1e-7 for each surface.
ROUNDING = 1e-3
#: Probability that a pixel does not, of 8 paths each: paths may slip through a hairline between triangles (at most 1e-4
#: of segments do, and a path has some six), or be longer than `DEPTH`.
STRAY = 5e-3
#: Chance that pixels of this probability are more than the bound, which is a quantile of the binomial distribution: a
#: rim of some 30 pixels may well have one.
SIGNIFICANCE = 1e-3
#: Share of the light of one vessel that paths of 64 surfaces (the default) may lose. Measured on these: below 2e-3;
#: `shared/reference` measured 0.2 % on others.
CUT_LOSS = 5e-3
#: How far below the top of a vessel its rim reaches [m].
RIM = 0.003


@pytest.fixture(scope="module")
def furnace(backend, drawn, clear, all_clear, even_light):
    """(fill probability, roughness probability) -> a loaded scene of clear vessels with next to no table."""

    def make(fill: float, rough: float = 0.0, picture: Picture | None = None):
        scene = clear(
            drawn(
                21,
                vessel_count=(4, 4),
                prop_count=(0, 0),
                vessels=all_clear | {"fill_probability": fill, "rough_probability": rough, "roughness": (0.2, 0.5)},
                environment={"hdri_dir": even_light, "hdri_calibrated": True},
                lights={"max_count": 0},
                cameras={"views": 15, "width": 128, "height": 96},
            )
        )
        # A table as small as dust: it would be the only dark thing in the room.
        corners = np.array([[0.0, 0.0, -1e-3], [1e-5, 0.0, -1e-3], [0.0, 1e-5, -1e-3]])
        dust = scene.table.model_copy(update={"mesh": Mesh("table", corners, np.array([[0, 1, 2]]))})
        chosen = Picture(spp=8, adaptive=False, max_depth=DEPTH, rr_depth=DEPTH) if picture is None else picture
        changed = {"table": dust, "picture": chosen, "cameras": scene.cameras[-2:]}
        return load(scene.model_copy(update=changed))

    return make


def _light(kernel, number: int) -> np.ndarray:
    """Radiance of every pixel of a view, (pixels,), the mean of its colours."""
    return trace_picture(kernel, kernel.description.cameras[number], "left", seed=3).radiance.mean(2).ravel()


def _rim_and_glass(kernel, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Which pixels show the topmost millimetres of a vessel, and which any glass, both (pixels,)."""
    camera = kernel.description.cameras[number]
    seen: Geometry = trace_geometry(kernel, camera)
    rows, columns = np.mgrid[: camera.height, : camera.width]
    local = np.stack([columns - camera.centre[0], rows - camera.centre[1], np.full(rows.shape, camera.focal)], -1)
    points = local / camera.focal * np.where(seen.id > 0, seen.Z, 0.0)[..., None]
    z = points @ camera.world_T_camera[2, :3] + camera.world_T_camera[2, 3]
    rim = np.zeros(seen.id.shape, bool)
    for vessel in kernel.description.vessels:
        top = vessel.world_T_object[2, 3] + vessel.size[2] / 2
        rim |= (seen.id == vessel.id) & (z > top - RIM)
    return rim.ravel(), (seen.id > 0).ravel()


@pytest.mark.parametrize("fill", [0.0, 1.0], ids=["empty", "filled"])
def test_smooth_glass_in_even_light_is_invisible_rims_above_all(furnace, fill):
    kernel = furnace(fill)
    assert all((vessel.liquid is not None) == (fill > 0) for vessel in kernel.description.vessels)
    for number in range(len(kernel.description.cameras)):
        light = _light(kernel, number)
        rim, glass = _rim_and_glass(kernel, number)
        assert rim.sum() > 20
        assert glass.sum() > 500
        for shown in (rim, glass):
            stray = (np.abs(light[shown] - 1.0) > ROUNDING).sum()
            assert stray <= binom.isf(SIGNIFICANCE, shown.sum(), STRAY)
        # A pixel beside the silhouette may have samples on glass.
        camera = kernel.description.cameras[number]
        away = ~binary_dilation(glass.reshape(camera.height, camera.width), np.ones((3, 3), bool)).ravel()
        np.testing.assert_allclose(light[away], 1.0, atol=1e-6)


@pytest.mark.slow
def test_the_default_path_length_loses_next_to_no_light(furnace):
    kernel = furnace(1.0, picture=Picture(spp=32))
    light = _light(kernel, 0)
    for shown in _rim_and_glass(kernel, 0):
        error = light[shown].std() / np.sqrt(shown.sum())
        assert -CUT_LOSS - 4.0 * error < light[shown].mean() - 1.0 < 4.0 * error + STRAY


def test_rough_glass_in_even_light_is_as_bright_as_what_is_round_it(furnace):
    kernel = furnace(1.0, rough=1.0)
    assert all(vessel.roughness > 0.0 for vessel in kernel.description.vessels)
    light = _light(kernel, 0)
    for shown in _rim_and_glass(kernel, 0):
        assert abs(light[shown].mean() - 1.0) < CUT_LOSS
