"""Error and time of the renderer on the five scenes, for tuning it.

    python bench/quality.py --scenes filled --spp 16

relMSE is the mean of (I - R)^2 / (R^2 + 0.01) over pixels and channels of the exposed linear picture, less what R's own
noise adds. R is a mean of many passes of the same renderer with other seeds; it is kept in a folder and made only once
for a scene. The file's name follows the scene and the picture's size, not the renderer's code: delete the folder after
a change that moves the converged picture (a mended fault), keep it after one that only lowers the noise.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from command import PictureOptions, run
from ours import Ours, our_reference, prepare, render
from picture import write_exposed
from references import RELMSE_EPSILON, Reference
from scenes import bench_scene
from table import Row, report

from glassware.render.pictures.guides import trace_guides

#: A reference whose own noise is more than this fraction of a figure makes that figure doubtful.
FLOOR_FRACTION = 0.1


@dataclass(frozen=True, kw_only=True)
class Options(PictureOptions):
    """What to measure."""

    spp: tuple[int, ...] = (16,)
    """Samples per pixel, each measured."""
    repeats: int = 1
    """Pictures with different seeds that each figure is the mean of."""
    lambertian: bool = False
    """Make opaque surfaces ideal diffusers, as the comparison with Cycles does."""


def main(options: Options) -> int:
    """Measure and print."""
    rows = [row for name in options.scenes for row in _scene_rows(name, options)]
    size = f"{options.width}x{options.height}"
    return report(f"Renderer, {size}", rows, options.json_file, reference_spp=options.reference_spp)


def _scene_rows(name: str, options: Options) -> list[Row]:
    ours = prepare(bench_scene(name, options.width, options.height), options.lambertian)
    kept = our_reference(ours, options.cache, options.reference_spp, options.lambertian)
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
    runs = [render(ours, spp, seed=1 + repeat) for repeat in range(options.repeats)]
    noisy, clean = (float(x) for x in np.mean([run.errors(ours.exposure, kept) for run in runs], axis=0))
    denoise = float(np.mean([run.denoise_seconds for run in runs]))
    trace = float(np.mean([run.seconds for run in runs])) - denoise
    shown = runs[0].denoised * ours.exposure
    if options.pictures is not None:
        write_exposed(options.pictures / f"{name}-{spp}-noisy.png", runs[0].noisy * ours.exposure)
        write_exposed(options.pictures / f"{name}-{spp}-clean.png", shown)
    at, floor = f"{name}, {spp} spp:", kept.floor
    doubt = "" if floor < FLOOR_FRACTION * clean else f"noise of the reference is {floor:.2g}: more --reference-spp"
    return [
        Row(f"{at} relMSE before denoising", noisy),
        Row(f"{at} relMSE after denoising", clean, note=doubt),
        Row(f"{at} fraction of that in pixels that show glass", 100.0 * _in_glass(ours, kept, shown), "%"),
        Row(f"{at} tracing", trace, "s"),
        Row(f"{at} denoising", denoise, "s"),
        Row(f"{at} samples", spp * options.width * options.height / trace / 1e6, "M/s"),
    ]


def _in_glass(ours: Ours, kept: Reference, picture: np.ndarray) -> float:
    """Return the fraction of the squared relative error that lies in pixels that show glass."""
    glass = trace_guides(ours.loaded, ours.loaded.description.cameras[0]).glass
    R = kept.picture
    error = (((picture - R) ** 2 - kept.variance) / (R**2 + RELMSE_EPSILON)).mean(-1)
    return float(error[glass].sum() / error.sum())


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
