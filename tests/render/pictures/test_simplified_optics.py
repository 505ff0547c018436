"""Pictures with a film of air between glass and liquids, or with other indices than the true ones."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import NoisyImage, trace_picture
from glassware.render.scene.loaded_scene import load


@pytest.fixture(scope="module")
def filled(backend, drawn, all_clear) -> Scene:
    """Two filled vessels, nothing opaque in them; every pixel gets the same samples in all pictures."""
    vessels = all_clear | {"fill_probability": 1.0, "chord_error": 5e-5, "rough_probability": 0.0}
    return drawn(5, vessels=vessels).model_copy(update={"picture": Picture(spp=16, light="path", adaptive=False)})


def _picture(scene: Scene, **changes: bool | float) -> NoisyImage:
    scene = scene.model_copy(update={"picture": scene.picture.model_copy(update=changes)})
    return trace_picture(load(scene), scene.cameras[0], "left", 3)


def test_air_between_glass_and_liquid_changes_what_filled_vessels_look_like(filled):
    gap, contact = _picture(filled, air_gap=True), _picture(filled)
    glass = contact.guides.glass
    differs = np.abs(gap.radiance - contact.radiance).max(-1) > 0.1 * contact.radiance.max(-1)
    assert differs[glass].mean() > 0.15
    assert gap.violations == 0.0
    empty = filled
    for vessel in filled.vessels:
        empty = empty.with_liquid(vessel.name, None)
    np.testing.assert_array_equal(_picture(empty, air_gap=True).radiance, _picture(empty).radiance)


def test_without_refractivity_light_goes_straight_through_and_is_absorbed_alone(backend, optical_bench):
    radius, sigma_a, centre = 0.05, (4.0, 10.0, 20.0), np.array([0.0, 0.0, 0.3])
    camera = optical_bench.camera((0.3, 0.0, 0.28), tuple(centre))
    scene = optical_bench.scene(
        optical_bench.ball(radius, 5, tuple(centre)), optical_bench.medium(1.5, sigma_a), camera
    )
    scene = scene.model_copy(update={"picture": Picture(spp=16, light="path", adaptive=False)})
    bare = _picture(scene.without(*(vessel.name for vessel in scene.vessels)))
    straight = _picture(scene, refractivity=0.0)
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = np.linalg.inv(camera.K) @ np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    rays = camera.world_T_camera[:3, :3] @ (rays / np.linalg.norm(rays, axis=0))
    to_centre = centre - camera.world_T_camera[:3, 3]
    closest = np.sqrt(np.maximum(to_centre @ to_centre - (to_centre @ rays) ** 2, 0.0)).reshape(u.shape)
    inside = (closest < 0.8 * radius) & (trace_geometry(load(scene), camera).background_id == 0)
    assert inside.sum() > 100
    chord = 2.0 * np.sqrt(radius**2 - closest[inside] ** 2)
    expected = np.exp(-chord[:, None] * np.array(sigma_a)) * bare.radiance[inside]
    np.testing.assert_allclose(straight.radiance[inside], expected, rtol=0.03)
    assert abs(np.log(straight.radiance[inside] / expected).mean()) < 0.003


def test_half_the_refractivity_is_a_glass_of_another_index(backend, optical_bench):
    camera = optical_bench.camera((0.3, 0.0, 0.2), (0.0, 0.0, 0.05))
    ball = optical_bench.ball(0.05, 4, (0.0, 0.0, 0.06))
    real, weak = (optical_bench.scene(ball, optical_bench.medium(eta), camera) for eta in (1.5, 1.25))
    real, weak = (
        scene.model_copy(update={"picture": Picture(spp=8, light="path", adaptive=False)}) for scene in (real, weak)
    )
    np.testing.assert_allclose(_picture(real, refractivity=0.5).radiance, _picture(weak).radiance, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("sensors", [{"depth": "d435"}, {"polarisation": "imx250mzr"}])
@pytest.mark.parametrize(
    ("picture", "line"),
    [
        ({"air_gap": True}, "picture.air_gap: expected no with sensors"),
        ({"refractivity": 0.5}, "picture.refractivity: expected 1 with sensors"),
        ({"glass_shadows": False}, "picture.glass_shadows: expected yes with sensors"),
    ],
)
def test_cameras_that_would_follow_simplified_optics_in_part_are_refused(sensors, picture, line):
    with pytest.raises(ValueError, match=line):
        SceneSettings.model_validate({"sensors": sensors, "picture": picture})


def test_labels_know_nothing_of_simplified_optics(filled):
    changed = filled.picture.model_copy(update={"air_gap": True, "refractivity": 0.5, "glass_shadows": False})
    one, two = (
        trace_geometry(load(filled.model_copy(update={"picture": picture})), filled.cameras[0])
        for picture in (filled.picture, changed)
    )
    for name in ("Z", "id", "transmittance"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
