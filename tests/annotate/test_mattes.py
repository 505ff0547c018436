"""Soft mattes against closed forms: silhouettes of a ball and of a block, and what a ball of glass lets through."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.mattes import SAMPLES, sample_places, soft_mattes
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball, box_mesh
from glassware.procedural.primitives.scenes import block, camera, matte, scene
from glassware.render.renderer import Renderer

#: Strong enough to see the length of the path [1/m].
GREEN = Medium(name="green glass", eta=1.52, sigma_a=(20.0, 4.0, 10.0))
RADIUS, CENTRE = 0.03, np.array([-0.04, 0.0, 0.05])
#: The block, one corner of it towards the camera, is a body of the frame of its own centre.
SIDES, PLACE = np.array([0.04, 0.03, 0.06]), np.array([0.045, 0.01, 0.04])
#: Rays of a pixel in closed form, along each side: fractions of edges are exact to some thousandths.
FINE = 24


@pytest.fixture(scope="module")
def made(backend):
    glass = ball(RADIUS, GREEN, tuple(CENTRE), chord_error=1e-5)
    solid = block(box_mesh(tuple(SIDES), centre=tuple(PLACE)), matte(), id=3)
    view = camera((0.1, -0.3, 0.15), (0.0, 0.0, 0.045), width=48, height=36)
    made = scene([glass], [view], props=[solid])
    renderer = Renderer(made, "llvm_ad_rgb")
    return made, view, renderer, soft_mattes(renderer, 0)


def _rays(view, places):
    """Return the directions of rays through places of every pixel, (H, W, n, 3), world frame, not normalised."""
    v, u = np.mgrid[: view.height, : view.width]
    x = (u[..., None] + places[:, 0] - view.centre[0]) / view.fx
    y = (v[..., None] + places[:, 1] - view.centre[1]) / view.fy
    return np.stack([x, y, np.ones_like(x)], axis=-1) @ view.world_T_camera[:3, :3].T


def _grid(count):
    return (np.indices((count, count)).reshape(2, -1).T + 0.5) / count - 0.5


def _sine(view, rays):
    """Return the sine of the angle at which rays meet the ball, over 1 for those that pass it."""
    unit = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    return np.linalg.norm(np.cross(unit, CENTRE - view.world_T_camera[:3, 3]), axis=-1) / RADIUS


def _reflectance(angle):
    """Return Fresnel's reflectance of unpolarised light that enters the glass at an angle [rad]."""
    inside = np.sqrt(1.0 - (np.sin(angle) / GREEN.eta) ** 2)
    across = (np.cos(angle) - GREEN.eta * inside) / (np.cos(angle) + GREEN.eta * inside)
    along = (GREEN.eta * np.cos(angle) - inside) / (GREEN.eta * np.cos(angle) + inside)
    return 0.5 * (across**2 + along**2)


def _meets_block(view, rays):
    eye = view.world_T_camera[:3, 3]
    with np.errstate(divide="ignore"):
        ends = [(PLACE + side * SIDES / 2 - eye) / rays for side in (-1, 1)]
    near, far = np.minimum(*ends).max(axis=-1), np.maximum(*ends).min(axis=-1)
    return near < far


@pytest.mark.parametrize("item", ["ball", "block"])
def test_coverage_is_the_area_of_the_silhouette(made, item):
    _, view, _, mattes = made
    rays = _rays(view, _grid(FINE))
    exact = (_sine(view, rays) < 1.0 if item == "ball" else _meets_block(view, rays)).mean(axis=-1)
    found = mattes.coverage[["ball", "block"].index(item)]
    edge = (exact > 0.0) & (exact < 1.0)
    assert edge.sum() > 30
    np.testing.assert_array_equal(found[~edge], exact[~edge])
    # A straight edge cuts off the right number of 16 stratified points, or one or two more or less.
    away = found[edge] - exact[edge]
    assert np.abs(away).max() < 2.5 / SAMPLES
    assert np.sqrt((away**2).mean()) < 0.8 / SAMPLES
    assert found.sum() == pytest.approx(exact.sum(), rel=5e-3)


def test_first_surfaces_and_the_table_fill_the_pixel(made):
    _, _, renderer, mattes = made
    total = np.sum([*mattes.first.values()], axis=0)
    assert total.max() <= 1.0
    ids = renderer.geometry(0).id
    inside = mattes.first[1] == 1.0
    assert (ids[inside] == 1).all()
    # Nothing is in front of either body, so each is the first surface where it covers a pixel.
    for place, number in enumerate(mattes.ids):
        np.testing.assert_array_equal(mattes.first[number], mattes.coverage[place])


def test_the_ball_passes_on_what_fresnel_and_beer_lambert_leave(made):
    _, view, _, mattes = made
    sine = _sine(view, _rays(view, sample_places(SAMPLES)))
    inside = (sine < 0.95).all(axis=-1)
    angle = np.arcsin(np.minimum(sine[inside], 1.0))
    chord = 2.0 * RADIUS * np.sqrt(1.0 - (np.sin(angle) / GREEN.eta) ** 2)
    through = (1.0 - _reflectance(angle)) ** 2
    exact = (through[..., None] * np.exp(-chord[..., None] * np.array(GREEN.sigma_a))).mean(axis=1)
    np.testing.assert_allclose(mattes.transmittance[0][inside], exact, rtol=5e-3)


def test_an_opaque_body_passes_on_nothing_and_what_covers_nothing_all(made):
    _, _, _, mattes = made
    covered = mattes.coverage > 0.0
    assert (mattes.transmittance[1][covered[1]] == 0.0).all()
    assert (mattes.transmittance[~covered] == 1.0).all()


def test_with_one_ray_the_product_is_the_transmittance_of_the_pixel_centre(made):
    _, _, renderer, _ = made
    geometry, one = renderer.geometry(0), soft_mattes(renderer, 0, 1)
    np.testing.assert_array_equal(one.coverage > 0.0, geometry.reached)
    np.testing.assert_allclose(one.transmittance[0], geometry.transmittance, atol=1e-6)


@pytest.mark.parametrize("count", [1, 4, 16, 64, 256])
def test_places_are_stratified_in_both_axes_and_in_squares(count):
    places = sample_places(count)
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=1e-12)
    for axis in (0, 1):
        assert sorted(np.floor((places[:, axis] + 0.5) * count).astype(int)) == list(range(count))
    side = round(count**0.5)
    assert len(np.unique(np.floor((places + 0.5) * side), axis=0)) == count


def test_other_numbers_of_rays_are_refused():
    for count in (0, 3, 512):
        with pytest.raises(ValueError, match="a power of two"):
            sample_places(count)
