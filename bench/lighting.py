"""Print the light of drawn scenes in photometric units: illuminance on the table, luminance and flux of lamps.

    python bench/lighting.py [--seeds 1:101] [--hdri-dir FOLDER]

Nothing is rendered.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

import numpy as np
from table import Row, report

from glassware.core.randomness import stream
from glassware.dataset.settings.scene_ranges import parse_scenes
from glassware.procedural.surroundings.environments import bake_environment, draw_environment
from glassware.procedural.surroundings.file_light import is_outdoors
from glassware.procedural.surroundings.lights import draw_lights
from glassware.procedural.surroundings.photometry import photometry
from glassware.procedural.surroundings.settings import EnvironmentSettings, LightSettings

#: Distance of the farthest camera from the table's centre [m], in the middle of those of drawn scenes.
REACH = 1.1


def measured(seeds: list[int], settings: EnvironmentSettings) -> dict[str, dict[str, list[float]]]:
    """Return illuminance by surroundings; luminance, flux and illuminance by kind of lamp: values by unit and kind."""
    found: dict[str, dict[str, list[float]]] = {"lx": defaultdict(list), "cd/m^2": defaultdict(list)}
    found |= {"lm": defaultdict(list), "lx by lamp": defaultdict(list)}
    for seed in seeds:
        environment = draw_environment(stream(seed, 0, "environment"), settings)
        pixels = bake_environment(environment)
        lights = draw_lights(stream(seed, 0, "lights"), LightSettings(), REACH, environment, pixels)
        light = photometry(environment, lights)
        outdoors = "outdoors" if is_outdoors(environment, pixels) else "indoors"
        place = environment.kind if environment.kind != "picture" else f"map, {outdoors}"
        found["lx"][place].append(light.environment_illuminance)
        found["lx"][f"{place}, with lamps"].append(light.illuminance)
        for lamp in light.lamps:
            found["cd/m^2"][lamp.kind].append(lamp.luminance)
            found["lm"][lamp.kind].append(lamp.flux)
            found["lx by lamp"][lamp.kind].append(lamp.illuminance)
    return found


def main() -> None:
    """Print the median, 5 % and 95 % of each quantity."""
    parser = argparse.ArgumentParser(description="Print the light of drawn scenes in photometric units.")
    parser.add_argument("--seeds", default="1:101", help="such as 1:101, without the end")
    parser.add_argument("--hdri-dir", type=Path, help="folder of environment maps; rooms and skies without it")
    arguments = parser.parse_args()
    settings = EnvironmentSettings(hdri_dir=arguments.hdri_dir)
    rows = []
    for unit, kinds in measured(parse_scenes(arguments.seeds), settings).items():
        for kind, values in sorted(kinds.items()):
            low, middle, high = np.percentile(values, (5, 50, 95))
            rows.append(Row(kind, middle, unit, note=f"5 % {low:,.0f}, 95 % {high:,.0f}, {len(values)} drawn"))
    report("light of drawn scenes, median", rows, seeds=arguments.seeds, hdri_dir=arguments.hdri_dir)


if __name__ == "__main__":
    main()
