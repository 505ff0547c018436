"""Stokes vectors of a renderer's views: against Fresnel's equations, and colour by colour against the picture."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.polarisation import angle_of_linear_polarisation, degree_of_linear_polarisation
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.render.backend.variant import activate
from glassware.render.renderer import Renderer

GLASS, TOP = 1.5, 0.05
ANGLES = (np.radians(30.0), np.arctan(GLASS), np.radians(75.0))


def plate_reflectances(theta: float) -> tuple[float, float]:
    """Reflectance of a plate across and along the plane of incidence, with all light between its faces: 2R/(1+R)."""
    inside = np.arcsin(np.sin(theta) / GLASS)
    Rs = (np.sin(theta - inside) / np.sin(theta + inside)) ** 2
    Rp = (np.tan(theta - inside) / np.tan(theta + inside)) ** 2
    return 2 * Rs / (1 + Rs), 2 * Rp / (1 + Rp)


@pytest.fixture(scope="module")
def plate(panorama):
    """A wide plate of glass under a ceiling of another radiance in each colour, above nothing; seen at three angles."""
    sky = np.zeros((16, 32, 3))
    sky[:8] = (1.0, 0.5, 0.25)
    place = np.array([1.0, 0.0, TOP])
    eyes = [place + np.array([-np.sin(angle), 0.0, np.cos(angle)]) for angle in ANGLES]
    return scenes.scene(
        [bodies.slab((16.0, 16.0, 0.02), Medium(name="glass", eta=GLASS), (0.0, 0.0, TOP - 0.01))],
        [scenes.camera(tuple(eye), tuple(place), width=33, height=25, focal=400.0) for eye in eyes],
        table=scenes.board((0.001, 0.001, 0.001)),
        environment=PictureEnvironment(asset=asset(panorama(sky) / "map.exr")),
        picture=Picture(spp=4, light="path"),
    )


@pytest.fixture(scope="module")
def views(backend, plate):
    activate(backend)
    renderer = Renderer(plate)
    found = [renderer.stokes(k, samples=256) for k in range(len(ANGLES))]
    assert renderer.variant == backend == activate()  # the renderer goes on in its own variant
    return found


def test_a_plate_reflects_as_fresnels_equations_say(views):
    for angle, picture in zip(ANGLES, views, strict=True):
        across, along = plate_reflectances(float(angle))
        s0, s1, s2, s3 = picture.vector.mean((0, 1)) / np.array([1.0, 0.5, 0.25])
        np.testing.assert_allclose(s0, (across + along) / 2, rtol=0.01)
        np.testing.assert_allclose(s1, (across - along) / 2, rtol=0.01)
        assert np.abs([s2, s3]).max() < 0.005 * s0.max()
        degree = degree_of_linear_polarisation(picture.vector.mean((0, 1)))
        np.testing.assert_allclose(degree, (across - along) / (across + along), rtol=0.01)


def test_light_mirrored_at_brewsters_angle_is_polarised_along_the_plate(views):
    middle = views[1].vector[12, 16]
    np.testing.assert_allclose(degree_of_linear_polarisation(middle), 1.0, atol=1e-4)
    np.testing.assert_allclose(angle_of_linear_polarisation(middle), 0.0, atol=1e-2)


def test_no_vector_is_longer_than_light_can_be(views):
    for picture in views:
        length = np.sqrt((picture.vector[..., 1:, :].astype(np.float64) ** 2).sum(-2))
        assert (length <= picture.vector[..., 0, :] * (1 + 1e-5)).all()


def test_errors_are_those_of_the_paths_that_choose_a_lobe(views):
    """Pixels of one value: their spread is the error that each states, in the mean over the picture."""
    light = views[1].vector[..., 0, :] @ [0.2126, 0.7152, 0.0722]
    assert np.sqrt((views[1].error[..., 0] ** 2).mean()) == pytest.approx(light.std(), rel=0.5)


def test_a_view_needs_a_number_of_samples(backend, plate):
    activate(backend)
    with pytest.raises(InputError, match=r"polarisation_camera: expected one.*found none"):
        Renderer(plate).stokes(0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_colours_of_a_view_are_those_of_the_picture(backend, drawn, seed):
    """Also in a room, whose light is that of the picture: each channel, on opaque things, within 2 %."""
    activate(backend)
    scene = drawn(
        seed,
        environment={"room_share": 1.0, "shipped_share": 0.0, "room_depth": True},
        cameras={"views": 1, "width": 64, "height": 48},
        picture={"spp": 64, "light": "path"},
    )
    renderer = Renderer(scene)
    assert renderer.loaded.room is not None
    frame, stokes = renderer.frame(0), renderer.stokes(0, samples=512)
    picture = frame.left if frame.left_noisy is None else frame.left_noisy
    opaque = np.isfinite(frame.geometry.Z) & ~np.isin(frame.geometry.id, [body.id for body in scene.vessels])
    expected, found = (light[opaque].mean(0) for light in (picture, stokes.vector[..., 0, :]))
    np.testing.assert_allclose(found, expected, rtol=0.02)
    assert np.ptp(expected / expected.mean()) > 0.02  # it has a colour
    outside = frame.geometry.id >= 65248  # surfaces of the room: where they are in the picture
    apart = np.abs(stokes.vector[..., 0, 1] - picture[..., 1])[outside] / picture[..., 1][outside]
    assert np.median(apart) < 0.03
