"""Draw and render scenes of the default settings side by side: the pictures in `docs/world.md`.

``python bench/gallery_seeds.py out.jpg --seeds 1 24``: one view of each seed, in the order of reading. The processor
time of each and what is in it are printed. ``--assets DIR`` uses files as well, of DIR/hdri, DIR/meshes and
DIR/textures. Light is stored (`picture.light: shared`), as a default scene with its five views has it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import process_time
from types import MappingProxyType
from typing import Any

import imageio.v3 as iio
import numpy as np

import glassware as gw
from glassware.core.images import srgb8

#: Pictures in a row [1].
ACROSS = 3
EMPTY: Mapping[str, object] = MappingProxyType({})


def main() -> None:
    """Render the seeds that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path")
    parser.add_argument("--seeds", type=int, nargs=2, default=[1, 24], help="first and last")
    parser.add_argument("--width", type=int, default=240, help="of each picture [px]; its height is 3/4 of it")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel")
    parser.add_argument("--across", type=int, default=ACROSS, help="pictures in a row")
    parser.add_argument("--assets", type=Path, help="folder with hdri, meshes and textures")
    request = parser.parse_args()
    files: dict[str, Any] = {} if request.assets is None else of_files(request.assets)
    pictures: list[np.ndarray] = []
    for seed in range(request.seeds[0], request.seeds[1] + 1):
        pictures.append(rendered(seed, request.width, request.spp, "shared", **files))
        iio.imwrite(request.path, sheet(pictures, request.across))


def of_files(folder: Path) -> dict[str, Any]:
    """Return the settings that use the files of a folder's subfolders."""
    light = {"hdri_dir": folder / "hdri"}
    return {"environment": light, "mesh_dir": folder / "meshes", "texture_dir": folder / "textures"}


def rendered(
    seed: int,
    width: int,
    spp: int,
    light: str = "path",
    *,
    cameras: Mapping[str, object] = EMPTY,
    picture: Mapping[str, object] = EMPTY,
    **settings: object,
) -> np.ndarray:
    """Return the picture of a seed, (H, W, 3) uint8, with some more settings; path-traced or with `light` stored."""
    start = process_time()
    scene = gw.draw(
        seed=seed,
        cameras={"views": 1, "width": width, "height": 3 * width // 4, **cameras},
        picture={"spp": spp, "light": light, "layers": 0, "refraction": False, **picture},
        **settings,
    )
    drawn = process_time()
    frame = gw.Renderer(scene).frame(0)
    names = ", ".join(str(item.category) for item in (*scene.vessels, *scene.props))
    times = f"drawn in {drawn - start:.1f} s, rendered in {process_time() - drawn:.1f} s"
    sys.stdout.write(f"{seed}: {times}; {scene.table.kind}, {scene.environment.kind}: {names}\n")
    sys.stdout.flush()
    return srgb8(np.asarray(frame.left, np.float32), scene.cameras[0].exposure)


def sheet(pictures: Sequence[np.ndarray], across: int = ACROSS) -> np.ndarray:
    """Return pictures of one size in rows, those that are missing in the last row black."""
    columns = min(across, len(pictures))
    missing = -len(pictures) % columns
    cells = [*pictures, *[np.zeros_like(pictures[0])] * missing]
    rows = [np.concatenate(cells[i : i + columns], axis=1) for i in range(0, len(cells), columns)]
    return np.concatenate(rows)


if __name__ == "__main__":
    main()
