"""Labels of vessels with all kinds of contents are found correct."""

from __future__ import annotations

import pytest

from glassware.dataset.pipeline import write
from glassware.dataset.settings.draw import draw
from glassware.dataset.verification.scene import scene_label_faults

SETTINGS = {
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
