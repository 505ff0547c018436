"""How long a spectral view takes with and without a sensor of measured sensitivities, by turns in one run.

python bench/sensor.py
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np
import tyro
from rich.console import Console

import glassware as gw


@dataclass(frozen=True)
class Run:
    """The scene, its size, and how often it is rendered."""

    seed: int = 7
    width: int = 320  #: [px]
    height: int = 240  #: [px]
    spp: int = 16
    repeats: int = 3


def renderer(run: Run, sensor: str) -> gw.Renderer:
    """Return the renderer of a scene without depth maps, by a sensor or by the eye alone."""
    picture = {"spectral": True, "spp": run.spp, "layers": 0, "refraction": False}
    cameras = {"width": run.width, "height": run.height, "views": 1}
    return gw.Renderer(gw.draw(run.seed, picture=picture, cameras=cameras, sensors={"sensitivities": sensor}))


def main(run: Run) -> None:
    """Print the processor time of a view of each, and the ratio."""
    both = {name: renderer(run, name) for name in ("none", "nikon-d5100")}
    seconds: dict[str, list[float]] = {name: [] for name in both}
    for _ in range(run.repeats + 1):  # the first compiles
        for name, one in both.items():
            begun = process_time()
            one.frame(0)
            seconds[name].append(process_time() - begun)
    means = {name: float(np.mean(times[1:])) for name, times in seconds.items()}
    console = Console()
    for name, mean in means.items():
        console.print(f"{name}: {mean:.2f} s of processor time a view ({min(seconds[name][1:]):.2f} at least)")
    console.print(f"ratio {means['nikon-d5100'] / means['none']:.2f}")


if __name__ == "__main__":
    main(tyro.cli(Run))
