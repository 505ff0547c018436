"""How long colour cameras take to develop a picture of 640x480 px, files included.

python bench/develop.py
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np
import tyro
from rich.console import Console

from glassware.dataset.cameras.develop import PairLight, develop
from glassware.dataset.cameras.presets import CAMERAS
from glassware.dataset.format.exr import read_exr, unstacked, write_exr
from glassware.dataset.format.pictures import write_png


@dataclass(frozen=True)
class Run:
    """Size and number of the pictures."""

    width: int = 640  #: [px]
    height: int = 480  #: [px]
    repeats: int = 9


def pair(run: Run) -> PairLight:
    """Return smooth radiance with highlights, and a table's depth."""
    rng = np.random.default_rng(20230213)
    noise = rng.random((run.height, run.width, 3), np.float32)
    radiance = np.clip((cv2.GaussianBlur(noise, (0, 0), 6) - 0.45) * 8, 0, 8).astype(np.float32)
    Z = np.repeat(np.linspace(1.2, 0.5, run.height, dtype=np.float32)[:, None], run.width, axis=1)
    focal = 0.96 * run.width
    optics = (focal, focal, (run.width - 1) / 2, (run.height - 1) / 2)
    return PairLight(radiance, radiance[:, ::-1].copy(), Z, optics, baseline=0.065, exposure=1.0)


def main(run: Run) -> None:
    """Print the least and the median time of each camera."""
    light, console = pair(run), Console()
    with tempfile.TemporaryDirectory(prefix="glassware-bench-") as name:
        exr, png = Path(name, "light.exr"), Path(name, "picture.png")
        write_exr(exr, unstacked(light.left, "RGB"))
        for camera in CAMERAS.values():
            steps, files = [], []
            for view in range(run.repeats + 1):  # the first makes the maps that all views share
                begun = perf_counter()
                left, _ = develop(camera, light, 1, 0, view)
                middle = perf_counter()
                read_exr(exr)
                write_png(png, left)
                steps.append((middle - begun) / 2)
                files.append(perf_counter() - middle)
            text = f"{camera.name:8} {min(steps[1:]):.3f} s a picture (median {np.median(steps[1:]):.3f}, "
            console.print(text + f"first {steps[0]:.3f}), files {min(files):.3f} s", highlight=False)


if __name__ == "__main__":
    sys.exit(main(tyro.cli(Run)))
