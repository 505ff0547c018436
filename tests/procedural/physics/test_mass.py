"""Mass, centre of mass and inertia against closed forms and against trimesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh, as_trimesh
from glassware.core.randomness import stream
from glassware.procedural.physics.bodies import mechanics_of
from glassware.procedural.physics.mass import combined, shell_mass, solid_mass
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings

#: Relative rounding of meshes of single precision.
ROUNDING = 1e-5
SIDES = np.array([0.1, 0.2, 0.05])


def _box(sides: np.ndarray, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    box = trimesh.creation.box(sides)
    return Mesh("box", box.vertices + at, box.faces)


def test_a_solid_box_has_the_mass_and_the_inertia_of_the_closed_form():
    found = solid_mass(_box(SIDES, (0.3, -0.2, 0.1)), 700.0)
    mass = 700.0 * SIDES.prod()
    squares = (SIDES**2).sum() - SIDES**2
    assert found.mass == pytest.approx(mass, rel=ROUNDING)
    np.testing.assert_allclose(found.centre_of_mass, (0.3, -0.2, 0.1), atol=1e-7)
    np.testing.assert_allclose(found.inertia, np.diag(mass * squares / 12.0), atol=1e-7)


def test_a_shell_of_a_ball_has_two_thirds_of_its_mass_times_its_radius_squared():
    ball = trimesh.creation.icosphere(5, 0.05)
    found = shell_mass(Mesh("ball", ball.vertices, ball.faces), 1000.0, 1e-3)
    assert found.mass == pytest.approx(1000.0 * 4.0 * np.pi * 0.05**2 * 1e-3, rel=2e-3)
    np.testing.assert_allclose(found.inertia, np.eye(3) * 2.0 / 3.0 * found.mass * 0.05**2, rtol=2e-3, atol=1e-9)


def test_two_halves_of_a_box_make_the_box():
    half = SIDES * (0.5, 1.0, 1.0)
    halves = [solid_mass(_box(half, (x, 0.0, 0.0)), 700.0) for x in (-0.025, 0.025)]
    whole, made = solid_mass(_box(SIDES), 700.0), combined(halves)
    assert made.mass == pytest.approx(whole.mass, rel=ROUNDING)
    np.testing.assert_allclose(made.inertia, whole.inertia, rtol=1e-4, atol=1e-9)


def test_vessels_and_their_liquids_weigh_what_their_volumes_do():
    vessels = {"categories": ["tumbler", "bowl", "vase"]}
    nothing = dict.fromkeys(("layered", "turbid", "ice", "beads", "bubbles", "standing"), 0.0)
    vessels |= {"contents": nothing, "closed_probability": 0.0, "label_probability": 0.0}
    given = {"vessel_count": (3, 3), "prop_count": (0, 0), "vessels": vessels, "physics": {"piled_probability": 0.0}}
    scene = draw_scene(SceneSettings.model_validate(given), 3, 0)
    for vessel in scene.vessels:
        found, glass = mechanics_of(vessel), as_trimesh(vessel.interfaces[0].mesh)
        assert vessel.glass.density is not None
        if vessel.liquid is None:
            assert found.whole.mass == pytest.approx(glass.volume * vessel.glass.density, rel=1e-4)
            continue
        assert found.empty is not None
        assert vessel.liquid.medium.density is not None
        liquid = found.whole.mass - found.empty.mass
        assert liquid == pytest.approx(vessel.liquid.volume * vessel.liquid.medium.density, rel=0.01)
        x, y, z = found.whole.centre_of_mass
        assert np.hypot(x, y) < 1e-5
        assert z < found.empty.centre_of_mass[2] or vessel.liquid.level > found.empty.centre_of_mass[2]


def test_a_prop_of_plastic_is_hollow_and_one_of_wood_is_solid():
    from glassware.procedural.description.material import OpaqueMaterial, UniformTexture
    from glassware.procedural.props.draw import PropSettings, draw_prop

    def named(name: str) -> OpaqueMaterial:
        return OpaqueMaterial(name=name, base_colour=UniformTexture(colour=(0.5, 0.5, 0.5)), roughness=0.5)

    prop = draw_prop(stream(1, 0, "prop"), PropSettings(), id=2, name="prop").model_copy(update={"category": "box"})
    wood, plastic = (mechanics_of(prop.model_copy(update={"material": named(n)})) for n in ("wood", "matte plastic"))
    assert wood.wall is None
    assert plastic.wall is not None
    assert plastic.whole.mass < 0.5 * wood.whole.mass


def test_every_material_of_things_and_tables_has_a_density_of_its_own():
    from glassware.procedural.patterns.draw import WOODS
    from glassware.procedural.physics.substances import SUBSTANCES
    from glassware.procedural.tables.kinds import TABLE_KINDS, draw_top
    from glassware.procedural.things.kinds import KINDS

    rngs = [np.random.default_rng(number) for number in range(2)]
    names = {draw_top(rng, kind, (1.0, 0.7), 0.3).name for kind in TABLE_KINDS if kind != "plain" for rng in rngs}
    names |= {part.material.name for kind in KINDS.values() for rng in rngs for part in kind.draw(rng, 0.3).parts}
    names |= set(WOODS) | {f"{wood} laminate" for wood in WOODS}
    assert not names - set(SUBSTANCES)
    assert all(50.0 <= SUBSTANCES[name].density <= 9000.0 or "foam" in name for name in names)


@pytest.mark.parametrize(
    ("kind", "grams"),
    [("apple", (60, 300)), ("spoon", (15, 90)), ("phone", (130, 260)), ("mug", (180, 500)), ("pen", (3, 25))],
)
def test_things_weigh_what_they_do_in_the_hand(kind, grams):
    from glassware.procedural.things.kinds import KINDS
    from glassware.procedural.things.parts import as_prop

    for seed in range(3):
        thing = as_prop(KINDS[kind].draw(np.random.default_rng(seed), 0.3), kind, id=2, name="thing")
        assert grams[0] <= 1e3 * mechanics_of(thing).whole.mass <= grams[1]
