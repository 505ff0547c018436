"""Presets draw the same worlds: they differ in cameras and pictures."""

from __future__ import annotations

import json
from functools import lru_cache
from hashlib import sha256

import pytest

from glassware.core.json_file import json_text
from glassware.core.mesh import Mesh
from glassware.dataset.settings.config import merged, preset, preset_names, validated
from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings

#: Presets of one world, and what of a scene each may have otherwise: lamps keep clear of the nearer cameras of `train`,
#: and its tables have prints.
SAME = {
    "fast": {"cameras", "picture"},
    "syn-todd": {"cameras", "picture"},
    "train": {"cameras", "picture", "lights", "table"},
}


def _digest(mesh: Mesh) -> str:
    return sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()


@lru_cache
def _world(name: str, scene: int = 3) -> dict[str, str]:
    few = {"vessel_count": [1, 1], "prop_count": [1, 1], "environment": {"room_share": 0.0, "shipped_share": 0.0}}
    settings = validated(SceneSettings, merged(preset(name), few), "preset")
    drawn: Scene = draw_scene(settings, 5, scene)
    fields = drawn.model_dump(mode="json", context={"write_mesh": _digest})
    return {field: json_text(value) for field, value in fields.items()}


def test_every_preset_is_of_the_world_of_the_standard_one_or_has_one_object():
    assert {*SAME, "standard", "keypose"} == set(preset_names())
    settings = validated(SceneSettings, preset("keypose"), "preset")
    assert (settings.vessel_count, settings.prop_count) == ((1, 1), (0, 0))


@pytest.mark.parametrize("name", SAME)
def test_a_seed_is_the_same_world_in_presets_that_differ_in_cameras(name):
    standard, other = _world("standard"), _world(name)
    differs = {field for field in standard if standard[field] != other[field]}
    assert differs <= SAME[name]
    assert "cameras" in differs


def test_prints_are_all_that_other_tables_of_a_seed_have():
    tables = {name: json.loads(_world(name, 6)["table"]) for name in ("standard", "train")}
    assert "prints" not in tables["standard"]
    assert tables["train"].pop("prints", None)
    assert tables["train"] == tables["standard"]
