"""What a sensor makes of wavelengths, against integrals by NumPy and against the film of linear Rec.709."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.sensitivities import Sensitivities
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.optics.medium import Absorber, Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.surroundings.colour import RGB_FROM_XYZ
from glassware.render.backend.variant import activate
from glassware.render.pictures.picture import NoisyImage, final_pictures, trace_picture
from glassware.render.scene.loaded_scene import load

#: Wavelengths of curves and filters [nm]: Mitsuba's own steps.
NM = np.arange(360.0, 831.0, 5.0)
THICKNESS = 0.01
#: Largest difference of integrals over pictures of 64 x 2048 paths, of which each has a random error of about 0.5: six
#: standard errors, and linear steps of 5 nm.
PATHS = 0.01
#: Rounding of the matrix of XYZ to four digits, over the value.
FOUR_DIGITS = 2e-3


def bumps(centres: tuple[float, float, float], width: float) -> np.ndarray:
    """Curves of a sensor, (n, 3)."""
    return np.exp(-0.5 * ((NM[:, None] - np.array(centres)) / width) ** 2)


def sensor(curves: np.ndarray) -> Sensitivities:
    red, green, blue = (tuple(one.tolist()) for one in curves.T)
    identity = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    nm = tuple(NM.tolist())
    return Sensitivities(
        name="test", wavelengths=nm, red=red, green=green, blue=blue, white=(1.0, 1.0, 1.0), matrix=identity
    )


SENSOR = bumps((600.0, 540.0, 460.0), 30.0)
#: One that the eye is farther from: narrower than what it tells apart.
NARROW = bumps((590.0, 560.0, 460.0), 10.0)


@pytest.fixture(scope="module")
def spectral(backend):
    """The spectral variant, active; afterwards the one that all other tests expect."""
    yield activate(spectral=True)
    activate(backend)


@pytest.fixture(scope="module")
def light(spectral) -> np.ndarray:
    """D65 at `NM`, by Mitsuba's table, in the unit in which it is (1, 1, 1)."""
    import mitsuba as mi

    return np.array(mi.load_dict({"type": "d65"}).eval(at(NM))[0], np.float64)


@pytest.fixture(scope="module")
def observer(spectral) -> np.ndarray:
    """The observer at `NM`, (n, 3)."""
    import mitsuba as mi

    return np.array([np.array(one) for one in mi.cie1931_xyz(mi.Float(NM))], np.float64).T


def at(nm: np.ndarray):
    """A point that is seen at wavelengths."""
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, len(nm))
    si.wavelengths = type(si.wavelengths)(mi.Float(nm))
    return si


def filtered(transmittance: np.ndarray, curves: np.ndarray | None, **picture) -> Scene:
    """An even white sky behind a filter that does not bend light, seen by a camera whose rays are nearly parallel."""
    absorption = -np.log(transmittance) / THICKNESS
    own = Absorber(spectrum="own", amount=1.0, samples=tuple(zip(NM.tolist(), absorption.tolist(), strict=True)))
    medium = Medium(name="filter", eta=1.0, sigma_a=(0.0, 0.0, 0.0), absorbers=(own,))
    made = scenes.scene(
        [bodies.slab((0.4, THICKNESS, 0.4), medium, (0.0, 0.0, 0.5))],
        [scenes.camera((0.0, -0.5, 0.5), (0.0, 0.0, 0.5), width=8, height=8, focal=2000.0)],
        environment=ConstantEnvironment(),
        picture=Picture(spectral=True, light="path", **({"spp": 2048, "adaptive": False} | picture)),
    )
    return made.model_copy(update={"sensitivities": None if curves is None else sensor(curves)})


def traced(scene: Scene) -> NoisyImage:
    return trace_picture(load(scene), scene.cameras[0], "left", 1)


@pytest.fixture(scope="module")
def means(spectral) -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """(transmittance, curves) -> means of linear Rec.709 and of the raw response, (3,) each."""

    def of(transmittance: np.ndarray, curves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        image = traced(filtered(transmittance, curves))
        assert image.raw is not None
        return image.radiance.mean(axis=(0, 1)), image.raw[0].mean(axis=(0, 1))

    return of


def test_white_light_through_a_filter_gives_the_integral_over_that_of_white(means, light):
    narrow = 0.05 + 0.9 * np.exp(-0.5 * ((NM - 560.0) / 25.0) ** 2)
    _, raw = means(narrow, SENSOR)
    white = np.trapezoid(light[:, None] * SENSOR, NM, axis=0)
    expected = np.trapezoid((light * narrow)[:, None] * SENSOR, NM, axis=0) / white
    assert np.ptp(expected) > 0.3
    np.testing.assert_allclose(raw, expected, atol=PATHS)


def test_filters_that_look_alike_to_the_eye_differ_to_the_sensor_by_what_integrals_say(means, light, observer):
    seen = light[:, None] * observer
    bump = np.exp(-0.5 * ((NM - 590.0) / 15.0) ** 2)
    unseen = bump - seen @ np.linalg.lstsq(seen, bump, rcond=None)[0]  # a metameric black
    other = 0.5 + 0.4 * unseen / np.abs(unseen).max()
    (eye, raw), (same, changed) = means(np.full(len(NM), 0.5), NARROW), means(other, NARROW)
    np.testing.assert_allclose(same, eye, atol=PATHS)
    white = np.trapezoid(light[:, None] * NARROW, NM, axis=0)
    expected = np.trapezoid((light * (other - 0.5))[:, None] * NARROW, NM, axis=0) / white
    assert np.abs(expected).max() > 5 * PATHS
    np.testing.assert_allclose(changed - raw, expected, atol=PATHS)


def test_with_the_eyes_curves_raw_colours_are_those_of_rec709_sample_by_sample(spectral, light, observer):
    image = traced(filtered(0.1 + 0.8 * (NM > 550.0), observer, spp=8))
    assert image.raw is not None
    white = np.trapezoid(light[:, None] * observer, NM, axis=0)
    rgb = (image.raw[0] * (white / white[1])) @ RGB_FROM_XYZ.T
    np.testing.assert_allclose(rgb, image.radiance, atol=FOUR_DIGITS * image.raw[0].max())


def test_a_sensor_changes_nothing_of_the_picture_and_its_own_is_denoised_as_that_is(spectral):
    plain, seen = (traced(filtered(np.full(len(NM), 0.5), curves, spp=8)) for curves in (None, SENSOR))
    assert plain.raw is None
    assert np.array_equal(plain.radiance, seen.radiance)
    assert plain.sampling == seen.sampling
    clean, raw = final_pictures([seen, seen], Picture(denoise=False))
    assert raw is not None
    assert seen.raw is not None
    assert np.array_equal(raw[0], seen.raw[0])
    assert np.array_equal(clean[0], seen.radiance)
    assert final_pictures([plain, plain], Picture(denoise=False))[1] is None


def test_sensitivities_without_wavelengths_are_refused(backend):
    scene = filtered(np.full(len(NM), 0.5), SENSOR)
    activate("llvm_ad_rgb")
    try:
        with pytest.raises(InputError, match="scene, sensitivities: expected picture"):
            load(scene)
    finally:
        activate(spectral=True)


@pytest.mark.slow
def test_the_identity_holds_for_glass_with_dispersion_whose_paths_follow_one_wavelength(
    drawn, spectral, observer, light
):
    scene = drawn(31, picture={"spp": 16, "spectral": True, "dispersion": True, "light": "path"})
    image = traced(scene.model_copy(update={"sensitivities": sensor(observer)}))
    assert image.raw is not None
    white = np.trapezoid(light[:, None] * observer, NM, axis=0)
    rgb = (image.raw[0] * (white / white[1])) @ RGB_FROM_XYZ.T
    scale = np.abs(image.radiance).max(axis=2, keepdims=True)
    assert (np.abs(rgb - image.radiance) / scale).max() < 5 * FOUR_DIGITS  # negative channels take larger ones off
