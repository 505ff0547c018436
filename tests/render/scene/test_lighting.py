"""Light arrives from where the description says, and as much of it as the light meter reads."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.procedural.description.surroundings import AreaLight, PictureEnvironment
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import irradiance
from glassware.procedural.surroundings.sphere import texel_directions
from glassware.render.pictures.picture import trace_picture
from glassware.render.scene.loaded_scene import load

#: Rows of the test map; one texel is 180 / 32 degrees high.
HEIGHT = 32
#: Monte Carlo: standard deviations that an estimate may be off.
SIGMAS = 4.5
#: The table samples a bilinear picture, the meter takes texels for even: relative difference for a map this coarse.
BILINEAR = 0.02


def _looking(camera, direction: np.ndarray):
    """The camera turned to look along a direction, high over the table."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = [0.0, 0.0, 3.0]
    return camera.model_copy(
        update={"world_T_camera": pose, "width": 65, "height": 65, "centre": (32.0, 32.0), "focal": 80.0}
    )


@pytest.fixture(scope="module")
def bare(drawn):
    """A table and nothing else."""
    return drawn(2, vessel_count=(0, 0), prop_count=(0, 0), lights={"max_count": 0}, cameras={"views": 1})


@pytest.mark.parametrize("rotation", [0.0, -2.0])
@pytest.mark.parametrize(("row", "column"), [(8, 3), (14, 40), (4, 63)])
def test_a_bright_texel_shines_from_its_own_direction(backend, bare, panorama, row, column, rotation):
    pixels = np.full((HEIGHT, 2 * HEIGHT, 3), 1e-3)
    pixels[row, column] = 100.0
    folder = panorama(pixels)
    environment = PictureEnvironment(asset=asset(folder / "map.exr"), rotation=rotation)
    baked = bake_environment(environment)[..., 0]
    at = np.unravel_index(baked.argmax(), baked.shape)
    x, y, z = texel_directions(HEIGHT)[at].astype(float)
    cos, sin = np.cos(rotation), np.sin(rotation)
    camera = _looking(bare.cameras[0], np.array([cos * x - sin * y, sin * x + cos * y, z]))
    kernel = load(bare.model_copy(update={"environment": environment, "cameras": (camera,)}))
    seen = trace_picture(kernel, camera, "left", seed=1).radiance[..., 0].astype(float)
    rows, columns = np.mgrid[:65, :65]
    centroid = np.array([(seen * rows).sum(), (seen * columns).sum()]) / seen.sum()
    # A texel is 8 px high here. Its centroid in the picture is off the middle by less than a twentieth of it: the
    # perspective stretches its far side, and the pixels are sampled.
    np.testing.assert_allclose(centroid, 32.0, atol=0.5)
    assert seen[32, 32] > 0.8 * 100.0  # the mean of a tent, 8 px wide, over the pixel in its middle


def _on_the_table(kernel, count: int = 1 << 16) -> tuple[np.ndarray, np.ndarray]:
    """Irradiance at the table's centre by emitter sampling, and its standard error, both (3,)."""
    import drjit as dr
    import mitsuba as mi

    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(5, count)
    patch = dr.zeros(mi.Interaction3f, count)
    patch.p = mi.Point3f(0.0, 0.0, 1e-4)
    found, arriving = kernel.mi_scene.sample_emitter_direction(patch, sampler.next_2d(), False)
    values = np.array(arriving * dr.maximum(found.d.z, 0.0)).T.astype(float)
    return values.mean(0), values.std(0) / np.sqrt(count)


def _light(position, target, size, radiance) -> AreaLight:
    z = np.subtract(target, position) / np.linalg.norm(np.subtract(target, position))
    x = np.cross([0.3, 1.0, 0.2], z)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = position
    return AreaLight(world_T_light=pose, size=size, radiance=radiance)


@pytest.mark.parametrize(
    "light",
    [
        _light((0.5, -0.8, 1.2), (0.0, 0.1, 0.0), (0.6, 0.3), (5.0, 4.0, 3.0)),
        _light((-0.2, 0.1, 0.5), (0.0, 0.0, 0.0), (0.9, 0.9), (1.0, 1.0, 2.0)),
        _light((0.4, 0.4, 0.3), (0.0, 0.0, 0.9), (0.2, 0.2), (9.0, 9.0, 9.0)),  # shines past the table
    ],
)
def test_a_lamp_lights_the_table_by_its_form_factor(backend, bare, panorama, light):
    dark = PictureEnvironment(asset=asset(panorama(np.full((8, 16, 3), 1e-9)) / "map.exr"))
    kernel = load(bare.model_copy(update={"environment": dark, "lights": (light,)}))
    measured, error = _on_the_table(kernel)
    expected = irradiance(bake_environment(dark), dark.strength, (light,))
    assert (np.abs(measured - expected) <= SIGMAS * error + 1e-6).all()


def test_the_environment_lights_the_table_as_the_meter_reads(backend, drawn):
    scene = drawn(4, vessel_count=(0, 0), prop_count=(0, 0), lights={"max_count": 0})
    environment = scene.environment.model_copy(update={"rotation": 1.1, "strength": 2.5})
    measured, error = _on_the_table(load(scene.model_copy(update={"environment": environment})))
    expected = irradiance(bake_environment(environment), environment.strength, ())
    assert (np.abs(measured - expected) <= SIGMAS * error + BILINEAR * expected).all()


def test_a_lamp_is_black_from_behind(backend, bare, panorama):
    even = PictureEnvironment(asset=asset(panorama(np.ones((8, 16, 3))) / "map.exr"))
    light = _light((0.0, 0.0, 5.0), (0.0, 0.0, 9.0), (0.5, 0.5), (50.0, 50.0, 50.0))
    camera = _looking(bare.cameras[0], np.array([0.0, 1e-3, 1.0]))
    kernel = load(bare.model_copy(update={"environment": even, "lights": (light,), "cameras": (camera,)}))
    seen = trace_picture(kernel, camera, "left", seed=1).radiance
    assert seen[32, 32].max() == 0.0
    assert seen[0, 0].min() > 0.9
