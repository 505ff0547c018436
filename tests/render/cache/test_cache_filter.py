"""The filters of the irradiance cache remove noise and keep light, on the grid and on meshes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.render.cache.cache_filter import SPREAD, denoised_grid, denoised_meshes, diffusion_step
from glassware.render.cache.cache_points import Axis, CachePoints

#: float32 sums of means over squares.
ROUNDING = 1e-5
SHAPE = (96, 128)


@pytest.fixture
def noisy(backend, rng):
    """Moments of even light of 1 with a tenth of noise, and a firefly of a thousand."""
    moments = rng.normal(1.0, 0.1, (SHAPE[0] * SHAPE[1], 12)).astype(np.float32)
    moments[:, 6:] = 0.2
    moments[40 * SHAPE[1] + 50, :6] = 1000.0
    return moments


@pytest.fixture
def noise(rng):
    """Half differences of two halves whose mean has that noise: the firefly is in one of them."""
    noise = rng.normal(0.0, 0.1, (SHAPE[0] * SHAPE[1], 6)).astype(np.float32)
    noise[40 * SHAPE[1] + 50] = 1000.0
    return noise


def test_noise_goes_and_the_sum_of_the_light_stays(noisy, noise) -> None:
    found = denoised_grid(noisy, noise, np.zeros(len(noisy)), SHAPE)
    np.testing.assert_allclose(found[:, :6].sum(0, np.float64), noisy[:, :6].sum(0, np.float64), rtol=ROUNDING)
    far = found.reshape(*SHAPE, 12)[:, 100:, :6]
    # Two thirds at least: the denoiser leaves 0.0005 of 0.0057 where it was measured, a third of the deviation.
    assert far.std() < 0.1 / 3.0


def test_the_light_of_a_firefly_stays_near_it(noisy, noise) -> None:
    found = denoised_grid(noisy, noise, np.zeros(len(noisy)), SHAPE).reshape(*SHAPE, 12)[..., :6]
    reach = int(SPREAD * SHAPE[1] / 2) + 16  # the square, and what the filter itself reaches
    near = found[40 - reach : 41 + reach, 50 - reach : 51 + reach].sum((0, 1), np.float64)
    size = (2 * reach + 1) ** 2
    # A standard deviation of the noise that went into the square is 0.1 per cell; four of them.
    np.testing.assert_allclose(near, 1000.0 + size - 1, atol=4.0 * 0.1 * np.sqrt(size))


def test_light_that_is_not_noise_is_kept(noisy, noise) -> None:
    # A caustic: one cell wide, and found by both halves.
    row = np.s_[20 * SHAPE[1] + 70 : 20 * SHAPE[1] + 110]
    noisy[row, :6] += 50.0
    found = denoised_grid(noisy, noise, np.zeros(len(noisy)), SHAPE)
    # The noise of 0.1, and a hundredth of the light: the noise in the window is a thousandth of the caustic.
    np.testing.assert_allclose(found[row, :6], 51.0, atol=0.5 + 4.0 * 0.1)


def test_light_of_a_caustic_stays_within_a_few_cells(noisy, noise) -> None:
    # Photons of a hundred times the light in every tenth cell of a square: all noise to the filter.
    square, cells = np.s_[60:80, 20:40], np.arange(400).reshape(20, 20)
    light, spread, fraction = (x.reshape(*SHAPE, -1) for x in (noisy, noise, np.zeros(len(noisy))))
    photons = np.where(cells % 10 == 3, 100.0, 0.0)[..., None]
    light[square][..., :6] += photons
    spread[square] += photons
    fraction[square] = photons / (photons + 1.0)
    found = denoised_grid(noisy, noise, fraction.ravel(), SHAPE).reshape(*SHAPE, 12)[50:90, 10:50, :6]
    # Ten cells beyond the square are five standard deviations of the window: all of its light is there. (Noise of the
    # sum: 0.1 in each of 1,600 cells, four times; and a thousandth of the light, for the edge of the window.)
    np.testing.assert_allclose(found.sum((0, 1)), 1600 + 4000.0, atol=4.0 * 0.1 * 40 + 4.0)


def test_no_light_is_negative(noisy, noise) -> None:
    assert (denoised_grid(noisy, noise, np.zeros(len(noisy)), SHAPE)[:, :6] >= 0.0).all()


def _nodes(*meshes: trimesh.Trimesh, sides: int = 1):
    positions, normals, triangles, back, mesh = [], [], [], [], []
    first = 0
    for number, one in enumerate(meshes):
        triangles.append(one.faces + first)
        for side in range(sides):
            positions.append(one.vertices)
            normals.append((1 - 2 * side) * one.vertex_normals)
            back.append(np.full(len(one.vertices), side == 1))
            mesh.append(np.full(len(one.vertices), number))
        first += sides * len(one.vertices)
    axis, none = Axis(0.0, 0.0, 0.0, 0.0, 0.001), np.zeros(0, np.uint32)
    return CachePoints(
        axes=(axis, axis),
        positions=np.concatenate(positions),
        normals=np.concatenate(normals),
        triangles=np.concatenate(triangles),
        back=np.concatenate(back),
        mesh=np.concatenate(mesh),
        first_triangle=none,
        to_back=none,
    )


def _halves(light: np.ndarray, sigma: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Moments of two halves of the paths: grey light, each half with its own noise of `sigma` times the light."""
    rng = np.random.default_rng(seed)
    noise = sigma * light * rng.standard_normal((2, len(light)))
    first, second = ((light + n)[:, None] * np.ones(12) for n in noise)
    return first, second


def _dark(nodes) -> tuple[np.ndarray, np.ndarray]:
    """Paths that bring no light, beside photons."""
    return np.zeros((len(nodes.positions), 12)), np.zeros((len(nodes.positions), 12))


def _errors(nodes, light: np.ndarray, halves: tuple) -> tuple[np.ndarray, np.ndarray]:
    return denoised_meshes(nodes, halves)[:, 0] - light, 0.5 * (halves[0] + halves[1])[:, 0] - light


BALL = trimesh.creation.icosphere(subdivisions=5, radius=0.05)  # 10,242 vertices, 2 mm apart
AREA = np.bincount(BALL.faces.ravel(), np.repeat(BALL.area_faces / 3.0, 3))


def test_noise_on_a_ball_in_soft_light_falls_by_its_own_size() -> None:
    nodes, light = _nodes(BALL), 1.0 + 0.8 * BALL.vertex_normals[:, 2]
    after, before = _errors(nodes, light, _halves(light, 0.4))
    # Smoothing over dozens of vertices leaves a few per cent of the variance; a tenth is asked for.
    assert np.mean(after**2) < 0.1 * np.mean(before**2)


def test_the_mean_over_the_surface_stays() -> None:
    nodes, light = _nodes(BALL), 1.0 + 0.8 * BALL.vertex_normals[:, 2]
    after, before = _errors(nodes, light, _halves(light, 0.4))
    # Each step gives one vertex what it takes from another: only rounding is left.
    assert abs(np.sum(AREA * (after - before)) / np.sum(AREA * light)) < ROUNDING


def test_without_noise_nothing_changes() -> None:
    light = 1.0 + 0.8 * BALL.vertex_normals[:, 2]
    after, _ = _errors(_nodes(BALL), light, _halves(light, 0.0))
    np.testing.assert_allclose(after, 0.0, atol=1.8 * ROUNDING)  # the scales add up again, to rounding


def test_the_edge_of_a_shadow_stays_sharp() -> None:
    nodes, light = _nodes(BALL), np.where(BALL.vertices[:, 2] > 0.01, 1.0, 0.1)
    after, before = _errors(nodes, light, _halves(light, 0.1))
    edge = np.abs(BALL.vertices[:, 2] - 0.01) < 0.003
    # There the light stands out of the noise, so little is taken off: the error stays near the noise's own, and is a
    # small part of what the first three steps would make of the edge if they knew nothing of noise.
    step = diffusion_step(nodes)
    blurred = step @ (step @ (step @ light)) - light
    assert np.mean(after[edge] ** 2) < 1.1 * np.mean(before[edge] ** 2)
    assert np.mean(after[edge] ** 2) < 0.1 * np.mean(blurred[edge] ** 2)
    assert np.mean(after[~edge] ** 2) < 0.2 * np.mean(before[~edge] ** 2)


def test_a_firefly_is_spread_and_its_light_kept() -> None:
    light = np.ones(len(BALL.vertices))
    first, second = _halves(light, 0.0)
    first[17] += 2000.0

    found = denoised_meshes(_nodes(BALL), (first, second))[:, 0]
    # A thousand times a vertex's share, on the side of the ball that faces as it does; nothing on the other.
    towards = BALL.vertex_normals @ BALL.vertex_normals[17]
    assert found.max() < 1.0 + 1000.0 * 8.0 * AREA[17] / AREA.sum()
    assert found[towards > 0.9].mean() > 1.0 + 1000.0 * AREA[17] / AREA.sum()
    np.testing.assert_allclose(found[towards < -0.9], 1.0, rtol=ROUNDING)
    assert np.sum(AREA * found) == pytest.approx(AREA.sum() + 1000.0 * AREA[17], rel=ROUNDING)


@pytest.mark.parametrize("sides", [1, 2])
def test_meshes_and_sides_keep_their_own_light(sides) -> None:
    other = BALL.copy()
    other.apply_translation([0.0005, 0.0, 0.0])
    nodes = _nodes(BALL, other, sides=sides)
    light = np.repeat([1.0, 5.0, 20.0, 100.0][: 2 * sides], len(BALL.vertices))
    first, second = _halves(light, 0.0)
    # (Noise everywhere, of one sign by half: all of each scale is taken off, and nothing is left of any detail.)

    found = denoised_meshes(nodes, (1.2 * first, 0.8 * second))[:, 0]
    np.testing.assert_allclose(found, light, rtol=ROUNDING)


def test_the_hidden_side_of_a_thin_plate_takes_no_light_of_its_lit_side() -> None:
    """The back of a plate's lower face, inside of it, is at 2 mm and faces as its upper face does."""
    plate = trimesh.creation.box((0.06, 0.06, 0.002))
    for _ in range(4):
        plate = plate.subdivide()
    nodes = _nodes(plate, sides=2)
    light = np.where(nodes.back, 0.0, 0.5 + 0.5 * np.sign(np.round(nodes.normals[:, 2], 1)))
    found = denoised_meshes(nodes, _dark(nodes), _halves(light, 0.5))[:, 0]
    assert (found[nodes.back] == 0.0).all()
    area = np.bincount(plate.faces.ravel(), np.repeat(plate.area_faces / 3.0, 3))
    mean = np.mean(_halves(light, 0.5), axis=0)[:, 0]
    assert np.sum(area * found[~nodes.back]) == pytest.approx(np.sum(area * mean[~nodes.back]), rel=1e-4)


def test_photons_are_smoothed_and_stay_where_they_land() -> None:
    """Half of a ball is lit by two photons a vertex and half of them, the other half by none."""
    nodes, rng = _nodes(BALL), np.random.default_rng(3)
    light = np.where(BALL.vertices[:, 2] > 0.0, 1.0, 0.0)
    first, second = ((rng.poisson(2.0 * light) / 2.0)[:, None] * np.ones(12) for _ in range(2))
    found = denoised_meshes(nodes, _dark(nodes), (first, second))[:, 0]
    before = 0.5 * (first + second)[:, 0]
    lit, dark = BALL.vertices[:, 2] > 0.01, BALL.vertices[:, 2] < -0.02
    # As on the ball in soft light: a few per cent of the variance are left. Two centimetres from the edge is no photon.
    assert np.mean((found - light)[lit] ** 2) < 0.1 * np.mean((before - light)[lit] ** 2)
    assert found[dark].max() < 0.02
    # At the edge of the shadow details below 0 are cut off, which adds a little light.
    assert np.sum(AREA * found) == pytest.approx(np.sum(AREA * before), rel=5e-3)
