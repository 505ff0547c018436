"""Reflectances in the near infrared: by the formulas of Kubelka and Munk, and by what things are made of."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.procedural.description.material import NearInfrared, OpaqueMaterial, SurfaceTexture, UniformTexture
from glassware.procedural.materials.draw import METALS
from glassware.procedural.materials.near_infrared import (
    KINDS,
    absorption_over_scattering,
    deep_reflectance,
    infrared_reflectance,
    near_infrared,
)
from glassware.procedural.patterns.draw import BLACK_INK, INKS, PAPERS
from glassware.procedural.physics.substances import SUBSTANCES

#: Black as dyed cloth and plastic have it, linear.
BLACK = (0.02, 0.02, 0.02)


def of(name: str, colour=BLACK, metallic: float = 0.0) -> OpaqueMaterial:
    return OpaqueMaterial(name=name, base_colour=UniformTexture(colour=colour), roughness=0.5, metallic=metallic)


def seen(name: str, colour, number: int | None = None, carbon: float | None = None) -> float:
    """Reflectance of a material, of its middle or of one that is drawn."""
    rng = None if number is None else stream(number, 0, "test")
    return float(infrared_reflectance(np.array(colour), near_infrared(of(name, colour), rng, carbon)))


def test_a_deep_layer_reflects_what_its_absorption_and_scattering_say():
    reflectance = np.linspace(0.01, 1.0, 50)
    ratio = absorption_over_scattering(reflectance)
    np.testing.assert_allclose(deep_reflectance(ratio), reflectance, rtol=1e-9)
    # The root of R^2 - 2 (1 + K/S) R + 1 = 0 below 1.
    roots = [min(np.roots([1.0, -2.0 * (1.0 + one), 1.0]).real) for one in ratio[:-1]]
    np.testing.assert_allclose(deep_reflectance(ratio)[:-1], roots, rtol=1e-6)


def test_the_brightest_channel_counts_where_all_absorption_is_left_and_none_where_nothing_is():
    colours = stream(1, 0, "test").uniform(0.01, 0.9, (20, 3))
    all_left = NearInfrared(neutral=1.0, chromatic=1.0, bare=1.0)
    np.testing.assert_allclose(infrared_reflectance(colours, all_left), colours.max(axis=1), rtol=1e-9)
    nothing = NearInfrared(neutral=0.0, chromatic=0.0, bare=0.7)
    np.testing.assert_allclose(infrared_reflectance(colours, nothing), 0.7, rtol=1e-9)
    # Half of the absorption of a grey layer on a bare one that absorbs as well.
    mixed = NearInfrared(neutral=0.5, chromatic=0.0, bare=0.8)
    grey, bare = 0.2, 0.8
    expected = deep_reflectance(np.array((1 - bare) ** 2 / (2 * bare) + 0.5 * (1 - grey) ** 2 / (2 * grey)))
    assert infrared_reflectance(np.full(3, grey), mixed) == pytest.approx(expected)


def test_coloured_inks_vanish_and_black_ink_stays():
    paper = seen("printed paper", PAPERS[0])
    assert 0.7 < paper < 0.9
    assert seen("printed paper", BLACK_INK) < 0.03
    saturated = [ink for ink in INKS if min(ink) < 0.1 * max(ink)]
    assert len(saturated) >= 5
    assert min(seen("printed paper", ink) for ink in saturated) > 0.5 * paper


def test_black_cloth_is_bright_and_black_plastic_dark_more_often_than_not():
    cloth, plastic = ([seen(name, BLACK, number) for number in range(100)] for name in ("cotton", "plastic"))
    bright = [float(np.mean(np.array(found) > 0.25)) for found in (cloth, plastic)]
    assert bright[0] > 0.5
    assert bright[1] < 0.3
    for name in ("cotton", "plastic"):
        assert max(seen(name, BLACK, number, carbon=1.0) for number in range(20)) < 0.03
        assert min(seen(name, BLACK, number, carbon=0.0) for number in range(20)) > 0.06


@pytest.mark.parametrize(
    ("name", "colour", "low", "high"),
    [
        ("oak", (0.46, 0.29, 0.145), 0.5, 0.75),
        ("walnut", (0.175, 0.090, 0.046), 0.25, 0.5),
        ("apple skin", (0.30, 0.02, 0.02), 0.5, 0.7),
        ("terracotta", (0.40, 0.15, 0.075), 0.3, 0.5),
        ("rubber", (0.02, 0.02, 0.02), 0.0, 0.03),
    ],
)
def test_wood_fruit_clay_and_rubber_are_as_bright_as_they_are_known_to_be(name, colour, low, high):
    assert low < seen(name, colour) < high


def test_metals_reflect_what_tables_of_evaporated_films_have():
    # Hass, in the AIP Handbook (3rd edition, 1972), table 6g: 850 nm for aluminium; 800 and 900 nm for copper.
    for metal, expected, apart in (("aluminium", 0.867, 0.015), ("copper", 0.98, 0.02)):
        material = of("brushed metal", METALS[metal], 1.0)
        assert infrared_reflectance(np.array(METALS[metal]), near_infrared(material)) == pytest.approx(
            expected, abs=apart
        )
    # A pattern of a metal is of that metal too; a metal of another colour keeps its own.
    texture = SurfaceTexture(
        pattern="brushed metal", colours=(METALS["brass"],), seed=1, extent=(0.1, 0.1), size=(8, 8)
    )
    brass = OpaqueMaterial(name="brushed brass", base_colour=texture, roughness=0.4, metallic=1.0)
    assert infrared_reflectance(np.array(METALS["brass"]), near_infrared(brass)) == pytest.approx(0.935, abs=0.002)
    anodised = of("metal", (0.02, 0.05, 0.4), 1.0)
    assert infrared_reflectance(np.array((0.02, 0.05, 0.4)), near_infrared(anodised)) == pytest.approx(0.4)


def test_every_substance_of_drawn_scenes_has_a_kind_and_each_kind_its_source():
    metals = {"metal", "brushed metal", "tinplate", "stainless steel"}
    dielectrics = {name for name in SUBSTANCES if name not in metals and "steel" not in name}
    dielectrics -= {name for name in dielectrics if name.endswith("aluminium") and not name.startswith("printed")}
    assert dielectrics <= set(KINDS)
    for kind in KINDS.values():
        assert kind.source
        for low, high in (kind.neutral, kind.chromatic, kind.bare):
            assert 0.0 <= low <= high <= 1.0


def test_what_a_material_states_counts():
    stated = NearInfrared(neutral=0.3, chromatic=0.2, bare=0.5)
    material = of("plastic").model_copy(update={"near_infrared": stated})
    assert near_infrared(material, stream(1, 0, "test")) == stated
    assert "near_infrared" not in of("plastic").model_dump()  # files of other scenes stay what they were
