from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.core.errors import InputError
from glassware.core.randomness import stream
from glassware.procedural.optics.catalogue import water
from glassware.procedural.optics.medium import Medium
from glassware.procedural.profiles.curve import Curve
from glassware.procedural.profiles.liquid import brimful_volume
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.vessels.build import VesselShape
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.rolling import NoRoomError
from glassware.procedural.vessels.scaling import VOLUME_TOLERANCE, WantedVolume, shape_that_holds
from glassware.procedural.vessels.settings import REVOLVED, VesselSettings
from glassware.procedural.vessels.sizes import NOMINAL, draw_size, volumes_of

GLASS = Medium(name="test glass", eta=1.52)
#: Relative error of a liquid's volume (`liquid_surface.surface_of_volume` keeps it to a few parts in 10^7).
LIQUID_TOLERANCE = 1e-5


def _vessel(number: int, **settings):
    chosen = VesselSettings.model_validate({"chord_error": 2e-4, "fill_probability": 1.0} | settings)
    rng = stream(31, number, "vessels")
    vessel = draw_vessel(rng, chosen, id=2, name="vessel-00", glass=GLASS, liquid_medium=water())
    assert vessel.liquid is not None
    return vessel, vessel.liquid


@pytest.mark.parametrize("category", REVOLVED)
def test_a_vessel_has_the_nominal_volume_that_was_ordered(category):
    for number in range(3):
        vessel, _ = _vessel(number, categories=[category], volume="250ml")
        nominal = NOMINAL.get(category, 1.0) * brimful_volume(np.array(vessel.inner))
        assert nominal == pytest.approx(2.5e-4, rel=VOLUME_TOLERANCE)


def test_a_beaker_of_250_ml_has_the_size_of_the_trade():
    # ISO 3819, low form: 70 mm across and 95 mm high; families draw slimmer and wider ones.
    width, _, height = _vessel(0, categories=["beaker"], volume="250ml")[0].size
    assert width == pytest.approx(0.070, rel=0.1)
    assert height == pytest.approx(0.095, rel=0.15)


#: What families of small vessels hold.
LARGEST = {"stem glass": "300ml", "cocktail glass": "200ml", "test tube": "30ml", "vial": "80ml"}


@pytest.mark.parametrize("category", REVOLVED)
@pytest.mark.parametrize("fill", ["60ml", "400ml"])
def test_a_vessel_holds_the_volume_that_was_ordered_and_has_room_for_it(category: str, fill: str):
    fill = min(fill, LARGEST.get(category, fill), key=lambda text: float(text[:-2]))
    vessel, liquid = _vessel(4, categories=[category], fill=fill)
    assert liquid.volume == pytest.approx(float(fill[:-2]) * 1e-6, rel=LIQUID_TOLERANCE)
    assert liquid.contact < vessel.inner[-1][1]


def test_a_range_of_volumes_is_followed_in_vessels_of_a_range():
    for number in range(4):
        vessel, liquid = _vessel(number, categories=["tumbler"], volume=["200ml", "400ml"], fill=["100ml", "150ml"])
        assert 1e-4 * (1 - LIQUID_TOLERANCE) <= liquid.volume <= 1.5e-4 * (1 + LIQUID_TOLERANCE)
        assert 2e-4 * 0.99 <= brimful_volume(np.array(vessel.inner)) <= 4e-4 * 1.01


def test_families_that_cannot_hold_a_volume_are_skipped():
    settings = VesselSettings.model_validate({"categories": ["stem glass", "beaker"], "fill": "800ml"})
    found = {draw_size(stream(3, number, "vessels"), settings)[0] for number in range(20)}
    assert found == {"beaker"}
    assert volumes_of(settings, "stem glass")[1] < 8e-4 < volumes_of(settings, "beaker")[1]


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (
            {"volume": "30ml", "fill": "250ml"},
            "fill: expected at most 27ml (90 % of vessels.volume 30ml), found 250ml",
        ),
        (
            {"volume": ["200ml", "1l"], "fill": "20ml"},
            "fill: expected at least 50ml (5 % of vessels.volume 1l), found 20ml",
        ),
        ({"categories": ["tumbler"], "fill": "2l"}, "vessels.fill: expected 3.604ml to 648.9ml (a tumbler of"),
        ({"volume": "250ml", "height": (0.2, 0.3), "radius": (0.05, 0.08)}, "vessels.volume: expected 460.3ml to "),
        ({"volume": "5l"}, "expected 10ml to 4l, found 5l"),
        ({"volume": 250}, "expected a volume in ml, cl or l, such as 150ml or 0.5l, found '250'"),
        ({"volume": ["300ml", "20cl"]}, "expected the smaller one first, found 300ml and 20cl"),
        ({"fill": ["0.2", "100ml"]}, "expected two fractions or two volumes, found 0.2 and 100ml"),
        ({"fill": 1.5}, "expected fractions above 0 and at most 1, or volumes such as 150ml, found 1.5"),
        ({"fill": [0.5, 0.2]}, "expected the smaller one first, found 0.5 and 0.2"),
        ({"fill": []}, "expected fractions such as 0.1 0.9, or volumes such as 100ml 200ml"),
    ],
)
def test_volumes_that_do_not_go_together_are_one_line_with_the_nearest(settings, line):
    with pytest.raises((ValidationError, InputError)) as error:
        SceneSettings.model_validate({"vessels": settings})
    assert line in str(error.value)


def test_a_shape_without_room_inside_is_drawn_again():
    settings, sizes = VesselSettings(categories=("vase",)), []
    shape = VesselShape(Curve(np.zeros((2, 2)), np.zeros((2, 2))), Curve(np.zeros((2, 2)), np.zeros((2, 2))), 1e-3)

    def build(_, height: float, radius: float) -> VesselShape:
        sizes.append((height, radius))
        if len(sizes) < 3:
            raise NoRoomError("no room")
        return shape

    size = (0.2, 0.05)
    with pytest.raises(InputError, match=r"^vessels.wall, vessels.base: expected walls that leave room in a vase"):
        shape_that_holds(stream(1, 0, "v"), settings, "vase", size, WantedVolume(), _no_room)
    assert shape_that_holds(stream(1, 0, "v"), settings, "vase", size, WantedVolume(), build) is shape
    assert sizes[0] == size
    assert len(set(sizes)) == 3


def _no_room(*_) -> VesselShape:
    raise NoRoomError("no room")
