from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.dataset.depth_cameras.measure import measured
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS
from glassware.render.infrared.pattern import blue_noise, pattern_map

#: Height of the cameras above the board [m].
HEIGHT = 0.6


def device(width: int = 64, height: int = 48, focal: float = 60.0, **projector: object) -> DepthCamera:
    """The D435 with another picture, without blur, and a projector of wide dots beside it."""
    known = DEPTH_CAMERAS["d435"]
    imager = known.imager.model_copy(update={"width": width, "height": height, "focal": focal, "centre": None})
    changed = known.projector.model_copy(update={"dots": 60, "dot": 0.08, "turn": 0.0} | projector)
    return known.model_copy(update={"imager": imager, "projector": changed, "samples": 64})


def above(camera_size: tuple[int, int] = (32, 24), glass=(), props=(), sensor: DepthCamera | None = None) -> Scene:
    camera = scenes.camera((0.0, 0.0, HEIGHT), width=camera_size[0], height=camera_size[1])
    scene = scenes.scene(
        glass,
        [camera],
        props=props,
        table=scenes.board((4.0, 4.0, 0.02), scenes.matte()),
        environment=ConstantEnvironment(strength=0.05),
        picture=Picture(spp=4, light="path", denoise=False, refraction=False, layers=0),
    )
    return scene.model_copy(update={"depth_camera": sensor or device()})


def fresnel(cos: np.ndarray, n: float) -> np.ndarray:
    """Reflectance from air of unpolarised light."""
    inner = np.sqrt(1.0 - (1.0 - cos**2) / n**2)
    s, p = (cos - n * inner) / (cos + n * inner), (n * cos - inner) / (n * cos + inner)
    return 0.5 * (s**2 + p**2)


@dataclass(frozen=True)
class Seen:
    dots: np.ndarray
    lit: np.ndarray


def seen(scene: Scene) -> Seen:
    from glassware.render.renderer import Renderer

    infrared = Renderer(scene).frame(0).infrared
    assert infrared is not None
    return Seen(infrared.dots[0], infrared.lit)


def test_dots_are_apart_and_have_the_power_of_the_projector():
    half = np.array([0.9, 0.5])
    dots = blue_noise(500, half, stream(1, 0, "test"))
    apart = np.linalg.norm(dots[:, None] - dots[None], axis=-1) + 9.0 * np.eye(500)
    cell = np.sqrt(4 * half.prod() / 500)
    assert apart.min() > 0.69 * cell
    assert (np.abs(dots) <= half).all()
    assert np.median(apart.min(axis=1)) < 0.95 * cell  # no holes
    projector = DEPTH_CAMERAS["d435"].projector
    pattern = pattern_map(projector, 0, "d435")
    assert pattern.density.sum() * pattern.step**2 == pytest.approx(projector.power, rel=1e-5)
    assert pattern_map(projector, 0, "d435").density is pattern.density
    assert not np.array_equal(pattern_map(projector, 1, "d435").density[:400, :700], pattern.density[:400, :700])


def test_light_through_two_faces_keeps_one_minus_fresnel_squared_and_what_is_not_absorbed(backend):
    n, thick, sigma, side = 1.5, 0.02, 12.0, 0.4
    # The projector stands beside the cameras, and the slab under it alone.
    sensor = device(place=side, field=(1.2, 1.2))
    x, y, _ = sensor.world_T_projector(above().cameras[0])[:3, 3]
    glass = Medium(name="glass", eta=n, sigma_a=(sigma,) * 3)
    slab = bodies.slab((0.3, 0.3, thick), glass, (float(x), float(y), HEIGHT - 0.1))
    bare, through = seen(above(sensor=sensor)), seen(above(glass=(slab,), sensor=sensor))
    (cx, cy), focal = sensor.centre, sensor.imager.focal
    rows, columns = np.indices(bare.dots.shape)
    x, y = HEIGHT * (columns - cx) / focal - side, HEIGHT * (rows - cy) / focal
    cos = HEIGHT / np.sqrt(x**2 + y**2 + HEIGHT**2)
    expected = (1 - fresnel(cos, n)) ** 2 * np.exp(-sigma * thick / np.sqrt(1 - (1 - cos**2) / n**2))
    # Where the shadow ray passes both faces of the slab and the camera's ray passes beside it.
    at = np.maximum(np.abs(x), np.abs(y)) * 0.1 / HEIGHT
    clear = (at < 0.12) & (columns < 45) & (bare.dots > 0.02 * bare.dots.max())
    assert clear.sum() > 100
    ratio = through.dots[clear] / bare.dots[clear]
    np.testing.assert_allclose(ratio, expected[clear], rtol=2e-3)


def test_light_on_a_wall_is_the_pattern_over_its_squared_distance(backend):
    sensor = device(field=(1.0, 0.8))
    found = seen(above(sensor=sensor)).dots
    # Power on the board, from radiance pi L / reflectance over its area; Burley's diffuse lobe is not quite Lambert's.
    area = (HEIGHT / sensor.imager.focal) ** 2
    assert found.sum() * area * np.pi / 0.5 == pytest.approx(sensor.projector.power, rel=0.12)


@pytest.mark.slow
def test_the_projectors_shadow_lies_on_the_side_away_from_it(backend):
    block = scenes.block(bodies.box_mesh((0.05, 0.05, 0.1), "block", (0.0, 0.0, 0.25)), scenes.matte(), id=2)
    for side in (-0.15, 0.15):
        sensor = device(place=side, field=(1.6, 1.2), dots=4000)
        found = seen(above(props=(block,), sensor=sensor))
        dark = ~found.lit
        columns = np.nonzero(dark)[1] - sensor.centre[0]
        assert dark.any()
        assert (found.dots[dark] == 0.0).mean() > 0.8  # pixels at its edge are in part lit
        assert np.sign(np.median(columns)) == -np.sign(side)


@pytest.mark.slow
def test_glass_mirrors_the_projector_as_bright_as_a_mirror_of_its_fresnel_reflectance(backend):
    n, sensor = 1.5, device(width=128, height=96, focal=120.0, place=0.029, dots=3000, field=(1.2, 1.0))
    sensor = sensor.model_copy(update={"samples": 256})
    slab = bodies.slab((0.3, 0.3, 0.02), Medium(name="glass", eta=n), (0.0, 0.0, 0.2))
    bare, glass = seen(above(sensor=sensor)), seen(above(glass=(slab,), sensor=sensor))
    light = glass.dots - bare.dots
    row, column = np.unravel_index(np.argmax(glass.dots), glass.dots.shape)
    # The image of the projector lies as far below the upper face as the projector is above it: half way between it
    # and the camera on the face, 14.5 mm from the camera's foot.
    face = HEIGHT - 0.21
    assert column - sensor.centre[0] == pytest.approx(sensor.imager.focal * 0.0145 / face, abs=2.0)
    assert abs(row - sensor.centre[1]) <= 2.0
    assert light.max() > 3.0 * bare.dots.max()


def depth_through_a_slab(sensor: DepthCamera, thick: float, n: float) -> np.ndarray:
    """Depth by the exact disparity of the board behind a slab, in the middle row of the left infrared picture [m]."""

    def reach(slope: np.ndarray) -> np.ndarray:
        """How far to the side of the eye a ray meets the board, by Snell's law in the slab."""
        sine = slope / np.sqrt(1.0 + slope**2) / n
        return (HEIGHT - thick) * slope + thick * sine / np.sqrt(1.0 - sine**2)

    focal = sensor.imager.focal
    left = (np.arange(sensor.imager.width) - sensor.centre[0]) / focal
    slopes = np.linspace(-1.0, 1.0, 20_001)
    right = np.interp(reach(left) - sensor.baseline, reach(slopes), slopes)
    return sensor.baseline / (left - right)


@pytest.mark.slow
def test_a_slab_brings_the_wall_behind_it_nearer_as_refraction_says(backend):
    n, thick, known = 1.5, 0.03, DEPTH_CAMERAS["d435"]
    imager = known.imager.model_copy(update={"width": 240, "height": 120, "centre": None})
    sensor = known.model_copy(update={"imager": imager, "samples": 32})
    slab = bodies.slab((0.8, 0.6, thick), Medium(name="glass", eta=n), (0.0, 0.0, 0.2))
    found = []
    for glass in ((), (slab,)):
        from glassware.render.renderer import Renderer

        scene = above((160, 100), glass, sensor=sensor)
        frame = Renderer(scene).frame(0)
        assert frame.infrared is not None
        found.append(measured(sensor, frame.infrared, scene.cameras[0], frame.geometry.Z, (0, 0, 0)))
    bare, through = (one.metres[30:70, 60:110] for one in found)
    # The colour pixels are nearly three infrared ones wide: noise has no preferred sign in them either.
    assert np.nanmedian(bare) == pytest.approx(HEIGHT, abs=1.5e-3)
    assert np.isfinite(through).mean() > 0.5
    # Neither the first surface nor the wall: near the axis the image of the wall is nearer by t (1 - 1 / n).
    assert np.nanmedian(through) == pytest.approx(HEIGHT - thick * (1 - 1 / n), abs=2.5e-3)
    # Beside the projector's mirror image on the slab, in the columns from 120 to 160: within the vendor's 0.08 px.
    middle, columns = slice(50, 70), np.r_[60:115, 165:220]
    exact = depth_through_a_slab(sensor, thick, n)
    error = sensor.imager.focal * sensor.baseline * (1.0 / found[1].Z[middle] - 1.0 / exact)[:, columns]
    assert abs(np.nanmedian(error)) < 0.08  # px of disparity, of 37


@pytest.mark.slow
def test_a_mirror_shows_the_pattern_as_far_behind_it_as_it_lies_in_front(backend):
    """The image of the board in an upright mirror goes on where the board would: that is the depth that is reported."""
    from glassware.render.renderer import Renderer

    known = DEPTH_CAMERAS["d435"]
    imager = known.imager.model_copy(update={"width": 240, "height": 120, "centre": None})
    sensor = known.model_copy(update={"imager": imager, "samples": 32})
    chrome = scenes.matte((0.9, 0.9, 0.9), "chrome").model_copy(update={"roughness": 0.02, "metallic": 1.0})
    wall = scenes.block(bodies.box_mesh((2.0, 0.02, 0.3), "wall", (0.0, 0.1, 0.16)), chrome, id=2)
    scene = above((160, 100), props=(wall,), sensor=sensor)
    frame = Renderer(scene).frame(0)
    assert frame.infrared is not None
    found = measured(sensor, frame.infrared, scene.cameras[0], frame.geometry.Z, (0, 0, 0))
    # The lower part of its face, away from its foot; further up the right camera sees the board past its upper edge.
    Z = frame.geometry.Z
    face = (Z > 0.45) & (Z < HEIGHT - 0.03) & (frame.geometry.id == 2)
    assert face.sum() > 500
    mirrored = found.metres[face]
    assert np.isfinite(mirrored).sum() > 200
    assert (np.abs(mirrored - Z[face]) < 0.01).mean() < 0.05  # the mirror itself is not seen
    # Within the vendor's 0.08 px of disparity, z^2 0.08 / (f b).
    assert np.nanmedian(mirrored) == pytest.approx(HEIGHT, abs=HEIGHT**2 * 0.08 / (imager.focal * sensor.baseline))


@pytest.mark.slow
@pytest.mark.parametrize("reflectance", [0.2, 0.6])
def test_ambient_light_of_a_board_under_an_even_sky_is_its_reflectance_times_the_skys(backend, reflectance):
    from glassware.render.renderer import Renderer

    scene = above(sensor=device(power=0.0))
    board = scenes.board((4.0, 4.0, 0.02), scenes.matte((reflectance,) * 3))
    light = Renderer(scene.model_copy(update={"table": board})).infrared(0).ambient
    for eye in light:
        # Burley's diffuse lobe is not quite Lambert's.
        assert eye.mean() == pytest.approx(0.05 * reflectance, rel=0.12)
