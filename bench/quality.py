"""Error and time of our own renderer on the five scenes, for tuning it.

    python bench/quality.py --scenes filled --spp 16

relMSE is the mean of (I - R)^2 / (R^2 + 0.01) over pixels and channels of the exposed linear picture, less what R's own
noise adds. R is a mean of many passes of the same renderer with other seeds; it is kept in a folder and made only once
for a scene. The file's name follows the scene and the picture's size, not the renderer's code: delete the folder after
a change that moves the converged picture (a mended fault), keep it after one that only lowers the noise.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from each_scene import report_scenes
from ours import Ours, Rendered, loaded, our_reference, render
from pngs import write_exposed
from references import RELMSE_EPSILON, Reference, relmse
from scenes import NAMES, bench_scene
from table import Row

from glassware.render.pictures.guides import trace_guides

#: A reference whose own noise is more than this share of a figure makes that figure doubtful.
FLOOR_SHARE = 0.1


@dataclass(frozen=True)
class Options:
    """What to measure."""

    scenes: tuple[str, ...] = NAMES
    """Which of the five scenes."""
    spp: tuple[int, ...] = (16,)
    """Samples per pixel, each measured."""
    width: int = 320
    """Width of the picture [px]."""
    height: int = 180
    """Height of the picture [px]."""
    repeats: int = 1
    """Pictures with different seeds that each figure is the mean of."""
    reference_spp: int = 4096
    """Samples per pixel of the references."""
    plain: bool = False
    """Draw opaque surfaces as ideal diffusers, as the comparison with Cycles does."""
    cache: Path = Path(".scratch/references")
    """Folder of the references."""
    pictures: Path | None = None
    """Folder for PNG files of what was measured: reference, noisy and denoised."""
    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


def main() -> int:
    """Measure and print."""
    options = tyro.cli(Options, description=__doc__)
    return report_scenes("Our renderer", options, lambda name: _scene_rows(name, options))


def _scene_rows(name: str, options: Options) -> list[Row]:
    scene = bench_scene(name, options.width, options.height)
    ours = loaded(scene, options.plain)
    kept = our_reference(ours, options.cache, options.reference_spp, options.plain)
    rows = [
        Row(f"{name}: loading", ours.load_seconds, "s"),
        Row(f"{name}: first picture of 1 sample, with compilation", ours.compile_seconds, "s"),
    ]
    for spp in options.spp:
        rows += _sample_rows(name, ours, kept, spp, options)
    if options.pictures is not None:
        write_exposed(options.pictures / f"{name}-reference.png", kept.picture)
    return rows


def _sample_rows(name: str, ours: Ours, kept: Reference, spp: int, options: Options) -> list[Row]:
    exposure = ours.kernel.description.cameras[0].exposure
    runs = [render(ours, spp, seed=1 + repeat) for repeat in range(options.repeats)]
    noisy = float(np.mean([relmse(run.noisy * exposure, kept) for run in runs]))
    clean = float(np.mean([relmse(run.denoised * exposure, kept) for run in runs]))
    trace, denoise = (float(np.mean(values)) for values in zip(*_times(runs), strict=True))
    if options.pictures is not None:
        write_exposed(options.pictures / f"{name}-{spp}-noisy.png", runs[0].noisy * exposure)
        write_exposed(options.pictures / f"{name}-{spp}-clean.png", runs[0].denoised * exposure)
    floor = kept.floor
    at = f"{name}, {spp} spp:"
    doubt = "" if floor < FLOOR_SHARE * clean else f"reference's own noise is {floor:.2g}: more --reference-spp"
    return [
        Row(f"{at} relMSE before denoising", noisy),
        Row(f"{at} relMSE after denoising", clean, note=doubt),
        Row(f"{at} share of that where glass is seen", 100.0 * _in_glass(ours, kept, runs[0].denoised * exposure), "%"),
        Row(f"{at} tracing", trace, "s"),
        Row(f"{at} denoising", denoise, "s"),
        Row(f"{at} samples", spp * options.width * options.height / trace / 1e6, "M/s"),
    ]


def _in_glass(ours: Ours, kept: Reference, picture: np.ndarray) -> float:
    """Return the share of the squared relative error that lies in pixels that show glass."""
    glass = trace_guides(ours.kernel, ours.kernel.description.cameras[0]).glass
    R = kept.picture
    error = (((picture - R) ** 2 - kept.variance) / (R**2 + RELMSE_EPSILON)).mean(-1)
    return float(error[glass].sum() / error.sum())


def _times(runs: list[Rendered]) -> list[tuple[float, float]]:
    return [(run.trace_seconds, run.denoise_seconds) for run in runs]


if __name__ == "__main__":
    sys.exit(main())
