"""Props that shine by themselves: as bright as they say, and they light the others as lamps do."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import glassware as gw
from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.core.pose import look_at
from glassware.procedural.description.material import Emission, OpaqueMaterial, PictureTexture, UniformTexture
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Prop, Scene
from glassware.procedural.description.surroundings import AreaLight, ConstantEnvironment
from glassware.procedural.primitives.scenes import block, board, camera, matte, scene

SIDE, HEIGHT, RADIANCE = 0.1, 0.3, (4.0, 2.0, 1.0)
BLACK = UniformTexture(colour=(0.0, 0.0, 0.0))


def sheet(emission: Emission, uv_scale: float = 1.0) -> Prop:
    """Return a thin box above the table of which the sides and faces shine; its picture repeats `uv_scale` times."""
    half = 0.5 * SIDE
    corners = np.array([[x, y, z] for z in (0.0, 0.02) for y in (-half, half) for x in (-half, half)])
    # One face looks down, another up, so that the body has three extents; both share their texture coordinates.
    faces = np.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6]])
    uv = uv_scale * (corners[:, :2] / SIDE + 0.5)
    mesh = Mesh("sheet", corners + np.array([0.0, 0.0, HEIGHT]), faces, uv=uv)
    material = OpaqueMaterial(name="sheet", base_colour=BLACK, roughness=1.0, emission=emission)
    return block(mesh, material, id=2)


def rendered(props: list[Prop], lights: list[AreaLight], **picture: object) -> np.ndarray:
    """Return the radiance of the table below, and of the sheet seen from below, (2, 3)."""
    below = camera((0.0, -0.01, 0.15), (0.0, 0.0, 0.0), width=8, height=8, focal=100.0)
    up = camera((0.0, -0.01, 0.1), (0.0, 0.0, HEIGHT), width=8, height=8, focal=20.0)
    fields: dict = {"spp": 512, "denoise": False, "layers": 0, "refraction": False, **picture}
    described: Scene = scene(
        [],
        [below, up],
        props=props,
        lights=lights,
        table=board((2.0, 2.0, 0.03), matte((0.5, 0.5, 0.5))),
        environment=ConstantEnvironment(radiance=(1e-6, 1e-6, 1e-6)),
        picture=Picture(**fields),
    )
    renderer = gw.Renderer(described)
    return np.stack([np.asarray(renderer.frame(view).left).mean((0, 1)) for view in range(2)])


@pytest.mark.slow
def test_a_shining_prop_lights_the_table_as_a_lamp_of_its_size(tmp_path) -> None:
    pose = look_at(np.array([0.0, 0.0, HEIGHT]), np.zeros(3))
    lamp = rendered([], [AreaLight(world_T_light=pose, size=(SIDE, SIDE), radiance=RADIANCE)])
    plain = Emission(colour=UniformTexture(colour=(1.0, 0.5, 0.25)), radiance=4.0)
    prop = rendered([sheet(plain)], [])
    assert prop == pytest.approx(lamp, rel=0.02)
    assert prop[1] == pytest.approx(RADIANCE, rel=1e-4)
    # A picture of two halves, repeated three times, so that many places share their texture coordinates.
    stripes = np.zeros((4, 8, 3), np.uint8)
    stripes[:, :4] = 255
    cv2.imwrite(str(tmp_path / "stripes.png"), stripes)
    pictured = Emission(colour=PictureTexture(asset=asset(tmp_path / "stripes.png")), radiance=4.0)
    assert rendered([sheet(pictured, 3.0)], [])[0] == pytest.approx(0.5 * lamp[0, 0], rel=0.03)


@pytest.mark.slow
def test_wavelengths_give_the_light_of_red_green_and_blue() -> None:
    plain = Emission(colour=UniformTexture(colour=(1.0, 0.5, 0.25)), radiance=4.0)
    assert rendered([sheet(plain)], [], spectral=True)[1] == pytest.approx(RADIANCE, rel=0.02)


def test_light_is_not_stored_where_a_prop_shines() -> None:
    plain = Emission(colour=UniformTexture(colour=(1.0, 1.0, 1.0)), radiance=1.0)
    with pytest.raises(InputError, match=r"picture\.light: expected path or auto, as sheet shines by itself"):
        rendered([sheet(plain)], [], light="shared")
