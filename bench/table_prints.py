"""What prints on tables cost, and scenes with them side by side: the picture in `docs/world.md`.

``python bench/table_prints.py 30``: for the tables of as many scenes of the preset ``train`` whose tables have prints,
the processor time that drawing them, their surfaces, and the table's picture for the renderer take, and its size.
``--picture prints.jpg --seeds 1 3`` renders a view of these seeds of the preset instead, each on a table with prints.
"""

from __future__ import annotations

import argparse
import sys
from time import process_time

import imageio.v3 as iio
import numpy as np
from gallery_seeds import rendered, sheet

from glassware.core.randomness import stream
from glassware.dataset.settings.config import preset, validated
from glassware.procedural.description.scene import Scene
from glassware.procedural.patterns.bake import bake_material
from glassware.procedural.primitives import scenes
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.table import TableSettings, draw_table
from glassware.procedural.tables.printed_top import printed_top
from glassware.render.backend.variant import activate

#: Columns of the table of times.
PARTS = ("drawing [s]", "their surfaces [s]", "the top's picture [s]", "all [s]", "texels [10^6]", "memory [MB]")
#: Bytes of a texel in the renderer [B]: three colours, roughness, metalness, and the four maps, float32.
TEXEL_BYTES = 36
#: What the picture shows: the preset's tables of three kinds, each with prints, and few objects.
SHOWN = {
    "preset": "train",
    "table": {"print_probability": 1.0, "kinds": ["wood", "stone", "laminate"]},
    "vessel_count": (1, 3),
    "prop_count": (0, 2),
}


def main() -> None:
    """Measure, or render what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=30, help="tables with prints")
    parser.add_argument("--picture", help="file of a picture")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3], help="of the picture")
    parser.add_argument("--width", type=int, default=320, help="of each view [px]")
    request = parser.parse_args()
    if request.picture:
        iio.imwrite(request.picture, sheet([rendered(seed, request.width, 16, **SHOWN) for seed in request.seeds]))
        return
    rows = np.array(measured(request.count))
    for name, column in zip(PARTS, rows.T, strict=True):
        sys.stdout.write(f"{name:24} mean {column.mean():6.3f}, most {column.max():6.3f}\n")


def measured(count: int) -> list[list[float]]:
    """Return the figures of tables with prints, a row for each."""
    settings = validated(SceneSettings, preset("train"), "preset").table
    activate()
    # Whatever is loaded or compiled once in a process.
    _costs(settings, 0)
    rows, scene = [], 0
    while len(rows) < count:
        scene += 1
        if (costs := _costs(settings, scene)) is not None:
            rows.append(costs)
    return rows


def _costs(settings: TableSettings, number: int) -> list[float] | None:
    from glassware.render.scene.bodies import scene_bodies

    names = ("table", "table/kind", "table/prints")
    first, second, third = (stream(12, number, name) for name in names)
    own = draw_table(first, settings, (), second)
    start = process_time()
    table = draw_table(stream(12, number, names[0]), settings, (), stream(12, number, names[1]), third)
    drawn = process_time() - start
    start = process_time()
    draw_table(stream(12, number, names[0]), settings, (), stream(12, number, names[1]))
    drawn -= process_time() - start
    if not table.prints:
        return None
    bake_material(own.material)
    start = process_time()
    for item in table.prints:
        bake_material(item.material)
    surfaces = process_time() - start
    view = scenes.camera((0.0, -0.5, 0.5))

    def loading(scene: Scene) -> float:
        start = process_time()
        scene_bodies(scene, False)
        return process_time() - start

    without, with_them = (loading(scenes.scene([], [view], table=one)) for one in (own, table))
    texels = int(np.prod(printed_top(table).colour.shape[:2]))
    top = with_them - without
    return [drawn, surfaces, top, drawn + surfaces + top, 1e-6 * texels, 1e-6 * texels * TEXEL_BYTES]


if __name__ == "__main__":
    main()
