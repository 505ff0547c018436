"""Drawn scenes, loaded once, under environment maps that take no time to bake."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.scene.loaded_scene import load

#: Vessels that let all light through: clear, open, with nothing on them and one clear liquid in them.
ALL_CLEAR = {
    "categories": ("tumbler", "beaker", "bowl", "bottle", "stem glass", "flask", "vase", "freeform"),
    "contents": dict.fromkeys(("layered", "turbid", "ice", "beads", "bubbles", "standing"), 0.0),
    "closed_probability": 0.0,
    "label_probability": 0.0,
}


def write_exr_map(path: Path, pixels: np.ndarray) -> Path:
    """Write a panorama, (h, 2 * h, 3)."""
    planes = {name: np.ascontiguousarray(pixels[..., i], dtype=np.float32) for i, name in enumerate("RGB")}
    path.parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File({}, planes).write(str(path))
    return path


@pytest.fixture(scope="session")
def panorama(tmp_path_factory) -> Callable[[np.ndarray], Path]:
    """Pixels -> a folder that holds them as the only environment map."""
    return lambda pixels: write_exr_map(tmp_path_factory.mktemp("hdri") / "map.exr", pixels).parent


@pytest.fixture(scope="session")
def even_light(panorama) -> Path:
    """An environment of radiance 1 in every direction: a white furnace."""
    return panorama(np.ones((8, 16, 3)))


@pytest.fixture(scope="session")
def sky_light(panorama) -> Path:
    """A soft gradient with a brighter side."""
    rows, columns = np.mgrid[:16, :32]
    pixels = 0.3 + 0.5 * (rows < 8) + 2.0 * np.exp(-((rows - 5) ** 2 + (columns - 20) ** 2) / 12.0)
    return panorama(np.repeat(pixels[..., None], 3, axis=2) * [1.0, 0.9, 0.8])


@pytest.fixture(scope="session")
def drawn(sky_light) -> Callable[..., Scene]:
    """(seed, settings by name) -> a scene of small pictures and few samples."""

    def draw(seed: int, **settings: Any) -> Scene:
        base = {
            "vessel_count": (2, 2),
            "prop_count": (2, 2),
            # Shapes on a board without relief: no test has to compile the kernels of maps for them.
            "props": {"kinds": "shape"},
            "table": {"kinds": "plain"},
            "vessels": {"fill_probability": 1.0, "chord_error": 5e-5, "rough_probability": 0.0},
            "environment": {"hdri_dir": sky_light, "hdri_calibrated": True},
            "lights": {"max_count": 1},
            "physics": {"piled_probability": 0.0},
            "cameras": {"views": 2, "width": 64, "height": 48},
            "picture": {"spp": 4},
        }
        return draw_scene(SceneSettings.model_validate(base | settings), seed, 0)

    return draw


@pytest.fixture(scope="session")
def all_clear() -> dict[str, Any]:
    """Settings of vessels: `ALL_CLEAR`."""
    return ALL_CLEAR


@pytest.fixture(scope="session")
def glasses(drawn) -> Scene:
    """Filled vessels of several families and a prop, smooth."""
    vessels = {"fill_probability": 1.0, "chord_error": 5e-5, "rough_probability": 0.0} | ALL_CLEAR
    return drawn(5, vessel_count=(4, 4), prop_count=(1, 1), vessels=vessels)


@pytest.fixture
def loaded_glasses(backend, glasses):
    """The same, loaded for one test: where another scene is in memory, kernels are compiled anew for the next."""
    return load(glasses)


@pytest.fixture(scope="session")
def clear() -> Callable[[Scene], Scene]:
    """Scene -> the same without absorption in any medium."""

    def medium(item):
        return item.model_copy(update={"sigma_a": (0.0, 0.0, 0.0), "absorbers": ()})

    def cleared(scene):
        for item in scene.vessels:
            scene = scene.with_glass(item.name, medium(item.glass))
            if item.liquid is not None:
                # What stands in the liquid gets it as well.
                scene = scene.with_liquid(item.name, medium(item.liquid.medium))
        return scene

    return cleared
