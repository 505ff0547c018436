from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.material import NearInfrared
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.primitives import scenes
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS

#: Black to the eye and half grey to a depth camera, and the other way round.
DYED = scenes.matte((0.01, 0.01, 0.01)).model_copy(
    update={"near_infrared": NearInfrared(neutral=0.0, chromatic=0.0, bare=0.5)}
)
GREY = scenes.matte((0.5, 0.5, 0.5)).model_copy(
    update={"near_infrared": NearInfrared(neutral=1.0, chromatic=1.0, bare=1.0)}
)


def board(material, power: float, strength: float = 0.05):
    known = DEPTH_CAMERAS["d435"]
    imager = known.imager.model_copy(update={"width": 32, "height": 24, "focal": 30.0, "centre": None})
    projector = known.projector.model_copy(update={"dots": 60, "dot": 0.08, "power": power})
    scene = scenes.scene(
        (),
        [scenes.camera((0.0, 0.0, 0.6), width=16, height=12)],
        table=scenes.board((4.0, 4.0, 0.02), material),
        environment=ConstantEnvironment(strength=strength),
        picture=Picture(spp=4, light="path", denoise=False, refraction=False, layers=0),
    )
    device = known.model_copy(update={"imager": imager, "projector": projector, "samples": 16})
    return scene.model_copy(update={"depth_camera": device})


def test_dyed_black_scatters_the_projectors_light_as_grey_does_and_lamps_light_as_black(backend):
    """The dots see the reflectance in the infrared, and the light of lamps the colours, which are there again."""
    import mitsuba as mi

    from glassware.render.renderer import Renderer

    found, colours = {}, {}
    for name, material in (("dyed", DYED), ("grey", GREY)):
        renderer = Renderer(board(material, 0.36))
        shapes = [shape for shape in renderer.loaded.mi_scene.shapes() if shape.id() in renderer.loaded.materials]
        before = [np.array(mi.traverse(shape.bsdf())["base_color.data"]) for shape in shapes]
        found[name] = renderer.infrared(0)
        after = [np.array(mi.traverse(shape.bsdf())["base_color.data"]) for shape in shapes]
        assert all(np.array_equal(one, other) for one, other in zip(before, after, strict=True))
        colours[name] = before[0].mean()
    assert colours["dyed"] == pytest.approx(0.01)
    # K/S and back: float32 in the texture.
    np.testing.assert_allclose(found["dyed"].dots[0], found["grey"].dots[0], rtol=1e-5)
    assert not found["dyed"].daylight
    # A rough dielectric scatters a few per cent at its face besides.
    assert found["dyed"].ambient[0].mean() < 0.15 * found["grey"].ambient[0].mean()


@pytest.mark.slow
def test_daylight_meets_colours_and_reflectances_in_the_infrared_by_its_power(backend):
    """Ambient light of a sunlit board lies between those of a black and a grey one as 60 and 40 per cent say."""
    from glassware.render.infrared.ambient import BEYOND_RED
    from glassware.render.renderer import Renderer

    black = scenes.matte((0.01, 0.01, 0.01)).model_copy(update={"near_infrared": GREY.near_infrared})
    pictures = [Renderer(board(material, 0.0, 30.0)).infrared(0) for material in (black, DYED, GREY)]
    assert all(picture.daylight for picture in pictures)
    low, mixed, high = (picture.ambient[0].mean() for picture in pictures)
    assert (mixed - low) / (high - low) == pytest.approx(BEYOND_RED, rel=0.03)
