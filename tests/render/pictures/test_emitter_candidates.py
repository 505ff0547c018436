"""Lamps in rough metal: the right light, against an integral and against other samples, and less noise than before."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
from scipy.stats import kstest

from glassware.core.assets import asset
from glassware.core.pose import aimed_frame
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import AreaLight, PictureEnvironment
from glassware.procedural.primitives import scenes
from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.trace_cached import cached_tracer
from glassware.render.pictures.emitter_candidates import chosen_candidate
from glassware.render.pictures.picture import PATH_TRACER, camera_paths
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole

#: Samples of a pixel, and standard errors that a mean may be off.
SAMPLES, STANDARD_ERRORS = 128, 3.0
ALPHA, COLOUR = 0.35**2, (0.9, 0.6, 0.3)
STEEL = OpaqueMaterial(
    name="steel", base_colour=UniformTexture(colour=COLOUR), roughness=float(np.sqrt(ALPHA)), metallic=1.0
)
#: Lamps of 10 cm on four sides, of which the eye sees one in the metal.
PLACES = np.array([[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]])
LAMPS = tuple(
    AreaLight(
        world_T_light=aimed_frame(place, -place / np.linalg.norm(place), np.array([-place[1], place[0], 0.0]), 0.0),
        size=(0.1, 0.1),
        radiance=(100.0, 80.0, 60.0),
    )
    for place in PLACES
)

#: Ways that surfaces are lit. Filling the irradiance cache takes its time.
WAYS = pytest.mark.parametrize("stored", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["paths", "stored"])


def _scene(lights=(), environment=None):
    camera = scenes.camera((0.5, 0.0, 0.5), width=8, height=6, focal=100.0)
    dark = scenes.scene((), (camera,)).environment.model_copy(update={"strength": 1e-6})
    board = scenes.board((0.12, 0.12, 0.01), STEEL)
    return scenes.scene((), (camera,), table=board, lights=lights, environment=environment or dark, picture=Picture())


def _samples(kernel, tracer, seed: int) -> np.ndarray:
    """Return the radiance of every sample, (pixels, SAMPLES, 3)."""
    camera = kernel.description.cameras[0]
    pixel = np.arange(camera.width * camera.height, dtype=np.uint32)
    ray, weight, points = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), SAMPLES, SAMPLES, seed)
    found = tracer.trace(kernel, ray, weight, points, kernel.description.picture)
    return np.array(found.radiance, np.float64).T.reshape(len(pixel), SAMPLES, 3)


def _stored(kernel):
    return cached_tracer(kernel, fill_cache(kernel, cache_points_of(kernel), 1, 1))


def _mean(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean colour of a picture and its standard error, as if samples were independent."""
    return samples.mean((0, 1)), np.sqrt(samples.var(1).sum(0) / SAMPLES) / len(samples)


def _reflected(eye: np.ndarray, lamp: AreaLight) -> np.ndarray:
    """Return what metal at the origin reflects of a lamp towards an eye, by Cook and Torrance with GGX, (3,)."""
    u, v = ((np.mgrid[:96, :96] + 0.5) / 96 - 0.5).reshape(2, -1)
    pose, area = lamp.world_T_light, lamp.size[0] * lamp.size[1] / u.size
    away = pose[:3, 3] + np.outer(u * lamp.size[0], pose[:3, 0]) + np.outer(v * lamp.size[1], pose[:3, 1])
    r2 = (away**2).sum(1)
    wo, wi = away / np.sqrt(r2)[:, None], eye / np.linalg.norm(eye)
    half = (wo + wi) / np.linalg.norm(wo + wi, axis=1)[:, None]
    D = ALPHA**2 / np.pi / (half[:, 2] ** 2 * (ALPHA**2 - 1.0) + 1.0) ** 2

    def smith(cos: np.ndarray) -> np.ndarray:
        return 2.0 / (1.0 + np.sqrt(1.0 + ALPHA**2 * (1.0 / cos**2 - 1.0)))

    fresnel = np.array(COLOUR) + (1.0 - np.array(COLOUR)) * ((1.0 - half @ wi) ** 5)[:, None]
    lobe = D * smith(wo[:, 2]) * smith(wi[2]) / (4.0 * wi[2])
    solid_angle = area * -(wo @ pose[:3, 2]) / r2
    return (fresnel * (lobe * solid_angle)[:, None]).sum(0) * np.array(lamp.radiance)


@pytest.fixture(scope="module")
def lamps(backend):
    return load(_scene(LAMPS), for_cache=True)


@pytest.mark.parametrize("count", [1, 5, 16])
def test_the_chosen_sample_has_the_mean_of_all_and_leaves_a_uniform_number(backend, count) -> None:
    import drjit as dr
    import mitsuba as mi

    u, v, w = (mi.Float(x) for x in np.random.default_rng(count).uniform(size=(3, 100_000)).astype(np.float32))

    def reflected(at: mi.Point2f) -> mi.Float:  # a lamp in a tenth of the square: the mean is 0.1 / 3
        return dr.select(at.x < 0.1, dr.square(at.y), 0.0)

    chosen = chosen_candidate(mi.Point2f(u, v), w, dr.opaque(mi.UInt32, count), reflected)
    found = np.array(chosen.weight * reflected(chosen.u), np.float64)
    assert abs(found.mean() - 0.1 / 3.0) < STANDARD_ERRORS * found.std() / np.sqrt(found.size)
    assert kstest(np.array(chosen.left, np.float64), "uniform").pvalue > 1e-3


@WAYS
def test_a_lamp_in_rough_metal_is_as_bright_as_the_integral_over_it(lamps, stored) -> None:
    mean, error = _mean(_samples(lamps, _stored(lamps) if stored else PATH_TRACER, seed=1))
    camera = lamps.description.cameras[0]
    rays = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), -1).reshape(-1, 2) - camera.centre
    d = np.column_stack([rays / camera.focal, np.ones(len(rays))]) @ camera.world_T_camera[:3, :3].T
    eye = camera.world_T_camera[:3, 3]
    points = eye - d * (eye[2] / d[:, 2])[:, None]
    expected = np.zeros(3)
    for point in points:
        for lamp in LAMPS:
            pose = lamp.world_T_light.copy()
            pose[:3, 3] -= point
            expected += _reflected(eye - point, lamp.model_copy(update={"world_T_light": pose})) / len(points)
    assert (error < 0.01 * expected).all()
    assert (np.abs(mean - expected) < STANDARD_ERRORS * error).all(), (mean, expected, error)


def _alone(monkeypatch, scene, for_cache: bool = False):
    """Load a scene with one candidate for all surfaces."""
    with monkeypatch.context() as patch:
        patch.setattr(importlib.import_module("glassware.render.scene.bodies"), "METAL_CANDIDATES", 1)
        kernel = load(scene, for_cache=for_cache)
    assert kernel.surfaces.candidates is None
    return kernel


def _compared(many, one, tracers) -> tuple[np.ndarray, float]:
    """Return by how many standard errors the means differ, and the variance of one candidate over that of many."""
    samples = [
        _samples(kernel, tracer, seed) for seed, (kernel, tracer) in enumerate(zip((many, one), tracers, strict=True))
    ]
    (a, error_a), (b, error_b) = map(_mean, samples)
    return np.abs(a - b) / np.hypot(error_a, error_b), float((error_b / error_a).mean() ** 2)


@WAYS
def test_several_candidates_take_the_noise_of_lamps_in_rough_metal(lamps, monkeypatch, stored) -> None:
    one = _alone(monkeypatch, lamps.description, for_cache=True)
    tracers = [_stored(kernel) if stored else PATH_TRACER for kernel in (lamps, one)]
    off, gain = _compared(lamps, one, tracers)
    assert (off < STANDARD_ERRORS).all()
    # One sample in five is of the lamp that is mirrored; of eight on a lattice one or two always are: 37 times less.
    assert gain > 15.0


@pytest.mark.slow
@pytest.mark.parametrize("stored", [False, True], ids=["paths", "stored"])
def test_several_candidates_take_the_noise_of_a_bright_window_of_a_map(backend, panorama, monkeypatch, stored) -> None:
    pixels = np.full((32, 64, 3), 0.05)
    for row, column in ((8, 0), (8, 16), (8, 32), (8, 48)):  # 45 degrees up, all around
        pixels[row, column : column + 2] = 30.0
    scene = _scene((), PictureEnvironment(asset=asset(panorama(pixels) / "map.exr")))
    many, one = load(scene, for_cache=True), _alone(monkeypatch, scene, for_cache=True)
    off, gain = _compared(many, one, [_stored(kernel) if stored else PATH_TRACER for kernel in (many, one)])
    assert (off < STANDARD_ERRORS).all()
    # 17 times less here.
    assert gain > 8.0
