"""Pictures from stored light are those that paths give; the check tells when they are not."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.stats import t as student

from glassware.core.assets import asset
from glassware.procedural.description.material import ChannelMap, NormalMap, OpaqueMaterial, UniformTexture
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Prop
from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.scene_cache import fill_scene_cache, uses_cache
from glassware.render.cache.trace_cached import cached_tracer
from glassware.render.pictures.picture import PATH_TRACER, trace_picture
from glassware.render.scene.loaded_scene import load

#: Independent pictures each way, every one of the second with stored light of its own; samples and paths of each.
PASSES, SPP, PATHS = 8, 32, 64
BLOCK = 8  #: side of the blocks that are compared [px]
SIGNIFICANCE = 1e-3  #: chance that two equal ways fail
#: What interpolation may change a block's mean by: cells are as large as a pixel and blocks are 8 pixels wide, so
#: an edge in the light may move by half a pixel of 8 on both sides of a block.
BIAS = 0.03


@pytest.fixture(scope="module")
def scenes(drawn, optical_bench, tmp_path_factory):
    """Small scenes, each with what is hard for stored light."""
    one = {"views": 1, "width": 48, "height": 32, "slack": (1.0, 1.0), "lowest_elevation": 0.6}
    lamp = {"max_count": 1}
    ball = optical_bench.scene(
        optical_bench.ball(0.05, 4, (0.0, 0.0, 0.06)),
        optical_bench.medium(1.5),
        optical_bench.camera((0.25, 0.0, 0.3), width=48, height=32),
    )
    return {
        "the caustic of a glass ball": ball,
        "a prop under a slab of water": _under_water(optical_bench),
        "colours between props": drawn(12, vessel_count=(0, 0), prop_count=(4, 4), cameras=one, lights=lamp),
        "glasses with liquid over a table": drawn(31, vessel_count=(3, 3), prop_count=(1, 1), cameras=one, lights=lamp),
        "a table with maps of roughness, metalness and normals": _mapped(
            drawn(14, vessel_count=(1, 1), prop_count=(2, 2), cameras=one, lights=lamp), tmp_path_factory.mktemp("maps")
        ),
        "a glossy table": _glossy(drawn(14, vessel_count=(1, 1), prop_count=(2, 2), cameras=one, lights=lamp)),
    }


def _under_water(bench):
    """A slab of water, 4 cm thick, over an opaque box: light reaches the box through it, and so does the eye."""
    camera = bench.camera((0.2, 0.0, 0.3), width=48, height=32)
    scene = bench.scene(bench.box((0.3, 0.3, 0.04), (0.0, 0.0, 0.07)), bench.medium(1.333, name="water"), camera)
    red = OpaqueMaterial(name="red", base_colour=UniformTexture(colour=(0.7, 0.1, 0.1)), roughness=0.4)
    size, world_T_object = (0.06, 0.04, 0.03), np.eye(4)
    world_T_object[2, 3] = 0.015
    prop = Prop(
        id=3, name="box", category="box", mesh=bench.box(size), material=red, size=size, world_T_object=world_T_object
    )
    return scene.model_copy(update={"props": (prop,)})


def _glossy(scene):
    material = scene.table.material.model_copy(update={"roughness": 0.15})
    return scene.model_copy(update={"table": scene.table.model_copy(update={"material": material})})


def _mapped(scene, folder):
    """A table of tiles of 5 cm: every second one is of rough metal, with waves as steep as 1 in 5 on all of them."""
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64)
    metal = ((x < 0.5) ^ (y < 0.5)).astype(np.float64)
    slope = 0.2 * np.sin(6.0 * np.pi * x)
    normal = np.dstack([-slope, np.zeros_like(x), np.ones_like(x)]) / np.hypot(slope, 1.0)[..., None]
    for name, pixels in (("arm", np.dstack([x, 0.3 + 0.4 * metal, metal])), ("normal", 0.5 + 0.5 * normal)):
        cv2.imwrite(str(folder / f"{name}.png"), np.rint(255.0 * pixels[..., ::-1]).astype(np.uint8))
    packed, normals = asset(folder / "arm.png"), asset(folder / "normal.png")
    maps = {
        "roughness": 1.0,
        "roughness_map": ChannelMap(asset=packed, channel="green"),
        "metallic": 1.0,
        "metallic_map": ChannelMap(asset=packed, channel="blue"),
        "normal_map": NormalMap(asset=normals),
        "repeats": 10.0,
    }
    material = scene.table.material.model_copy(update=maps)
    return scene.model_copy(update={"table": scene.table.model_copy(update={"material": material})})


NAMES = [
    "the caustic of a glass ball",
    "a prop under a slab of water",
    "colours between props",
    "glasses with liquid over a table",
    "a glossy table",
    "a table with maps of roughness, metalness and normals",
]


def _blocks(picture: np.ndarray) -> np.ndarray:
    height, width, _ = picture.shape
    return picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3, 4))


@pytest.mark.slow  # up to two minutes each
@pytest.mark.parametrize("name", NAMES)
def test_pictures_from_stored_light_agree_with_paths(backend, scenes, name) -> None:
    scene = scenes[name].model_copy(update={"picture": Picture(spp=SPP)})
    kernel = load(scene, for_cache=True)
    nodes, camera = cache_points_of(kernel), scene.cameras[0]
    pictures = []
    for seed in range(PASSES):
        tracer = cached_tracer(kernel, fill_cache(kernel, nodes, PATHS, 100 + seed))
        pair = (trace_picture(kernel, camera, "left", 2 * seed + k, e) for k, e in enumerate((PATH_TRACER, tracer)))
        pictures.append([_blocks(noisy.radiance.astype(np.float64)) for noisy in pair])
    paths, stored = np.array(pictures).transpose(1, 0, 2, 3)
    difference = stored.mean(0) - paths.mean(0)
    error = np.sqrt((stored.var(0, ddof=1) + paths.var(0, ddof=1)) / PASSES)
    # Two-sided, shared out over the blocks (Bonferroni); freedom of one side, the least that it can be.
    bound = student.ppf(1.0 - SIGNIFICANCE / 2.0 / difference.size, PASSES - 1) * error + BIAS * paths.mean(0)
    assert (np.abs(difference) <= bound).all(), (difference / paths.mean(0))[np.abs(difference) > bound]


@pytest.fixture(scope="module")
def furnace(backend, drawn, even_light):
    scene = drawn(
        2,
        vessel_count=(0, 0),
        prop_count=(0, 0),
        environment={"hdri_dir": even_light, "hdri_calibrated": True},
        lights={"max_count": 0},
    )
    return load(scene, for_cache=True)


def test_a_bare_table_in_even_light_has_the_moments_of_a_hemisphere(furnace) -> None:
    nodes = cache_points_of(furnace)
    moments = fill_cache(furnace, nodes, 64, 1).moments[: nodes.grid_count].astype(np.float64).mean(0)
    # Integrals over the hemisphere with c the cosine: of c, of c (1 - c)^5, and of c weighted with c or c (1 - c)^5.
    E, E_f = np.pi, np.pi / 21.0
    assert moments[:3] == pytest.approx(E, rel=2e-3)
    assert moments[3:6] == pytest.approx(E_f, rel=1e-2)
    assert moments[6:9] == pytest.approx([0.0, 0.0, 2.0 / 3.0], abs=2e-3)
    # (2 pi B(3, 6)) / (2 pi B(2, 6)) = 2 / 8 of the weight lies there.
    assert moments[9:12] == pytest.approx([0.0, 0.0, 0.25], abs=1e-2)


def test_stored_light_is_the_same_bit_for_bit(furnace) -> None:
    one, two = fill_scene_cache(furnace), fill_scene_cache(furnace)
    np.testing.assert_array_equal(one.moments, two.moments)


def test_auto_stores_the_light_of_many_samples_only(backend, drawn) -> None:
    few = drawn(2, vessel_count=(0, 0), prop_count=(0, 0))
    many = few.model_copy(update={"picture": Picture(spp=1 << 16)})
    assert not uses_cache(few)
    assert uses_cache(many)
    assert uses_cache(few.model_copy(update={"picture": Picture(light="shared")}))
    assert not uses_cache(many.model_copy(update={"picture": Picture(spp=1 << 16, light="path")}))


def test_stored_light_without_red_green_and_blue_is_refused() -> None:
    with pytest.raises(ValueError, match="light: expected path or auto"):
        Picture(light="shared", spectral=True)
