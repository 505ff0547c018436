"""Labels of rooms in their places are proved against their walls, furniture and lamps."""

from __future__ import annotations

import numpy as np
import pytest

import glassware as gw
from glassware.dataset.format.exr import read_exr, write_exr
from glassware.dataset.format.pictures import read_png
from glassware.dataset.verification.scene import scene_label_faults
from glassware.procedural.description.surroundings import FIRST_ROOM_ID


@pytest.mark.slow
def test_a_room_in_its_place_has_right_labels_and_a_wrong_wall_is_found(tmp_path):
    scene = gw.draw(
        3,
        vessel_count=(1, 2),
        prop_count=(1, 1),
        props={"kinds": ["shape"]},
        physics={"piled_probability": 0},
        environment={"shipped_share": 0.0, "room_share": 1.0, "room_depth": True},
        cameras={"views": 2, "width": 64, "height": 48},
        picture={"spp": 1, "light": "path", "denoise": False},
    )
    gw.write(tmp_path / "out", scene, files="all")
    assert list(scene_label_faults(tmp_path / "out", 0)) == []

    view = next((tmp_path / "out").glob("scenes/*/001"))
    walls = read_png(view / "instances.png") >= FIRST_ROOM_ID
    assert walls.sum() > 100
    depth = read_exr(view / "geometry.exr")
    depth["Z"] = np.where(walls, depth["Z"] + 0.02, depth["Z"]).astype(np.float32)
    write_exr(view / "geometry.exr", depth)
    assert any("geometry.exr: depth: " in fault for fault in scene_label_faults(tmp_path / "out", 0))
