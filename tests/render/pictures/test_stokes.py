"""Stokes pictures: against Mitsuba's `path` and `stokes` on the same loaded scene, and the frame that they stand in."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import trimesh
from scipy.stats import t as student

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.render.backend.variant import activate
from glassware.render.derivatives.gradients import picture_derivatives
from glassware.render.pictures.picture import trace_picture
from glassware.render.pictures.stokes import (
    angle_of_linear_polarisation,
    degree_of_linear_polarisation,
    degree_of_polarisation,
    trace_stokes,
)
from glassware.render.scene import bodies
from glassware.render.scene.loaded_scene import load

#: Independent pictures of each renderer; their spread is the variance that differences are judged by.
PASSES, SPP = 12, 256
#: Side of the blocks that are compared [px]. A sum over many pixels and samples is nearly normal.
BLOCK = 8
#: Chance that two right renderers fail with other seeds.
SIGNIFICANCE = 1e-3
#: Height of the vessels over the table [m], for the sake of Mitsuba's ray offsets; see `test_integrator`.
LIFTED = 0.01
GLASS = 1.5
#: Share of rounding in the few events of a closed form here.
ROUNDING = 64 * 2.0**-24


@pytest.fixture(scope="module")
def polarised(backend) -> Iterator[str]:
    """One channel with polarisation, active; afterwards the variant that all other tests expect."""
    yield activate("llvm_ad_mono_polarized")
    activate(backend)


# ---- Against Mitsuba ----


@pytest.fixture(scope="module")
def one_bright_side(panorama):
    """Light from a quarter of the sky, from the side: what glass mirrors and refracts is strongly polarised."""
    pixels = np.full((16, 32, 3), 0.01)
    pixels[2:9, 4:12] = 2.0
    return panorama(pixels)


@pytest.fixture(scope="module")
def lifted(polarised, drawn, clear, one_bright_side):
    """Smooth clear glasses, filled and floating, on a table and beside a prop of polarising plastic."""

    def raised(vessel):
        pose = vessel.world_T_object.copy()
        pose[2, 3] += LIFTED
        return vessel.model_copy(update={"world_T_object": pose})

    scene = drawn(
        31,
        vessel_count=(3, 3),
        prop_count=(1, 1),
        environment={"hdri_dir": one_bright_side, "hdri_calibrated": True},
        cameras={"views": 15, "width": 48, "height": 32},
    )
    scene = clear(scene)
    with pytest.MonkeyPatch.context() as patch:
        # Our own materials scatter unpolarised light, and would not show a frame turned wrongly.
        patch.setattr(bodies, "opaque_bsdf", lambda *_: {"type": "pplastic", "alpha": 0.15})
        return load(
            scene.model_copy(
                update={
                    "vessels": tuple(raised(item) for item in scene.vessels),
                    "picture": Picture(spp=SPP, adaptive=False, max_depth=64, rr_depth=64),
                    "cameras": scene.cameras[-1:],
                }
            ),
            glass_for_mitsuba=True,
        )


@pytest.fixture(scope="module")
def with_sensor(lifted):
    """The same scene with a sensor of Mitsuba's."""
    import mitsuba as mi

    camera = lifted.description.cameras[0]
    film = {"type": "hdrfilm", "width": camera.width, "height": camera.height, "rfilter": {"type": "box"}}
    assert camera.centre == ((camera.width - 1) / 2, (camera.height - 1) / 2)
    sensor = {
        "type": "perspective",
        "fov": float(np.degrees(2.0 * np.arctan(0.5 * camera.width / camera.focal))),
        "fov_axis": "x",
        # Mitsuba's sensors have x to the left and y up.
        "to_world": mi.ScalarTransform4f(camera.world_T_camera @ np.diag([-1.0, -1.0, 1.0, 1.0])),
        "near_clip": 1e-3,
        "film": film,
    }
    scene = lifted.mi_scene
    shapes = {f"shape{i}": shape for i, shape in enumerate(scene.shapes())}
    return mi.load_dict(
        {"type": "scene", "sensor": sensor, "environment": scene.environment(), **shapes}, optimize=False
    )


def _theirs(scene, seed: int) -> np.ndarray:
    """Stokes vectors by Mitsuba's integrators and sensor, (H, W, 4)."""
    import mitsuba as mi

    # One more: theirs counts the camera's segment, and gathers light where ours has stopped.
    integrator = mi.load_dict({"type": "stokes", "nested": {"type": "path", "max_depth": 65, "rr_depth": 1000}})
    picture = np.array(mi.render(scene, integrator=integrator, spp=SPP, seed=seed), np.float64)
    # The first channels are the film's own, then there are three colours of each component.
    return picture[..., -12::3]


def _blocks(picture: np.ndarray) -> np.ndarray:
    height, width, components = picture.shape
    return picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, components).mean((1, 3))


def _lowest(one: np.ndarray, two: np.ndarray) -> float:
    """The p-value of the worst of all numbers, by Welch's test and Šidák's correction; both are (passes, ...)."""
    a, b = one.var(0, ddof=1) / len(one), two.var(0, ddof=1) / len(two)
    # Blocks that show the sky alone have no noise but rounding.
    rounding = ROUNDING * np.abs(two.mean(0))
    noisy = np.sqrt(a + b) > rounding
    assert (np.abs(one.mean(0) - two.mean(0)) <= rounding)[~noisy].all()
    one, two, a, b = one[:, noisy], two[:, noisy], a[noisy], b[noisy]
    degrees = (a + b) ** 2 / (a**2 / (len(one) - 1) + b**2 / (len(two) - 1))
    p = 2.0 * student.sf(np.abs(one.mean(0) - two.mean(0)) / np.sqrt(a + b), degrees)
    return 1.0 - (1.0 - float(p.min())) ** p.size


@pytest.fixture(scope="module")
def pictures(lifted, with_sensor):
    camera = lifted.description.cameras[0]
    ours = [_blocks(trace_stokes(lifted, camera, "left", 100 + i)[..., 0].astype(float)) for i in range(PASSES)]
    theirs = [_blocks(_theirs(with_sensor, 200 + i)) for i in range(PASSES)]
    return np.stack(ours), np.stack(theirs)


@pytest.mark.slow
@pytest.mark.parametrize("component", range(4))
def test_stokes_vectors_agree_with_mitsubas_block_by_block(pictures, component):
    ours, theirs = (picture[..., component] for picture in pictures)
    assert _lowest(ours, theirs) > SIGNIFICANCE


@pytest.mark.slow
@pytest.mark.parametrize("component", range(4))
def test_mean_stokes_vectors_agree_with_mitsubas(pictures, component):
    ours, theirs = (picture[..., component].mean((1, 2))[:, None] for picture in pictures)
    assert _lowest(ours, theirs) > SIGNIFICANCE


@pytest.mark.slow
@pytest.mark.parametrize("component", [1, 2, 3])
def test_the_comparison_sees_a_component_of_the_other_sign(pictures, component):
    ours, theirs = (picture[..., component] for picture in pictures)
    assert _lowest(-ours, theirs) < SIGNIFICANCE


@pytest.mark.slow
def test_pictures_show_the_first_component(lifted):
    camera = lifted.description.cameras[0]
    s0 = trace_stokes(lifted, camera, "right", 3)[..., 0, :]
    # The same paths, added up in another order.
    assert trace_picture(lifted, camera, "right", 3).radiance == pytest.approx(s0, rel=ROUNDING)


# ---- The camera's frame ----


def plate() -> Mesh:
    """A level plate of glass, its upper face at z = 0, wider than any camera here sees."""
    corners = np.array([[x, y, z] for x in (-9.0, 8.0) for y in (-8.0, 9.0) for z in (-0.01, 0.0)])
    solid = trimesh.convex.convex_hull(corners)
    return Mesh("plate", solid.vertices, solid.faces)


@pytest.fixture(scope="module")
def mirror(polarised, optical_bench, panorama):
    """A plate in a dark room with a ceiling of radiance 1, loaded."""
    sky = np.zeros((16, 32, 3))
    sky[:8] = 1.0
    scene = optical_bench.scene(plate(), optical_bench.medium(GLASS))
    environment = PictureEnvironment(asset=asset(panorama(sky) / "map.exr"))
    board = scene.table.mesh
    far = Mesh("table", 1e-6 * np.asarray(board.vertices) + [50.0, 50.0, -50.0], board.faces)
    table = scene.table.model_copy(update={"mesh": far})
    return load(scene.model_copy(update={"environment": environment, "table": table, "picture": Picture(spp=64)}))


def _towards_the_plate(optical_bench, degrees: float, roll: float):
    """A camera whose middle looks at the plate at an angle to its normal, turned about its axis [rad]."""
    theta = np.radians(degrees)
    eye = (-np.sin(theta) * 0.6, -np.sin(theta) * 0.8, np.cos(theta))
    camera = optical_bench.camera(eye, width=33, height=25, focal=60.0)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]]
    return camera.model_copy(update={"world_T_camera": camera.world_T_camera @ turn})


@pytest.mark.parametrize("roll", [0.0, 0.5, -1.0])
def test_a_plate_seen_at_brewsters_angle_is_polarised_along_its_level_direction(mirror, optical_bench, roll):
    camera = _towards_the_plate(optical_bench, float(np.degrees(np.arctan(GLASS))), roll)
    picture = trace_stokes(mirror, camera)
    assert picture.shape == (camera.height, camera.width, 4, 3)
    assert picture.dtype == np.float32
    middle = picture[camera.height // 2, camera.width // 2]
    assert degree_of_linear_polarisation(middle) == pytest.approx(1.0, abs=1e-3)  # over the pixel's own angles
    # A camera turned clockwise sees the level direction turned counter-clockwise, which is positive.
    level = camera.world_T_camera[:3, :3].T @ np.cross([0.0, 0.0, 1.0], camera.world_T_camera[:3, 2])
    expected = np.arctan2(-level[1], level[0])
    found = angle_of_linear_polarisation(middle)
    assert np.abs(np.sin(found - expected)).max() < 0.5 / camera.focal
    assert np.abs(np.sin(expected - roll)) < 1e-6
    assert (degree_of_polarisation(picture) < 1.0 + 1e-5).all()


def test_every_pixel_is_polarised_across_its_own_plane_of_incidence(mirror, optical_bench):
    """Away from the middle: the angle from the camera's frame, by the geometry of each pixel's ray."""
    camera = _towards_the_plate(optical_bench, 50.0, 0.4)
    found = angle_of_linear_polarisation(trace_stokes(mirror, camera, spp=256))[..., 0]
    v, u = np.mgrid[: camera.height, : camera.width].astype(float)
    rays = np.stack([(u - camera.centre[0]) / camera.focal, (v - camera.centre[1]) / camera.focal, np.ones_like(u)], -1)
    up = camera.world_T_camera[:3, :3].T @ [0.0, 0.0, 1.0]
    level = np.cross(up, rays)
    right = np.cross([0.0, 1.0, 0.0], rays)
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    above = np.cross(rays, right)
    above /= -np.linalg.norm(above, axis=-1, keepdims=True)
    expected = np.arctan2((level * above).sum(-1), (level * right).sum(-1))
    assert np.ptp(expected) > 0.1  # the frame matters
    # The samples of a pixel are spread over its width.
    assert np.abs(np.sin(found - expected)).max() < 0.5 / camera.focal


# ---- What is refused ----


def test_derivatives_are_refused_in_a_polarised_variant(mirror):
    with pytest.raises(InputError, match="an RGB variant with AD"):
        picture_derivatives(mirror, mirror.description.cameras[0], "left", 1)


def test_a_picture_has_a_sample_at_least(mirror):
    with pytest.raises(InputError, match="spp"):
        trace_stokes(mirror, mirror.description.cameras[0], spp=0)
    with pytest.raises(InputError, match="seed: expected a number of 32 bits, found -1"):
        trace_stokes(mirror, mirror.description.cameras[0], seed=-1)


def test_stokes_vectors_need_a_polarised_variant(backend, loaded_glasses):
    activate(backend)
    with pytest.raises(InputError, match=r"backend: expected a polarised variant.*found llvm_ad_rgb"):
        trace_stokes(loaded_glasses, loaded_glasses.description.cameras[0])
