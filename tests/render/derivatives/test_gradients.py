"""Derivatives of the path-traced picture against closed forms and central differences with the same sample points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import AreaLight, PictureEnvironment
from glassware.render.derivatives import gradients
from glassware.render.derivatives.gradients import picture_and_gradients, picture_derivatives, with_parameters
from glassware.render.derivatives.replay import empty_tape, replay, slots_of
from glassware.render.pictures.integrator import trace
from glassware.render.pictures.picture import camera_paths, trace_picture
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole

#: The two pictures of a central difference are float32 sums: 2^-24 each, over a step that changes them by some 0.1 to
#: 1 %, and what the step leaves out is its square over 6. The project promises 1 %.
CENTRAL = 1e-3
#: Path lengths are float32 sums of ray distances; rays start 2^-20 of the scene off a face.
CLOSED_FORM = 1e-4
#: Standard errors that a right mean may be off; one in 15,000 is farther (normal law).
SIGMAS = 4.0
#: Without roulette, whose gambles a difference of two pictures would see flip, paths are the same at any absorption.
TO_THE_END = {"max_depth": 64, "rr_depth": 64}


@pytest.fixture(scope="module")
def looked_at(backend, panorama, optical_bench):
    """(index, absorption, roughness, panorama's pixels) -> a loaded slab before surroundings, seen along +y."""

    def make(eta, sigma_a, alpha, pixels, **picture):
        body = optical_bench.box((2.0, 0.05, 2.0), (0.0, 0.0, 3.0))
        camera = optical_bench.camera((0.0, -0.5, 3.0), (0.0, 0.0, 3.0), 8, 8, 16.0)
        scene = optical_bench.scene(body, optical_bench.medium(eta, sigma_a), camera)
        skin = scene.vessels[0].interfaces[0].model_copy(update={"roughness": alpha})
        vessel = scene.vessels[0].model_copy(update={"interfaces": (skin,)})
        # So small a board that next to no path meets it.
        board = Mesh("table", 1e-3 * scene.table.mesh.vertices, scene.table.mesh.faces)
        file = next(panorama(pixels).glob("*.exr"))
        update = {
            "vessels": (vessel,),
            "table": scene.table.model_copy(update={"mesh": board}),
            "environment": PictureEnvironment(asset=asset(file)),
            "picture": Picture.model_validate(TO_THE_END | picture),
        }
        return load(scene.model_copy(update=update))

    return make


@pytest.fixture(scope="module")
def bright_spot() -> np.ndarray:
    """A panorama with one soft light 10 degrees wide in the direction +y."""
    row, column = np.mgrid[:64, :128]
    elevation, azimuth = np.pi / 2 - np.pi * (row + 0.5) / 64, 2 * np.pi * (column + 0.5) / 128
    # Wherever azimuth 0 is, one of four lights a quarter turn apart is in view.
    away = (np.mod(azimuth + np.pi / 4, np.pi / 2) - np.pi / 4) ** 2 + elevation**2
    return np.repeat((0.2 + np.exp(-away / (2 * 0.17**2)))[..., None], 3, axis=2)


@pytest.fixture(scope="module")
def rough_scene(drawn):
    """Rough and smooth drawn vessels under the sky and two lamps, with default roulette."""
    camera = {"views": 1, "width": 32, "height": 24}
    scene = drawn(5, vessels={"fill_probability": 1.0, "chord_error": 2e-4, "rough_probability": 0.5}, cameras=camera)
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 1.5
    lamp = AreaLight(world_T_light=pose, size=(0.5, 0.5), radiance=(5.0, 4.0, 3.0))
    return scene.model_copy(update={"lights": (lamp, lamp.model_copy(update={"radiance": (1.0, 1.0, 8.0)}))})


@pytest.fixture
def rough_drawn(backend, rough_scene):
    """The same, loaded for one test: where another scene is in memory, kernels are compiled anew for the next."""
    return load(rough_scene)


def _left(kernel, seed: int = 3, spp: int | None = None):
    return picture_derivatives(kernel, kernel.description.cameras[0], "left", seed, spp)


def _endless(kernel):
    picture = kernel.description.picture.model_copy(update=TO_THE_END)
    return replace(kernel, description=kernel.description.model_copy(update={"picture": picture}))


def test_the_replay_walks_the_paths_of_the_picture(rough_drawn):
    import mitsuba as mi

    camera, picture = rough_drawn.description.cameras[0], rough_drawn.description.picture
    pixels = camera.width * camera.height
    pixel = np.arange(pixels, dtype=np.uint32)
    ray, _, points = camera_paths(pinhole(camera), pixel, 0 * pixel, 4, 4, 9)
    first = trace(rough_drawn, ray, mi.UnpolarizedSpectrum(1.0), points, picture).radiance
    again = replay(rough_drawn, ray, points, picture, empty_tape(slots_of(rough_drawn), first, first * 0.0))
    assert np.array(first).mean() > 0.0
    assert np.array_equal(np.array(again), np.array(first))


@pytest.mark.slow
def test_the_picture_is_the_one_that_is_rendered_with_evenly_spread_samples(rough_drawn):
    picture = rough_drawn.description.picture.model_copy(update={"adaptive": False})
    kernel = replace(rough_drawn, description=rough_drawn.description.model_copy(update={"picture": picture}))
    rendered = trace_picture(kernel, kernel.description.cameras[0], "left", 3).radiance
    np.testing.assert_allclose(_left(kernel).radiance, rendered, rtol=1e-5)


def test_light_through_a_liquid_falls_by_its_path_per_absorption(looked_at):
    sigma_a, depth = np.array([2.0, 20.0, 40.0]), 0.05
    kernel = looked_at(1.0, tuple(sigma_a), 0.0, np.ones((8, 16, 3)), spp=4)
    found = _left(kernel)
    # At index 1 there are no reflections: each ray crosses once, and its length tells L, so d L / d sigma = -length L.
    length = -np.log(found.radiance) / sigma_a
    assert length.min() >= depth * (1 - CLOSED_FORM)
    liquid = found.sigma_a[[medium.sigma_a[0] > 0 for medium in kernel.surfaces.media]][0]
    assert np.allclose(liquid, -length * found.radiance, rtol=5 * CLOSED_FORM)  # four rays of unlike length a pixel
    middle = np.s_[3:5, 3:5]
    assert np.allclose(liquid[middle], -depth * np.exp(-sigma_a * depth), rtol=0.01)  # 1 / cos and more within 1 %


def test_derivatives_by_absorption_are_the_central_differences(rough_drawn):
    kernel = _endless(rough_drawn)
    sigma_a = np.array([medium.sigma_a for medium in kernel.surfaces.media])
    found = _left(kernel).sigma_a
    step = 0.5  # [1/m]: paths through some centimetres of a medium are dimmed by some 1 %
    seen = 0
    for medium in range(1, len(sigma_a)):
        up, down = np.maximum(sigma_a, step), np.maximum(sigma_a, step)
        up[medium] += step
        down[medium] -= step
        middle = _left(with_parameters(kernel, sigma_a=(up + down) / 2)).sigma_a[medium].sum((0, 1))
        difference = (
            _left(with_parameters(kernel, sigma_a=up)).radiance - _left(with_parameters(kernel, sigma_a=down)).radiance
        ).sum((0, 1)) / (2 * step)
        np.testing.assert_allclose(middle, difference, rtol=CENTRAL)
        seen += int((found[medium] < 0).any())
    assert seen >= 3  # glass and liquids


def test_each_light_s_derivative_is_what_the_picture_gains_with_its_radiance(backend, rough_scene):
    scene, before = rough_scene, _left(load(rough_scene))
    np.testing.assert_allclose(before.environment + before.lights.sum(0), before.radiance, rtol=1e-5, atol=1e-6)
    brighter = scene.environment.model_copy(update={"strength": 2.0 * scene.environment.strength})
    after = _left(load(scene.model_copy(update={"environment": brighter})))
    np.testing.assert_allclose(after.radiance - before.radiance, before.environment, rtol=1e-5, atol=1e-5)
    for i, lamp in enumerate(scene.lights):
        lamps = list(scene.lights)
        lamps[i] = lamp.model_copy(update={"radiance": tuple(2.0 * value for value in lamp.radiance)})
        after = _left(load(scene.model_copy(update={"lights": tuple(lamps)})))
        assert before.lights[i].max() > 0.0
        np.testing.assert_allclose(after.radiance - before.radiance, before.lights[i], rtol=1e-5, atol=1e-5)


def test_gradients_are_the_derivative_images_weighted_by_the_adjoint(rough_drawn, rng):
    images = _left(rough_drawn)
    adjoint = rng.normal(size=images.radiance.shape)
    _, found = picture_and_gradients(rough_drawn, rough_drawn.description.cameras[0], "left", 3, adjoint)
    np.testing.assert_allclose(found.sigma_a, (images.sigma_a * adjoint).sum((1, 2)), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.alpha, (images.alpha * adjoint).sum((1, 2, 3)), rtol=1e-9)
    np.testing.assert_allclose(found.environment, (images.environment * adjoint).sum(), rtol=1e-9)
    np.testing.assert_allclose(found.lights, (images.lights * adjoint).sum((1, 2, 3)), rtol=1e-9)
    assert np.count_nonzero(found.alpha) >= 2


@pytest.mark.slow
def test_passes_give_the_same_derivatives_as_one(rough_drawn, monkeypatch):
    whole = _left(rough_drawn)
    monkeypatch.setattr(gradients, "_TAPE", 1)  # one sample a pass
    parts = _left(rough_drawn)
    # A ray beside other rays may round its hit another way, and in glass go another way: the picture shows where.
    same = np.isclose(parts.radiance, whole.radiance, rtol=1e-5).all(-1)
    assert same.mean() > 0.9
    # But for one thing: through clear media another way may bring the same light, and has another length.
    close = np.isclose(parts.sigma_a[:, same], whole.sigma_a[:, same], rtol=1e-4, atol=1e-6).all((0, 2))
    assert (~close).sum() <= 0.005 * same.sum()
    np.testing.assert_allclose(parts.lights[:, same], whole.lights[:, same], rtol=1e-5, atol=1e-6)


def test_in_an_even_environment_roughness_changes_nothing_and_its_derivative_has_no_noise(looked_at):
    kernel = looked_at(1.5, (0.0, 0.0, 0.0), 0.3, np.ones((8, 16, 3)), spp=8, max_depth=1024)
    assert np.abs(_left(kernel).alpha).max() < 1e-3


def _mean_and_error(values: list) -> tuple[float, float]:
    return float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values)))


def _by_roughness(kernel, alpha: float, seeds: range, spp: int) -> tuple[list, list]:
    """The derivative of the mean radiance, and the central difference, for each seed."""
    rough = np.array(kernel.surfaces.alpha) > 0

    def at(value: float):
        return with_parameters(kernel, alpha=np.where(rough, value, 0.0))

    # A step of a tenth leaves out up to (h / alpha)^2 / 6 of the derivative, 0.2 %.
    h, found, differences = 0.1 * alpha, [], []
    for seed in seeds:
        found.append(_left(at(alpha), seed, spp).alpha.sum(0).mean())
        up, down = (_left(at(alpha + step), seed, spp).radiance.mean() for step in (h, -h))
        differences.append((up - down) / (2 * h))
    return found, differences


@pytest.mark.parametrize("alpha", [pytest.param(0.1, marks=pytest.mark.slow), 0.3])
def test_derivatives_by_roughness_are_the_central_differences_within_their_noise(looked_at, bright_spot, alpha):
    kernel = looked_at(1.5, (1.0, 1.0, 1.0), alpha, bright_spot)
    found, differences = _by_roughness(kernel, alpha, range(12), 128)
    (one, error), (two, other) = _mean_and_error(found), _mean_and_error(differences)
    assert abs(one - two) < SIGMAS * np.hypot(error, other)
    assert SIGMAS * np.hypot(error, other) < 0.25 * abs(two)  # so a derivative that is a quarter off is found


@pytest.mark.slow
def test_derivatives_by_roughness_are_right_to_a_per_cent_or_so(looked_at, bright_spot):
    kernel = looked_at(1.5, (1.0, 1.0, 1.0), 0.2, bright_spot)
    found, differences = _by_roughness(kernel, 0.2, range(64), 1024)
    (one, error), (two, other) = _mean_and_error(found), _mean_and_error(differences)
    assert abs(one - two) < SIGMAS * np.hypot(error, other)
    assert np.hypot(error, other) < 0.01 * abs(two)


@pytest.mark.slow
def test_gradient_descent_finds_absorption_and_roughness_from_a_picture(looked_at, bright_spot):
    truth, rough = np.array([2.0, 8.0, 20.0]), 0.3
    kernel = looked_at(1.5, tuple(truth), rough, bright_spot)
    camera, inside = kernel.description.cameras[0], int(np.argmax(np.array(kernel.surfaces.sigma_a_rgb)) // 3)
    row = np.array(kernel.surfaces.alpha) > 0
    target = _left(kernel, 100, 1024).radiance
    guess, rates = np.array([10.0, 10.0, 10.0, 0.15]), np.array([1.0, 1.0, 1.0, 0.02])
    mean, square, steps = np.zeros(4), np.zeros(4), 40
    for step in range(steps):
        media = np.zeros((len(kernel.surfaces.media), 3))
        media[inside] = guess[:3]
        there = with_parameters(kernel, media, np.where(row, guess[3], 0.0))
        # The loss is the squared difference. Its adjoint comes from another seed, so that the gradient is right.
        adjoint = _left(there, 2 * step, 64).radiance - target
        _, found = picture_and_gradients(there, camera, "left", 2 * step + 1, adjoint, 64)
        gradient = np.append(found.sigma_a[inside], found.alpha.sum())
        # Adam (Kingma and Ba 2015, algorithm 1) with steps that shrink to nothing.
        mean, square = 0.8 * mean + 0.2 * gradient, 0.95 * square + 0.05 * gradient**2
        scaled = mean / (1 - 0.8 ** (step + 1)) / np.sqrt(square / (1 - 0.95 ** (step + 1)))
        guess = np.maximum(guess - rates * (1 - step / steps) * scaled, [0.0, 0.0, 0.0, 0.02])
    # The target's noise, some 0.1 % of each colour, is 0.02 [1/m] over 5 cm; roughness and a common darkening look much
    # alike in so narrow a picture, which magnifies it.
    np.testing.assert_allclose(guess[:3], truth, atol=0.5)
    assert abs(guess[3] - rough) < 0.01


def test_a_variant_without_colours_is_refused_by_name(rough_drawn, monkeypatch):
    import mitsuba as mi

    monkeypatch.setattr(mi, "is_rgb", False)
    with pytest.raises(InputError, match="derivatives: expected an RGB variant with AD"):
        _left(rough_drawn)


def test_wrong_requests_are_refused(rough_drawn):
    camera = rough_drawn.description.cameras[0]
    with pytest.raises(InputError, match="adjoint"):
        picture_and_gradients(rough_drawn, camera, "left", 3, np.ones((3, 4, 3)))
    with pytest.raises(InputError, match="spp"):
        _left(rough_drawn, spp=0)
    with pytest.raises(InputError, match="sigma_a"):
        with_parameters(rough_drawn, sigma_a=np.full((len(rough_drawn.surfaces.media), 3), -1.0))
    with pytest.raises(InputError, match="alpha"):
        with_parameters(rough_drawn, alpha=np.zeros(1))
