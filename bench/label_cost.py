"""What K layers and the refracted ray cost beside the pictures: one view at the `standard` preset, in one run.

python bench/label_cost.py [--views 3] [--json FILE]
"""

from __future__ import annotations

import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path
from time import perf_counter

from table import Row, report

from glassware.dataset.format.ray_files import write_layers, write_refraction
from glassware.dataset.settings.config import preset
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.backend.variant import activate

#: Most that layers and refraction may take of the pictures' time.
BOUND = 0.1
SEED, SCENE = 7, 4


def main() -> int:
    """Measure and print; 1 where the bound is broken."""
    options = ArgumentParser(description=__doc__)
    options.add_argument("--views", type=int, default=2)
    options.add_argument("--json", type=Path)
    given = options.parse_args()
    variant = activate()
    from glassware.render.labels.geometry import trace_geometry
    from glassware.render.scene.loaded_scene import load
    from glassware.render.view import render_view

    scene = draw_scene(SceneSettings.model_validate(preset("standard")), SEED, SCENE)
    kernel = load(scene)
    warm = scene.picture.model_copy(update={"spp": 1})
    render_view(load(scene.model_copy(update={"picture": warm})), 0)
    trace_geometry(kernel, scene.cameras[0])
    taken = {"picture": 0.0, "geometry": 0.0, "plain": 0.0, "refraction": 0.0, "writing": 0.0}
    size = 0
    for number in range(given.views):
        start = perf_counter()
        trace_geometry(kernel, scene.cameras[number])
        taken["plain"] += perf_counter() - start
        frame = render_view(kernel, number)
        for name in ("picture", "geometry", "refraction"):
            taken[name] += frame.seconds[name]
        with tempfile.TemporaryDirectory() as folder:
            start = perf_counter()
            write_layers(Path(folder, "layers.exr"), frame.layers)
            write_refraction(Path(folder, "refraction.exr"), frame.refraction)
            taken["writing"] += perf_counter() - start
            size += sum(path.stat().st_size for path in Path(folder).iterdir())
    taken = {name: seconds / given.views for name, seconds in taken.items()}
    layers = taken["geometry"] - taken["plain"]
    share = (layers + taken["refraction"]) / taken["picture"]
    rows = [
        Row("both pictures", taken["picture"], "s"),
        Row("straight rays without layers", taken["plain"], "s"),
        Row(f"{scene.picture.layers} layers, more than that", layers, "s"),
        Row("refracted rays", taken["refraction"], "s"),
        Row("layers and refraction / pictures", share, "", bound=BOUND, ratio=share / BOUND, ok=share <= BOUND),
        Row("writing both files", taken["writing"], "s", note="not in the share"),
        Row("size of both files", size / given.views / 1e6, "MB"),
    ]
    facts = {"scene": f"standard preset, seed {SEED}, scene {SCENE}", "views": given.views, "variant": variant}
    return report("K layers and refraction", rows, given.json, **facts)


if __name__ == "__main__":
    sys.exit(main())
