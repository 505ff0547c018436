"""Draw and render scenes of the default settings side by side: the picture in `docs/world.md`.

``python bench/gallery_seeds.py out.jpg --seeds 1 24``: one view of each seed, in the order of reading. The processor
time of each and what is in it are printed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from time import process_time

import imageio.v3 as iio
import numpy as np

import glassware as gw
from glassware.core.images import srgb8

#: Pictures in a row [1].
ACROSS = 3


def main() -> None:
    """Render the seeds that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path")
    parser.add_argument("--seeds", type=int, nargs=2, default=[1, 24], help="first and last")
    parser.add_argument("--width", type=int, default=240, help="of each picture [px]; its height is 3/4 of it")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel")
    request = parser.parse_args()
    pictures: list[np.ndarray] = []
    for seed in range(request.seeds[0], request.seeds[1] + 1):
        pictures.append(rendered(seed, request.width, request.spp))
        iio.imwrite(request.path, sheet(pictures))


def rendered(seed: int, width: int, spp: int, **settings: object) -> np.ndarray:
    """Return the picture of a seed, (H, W, 3) uint8, with some more settings; path-traced."""
    start = process_time()
    scene = gw.draw(
        seed=seed,
        cameras={"views": 1, "width": width, "height": 3 * width // 4},
        picture={"spp": spp, "light": "path", "layers": 0, "refraction": False},
        **settings,
    )
    drawn = process_time()
    frame = gw.Renderer(scene).frame(0)
    names = ", ".join(str(item.category) for item in (*scene.vessels, *scene.props))
    times = f"drawn in {drawn - start:.1f} s, rendered in {process_time() - drawn:.1f} s"
    sys.stdout.write(f"{seed}: {times}; {scene.table.kind}, {scene.environment.kind}: {names}\n")
    sys.stdout.flush()
    return srgb8(np.asarray(frame.left, np.float32), scene.cameras[0].exposure)


def sheet(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Return pictures of one size in rows of `ACROSS`, those that are missing in the last row black."""
    columns = min(ACROSS, len(pictures))
    missing = -len(pictures) % columns
    cells = [*pictures, *[np.zeros_like(pictures[0])] * missing]
    rows = [np.concatenate(cells[i : i + columns], axis=1) for i in range(0, len(cells), columns)]
    return np.concatenate(rows)


if __name__ == "__main__":
    main()
