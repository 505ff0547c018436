"""Scenes from Python: `draw` takes the settings that a YAML file or the command line would give."""

from __future__ import annotations

from typing import Any

from ...core.arguments import whole_number
from ...core.randomness import MOST_SEED
from ...procedural.description.scene import Scene
from ...procedural.scene.draw import draw_scene
from ...procedural.scene.settings import SceneSettings
from .camera_layer import with_cameras
from .config import check_booleans, merged, validated
from .config import preset as preset_named

#: Largest number of a scene: folders have six digits.
MOST_SCENE = 999_999


def draw(seed: int, scene: int = 0, preset: str = "fast", **settings: Any) -> Scene:
    """Draw a scene from a seed.

    Parameters
    ----------
    seed : int
        Seed of the data set, 0 to 2^63 - 1. The same seed and settings give the same scene.
    scene : int
        Number of the scene in the data set.
    preset : str
        Settings to start from: ``"fast"``, ``"keypose"``, ``"standard"``, ``"syn-todd"`` or ``"train"``.
    **settings
        Groups of settings on top of the preset, by name, as in a YAML file of settings (docs/settings.md), such as
        ``vessels={"categories": ["bottle"]}`` or ``cameras={"views": 2}``.

    Raises
    ------
    InputError
        For an unknown or impossible setting, or objects that do not fit on the table.
    """
    seed = whole_number("draw: seed", seed, 0, MOST_SEED)
    scene = whole_number("draw: scene", scene, 0, MOST_SCENE)
    below = preset_named(preset, "draw: preset")
    requested = merged(below, settings) | with_cameras(below, settings)
    check_booleans(SceneSettings, settings, "draw")
    return draw_scene(validated(SceneSettings, requested, "draw"), seed, scene)
