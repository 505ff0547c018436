"""Labels of vessels with all kinds of contents are found correct."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.dataset.format.objects_file import objects_file
from glassware.dataset.pipeline import write
from glassware.dataset.settings.draw import draw
from glassware.dataset.verification.description import object_faults
from glassware.dataset.verification.scene import scene_label_faults

SETTINGS: dict[str, Any] = {
    "vessel_count": [1, 1],
    "prop_count": [1, 1],
    "props": {"kinds": ["shape"]},
    "physics": {"piled_probability": 0.0},
    "cameras": {"width": 48, "height": 36, "views": 1},
    "picture": {"spp": 1, "denoise": False, "light": "path"},
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "content"),
    [
        ("tumbler", "turbid"),
        ("mug", "turbid"),
        ("tumbler", "layered"),
        ("tumbler", "ice"),
        ("tumbler", "beads"),
        ("tumbler", "bubbles"),
        ("beaker", "standing"),
    ],
)
def test_correct_labels_of_what_vessels_hold_pass(backend, tmp_path, family, content):
    vessels = {"categories": [family], "chord_error": 1e-4, "fill_probability": 1.0, "fill": [0.4, 0.6]}
    scene = draw(5, 0, **SETTINGS, vessels=vessels | {"contents": {content: 1.0}})
    (body,) = scene.vessels
    assert body.liquids
    assert any(liquid.turbid for liquid in body.liquids) == (content == "turbid")
    write(tmp_path / "data", scene, files="all")
    assert list(scene_label_faults(tmp_path / "data", 0)) == []


@pytest.mark.parametrize(("seed", "body"), [(3, "spoon"), (9, "stirring rod")])
def test_what_stands_in_little_liquid_is_none_of_its_volume(seed, body):
    """The liquid's surface has a hole where the body goes through: that alone is 5 % more than the liquid."""
    vessels = {"categories": ["tumbler"], "chord_error": 2e-4, "fill_probability": 1.0, "fill": [0.06, 0.08]}
    vessels |= {"contents": {"standing": 1.0}}
    settings: dict[str, Any] = {**SETTINGS, "prop_count": [0, 0], "vessels": vessels}
    scene = draw(seed, 0, **settings)
    assert [item.category for item in scene.objects if item.within is not None] == [body]
    records = objects_file(scene, scene_keypoints(scene))
    assert object_faults(scene, records, "objects.json") == []
    vessel = records.objects[0]
    assert vessel.volumes is not None
    more = vessel.volumes.model_copy(update={"liquid": 1.03 * vessel.volumes.liquid})
    wrong = records.model_copy(update={"objects": (vessel.model_copy(update={"volumes": more}), *records.objects[1:])})
    assert {fault.where for fault in object_faults(scene, wrong, "objects.json")} == {"object 2 volumes.liquid"}


def test_ice_above_the_rim_is_not_part_of_the_size():
    vessels = {"categories": ["tumbler"], "chord_error": 2e-4, "fill_probability": 1.0, "fill": [0.4, 0.6]}
    settings: dict[str, Any] = {**SETTINGS, "prop_count": [0, 0], "vessels": vessels | {"contents": {"ice": 1.0}}}
    scene = draw(5, 0, **settings)
    (vessel,) = scene.vessels
    parts = []
    for part in vessel.interfaces:
        rise = np.array([0.0, 0.0, vessel.size[2] if part.part == "content" else 0.0])
        parts.append(part.model_copy(update={"mesh": replace(part.mesh, vertices=part.mesh.vertices + rise)}))
    assert "content" in {part.part for part in parts}
    above = scene.model_copy(update={"vessels": (vessel.model_copy(update={"interfaces": tuple(parts)}),)})
    records = objects_file(above, scene_keypoints(above))
    assert [fault for fault in object_faults(above, records, "objects.json") if "size" in fault.where] == []
