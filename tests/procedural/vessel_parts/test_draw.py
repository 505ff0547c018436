from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from glassware.core.mesh import check_closed
from glassware.procedural.description.edits import check_pair, solid_of
from glassware.procedural.description.scene import GlassBody, MeshVessel, Prop
from glassware.procedural.scene.asset_files import AssetFiles
from glassware.procedural.scene.draw_vessels import draw_vessels, lies
from glassware.procedural.scene.solids import body_mesh
from glassware.procedural.vessels.settings import VesselSettings

#: What a family is closed with, is printed with, and stands in, where it has all of them.
PARTS = {
    "bottle": [{"cap", "cork"}, {"label"}],
    "square bottle": [{"cap", "cork"}, {"label"}],
    "plastic bottle": [{"cap"}, {"label"}],
    "jar": [{"lid"}, {"label"}],
    "vial": [{"cap"}, {"label"}],
    "spouted beaker": [{"print"}],
    "volumetric flask": [{"stopper"}, {"print"}],
    "round flask": [{"stopper"}, {"ring"}],
    "test tube": [{"cork"}, {"rack"}],
    "teapot": [{"lid"}],
}


def _drawn(category: str, probability: float = 1.0, fill: float = 1.0, seed: int = 0, label: float | None = None):
    settings = VesselSettings(
        categories=(category,),
        closed_probability=probability,
        label_probability=probability if label is None else label,
        fill_probability=fill,
        fill=(0.4, 0.5),
    )
    (body,), parts = draw_vessels(settings, seed, 0, 1, AssetFiles())
    return body, parts[body.name]


@pytest.mark.parametrize("category", PARTS)
def test_parts_are_closed_objects_that_touch_their_vessel_and_are_not_in_it(category):
    body, parts = _drawn(category)
    assert len(parts) == len(PARTS[category])
    for part, names in zip(parts, PARTS[category], strict=True):
        assert part.category in names
        assert part.part_of == body.name
        assert part.name == f"{body.name}-{part.category}"
        check_closed(part.name, body_mesh(part))
        assert isinstance(part, GlassBody) == (part.category == "stopper" or category == "teapot")
    for one, other in combinations([body, *parts], 2):
        check_pair(one, solid_of(one), other, solid_of(other))


def test_a_cap_clears_the_crown_of_a_neck_that_flares():
    """The rim of such a neck is rounded beyond the end of its outline; caps were drawn around the outline alone."""
    body, (cap,) = _drawn("square bottle", seed=32, label=0.0)
    assert cap.category == "cap"
    check_pair(body, solid_of(body), cap, solid_of(cap))


def test_probabilities_of_zero_leave_vessels_as_they_are():
    assert _drawn("bottle", 0.0)[1] == ()


def test_what_does_not_stand_lies_or_is_held():
    body, parts = _drawn("test tube", 0.0)
    assert body.liquid is not None
    assert not lies(body, parts)
    assert lies(body, ())


def test_graduations_lie_at_the_heights_of_their_volumes():
    body, (scale,) = _drawn("spouted beaker")
    assert isinstance(body, MeshVessel)
    assert isinstance(scale, Prop)
    bottoms = np.unique(np.round(scale.mesh.vertices[:, 2] + scale.world_T_object[2, 3], 6))
    cavity = body.cavities[0]
    assert cavity.floor < bottoms.min()
    assert bottoms.max() < cavity.brim
