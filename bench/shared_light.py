"""Light stored once per scene against light traced anew for every picture: time to equal error, and what it changes.

    python bench/shared_light.py --scenes filled clutter
    python bench/shared_light.py --scenes filled clutter --width 320 --height 240 --cycles-python ~/bpy/bin/python

One view of a scene is rendered both ways, in turn, at several numbers of samples, and compared with a path-traced
reference: relMSE after the denoiser, less what the reference's own noise adds. A whole scene is so many stereo views:
the time of a picture that often, and once the time to store the light. Then the mean of a picture from stored light is
compared with the reference's, region by region, and the time of one more view is told by what takes it.

With a Python that has Blender's package (`render_vs_cycles.py` tells how), Cycles renders the same view at `--level`
samples; stored light then has to reach the error that Cycles has after its denoiser, against its own reference.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated

import numpy as np
import tyro
from cycles.comparison import Options as PeerOptions
from cycles.comparison import peer_of
from cycles.peer import cycles_python
from each_scene import report_scenes
from light_regions import regions
from ours import Ours, loaded, our_reference, render
from pngs import write_exposed
from references import PASS_SPP, Reference, reference, relmse
from scenes import ALL_NAMES, NAMES, bench_scene, digest
from speed import Point, time_to
from table import Row

from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.irradiance_cache import IrradianceCache
from glassware.render.cache.trace_cached import cached_tracer
from glassware.render.pictures.guides import trace_guides
from glassware.render.pictures.picture import PATH_TRACER, Tracer

#: Least times that a whole scene of the most views must be faster than by paths and than Cycles, median over the
#: scenes; and the most that a region's mean may be off.
LEAST, LEAST_OF_CYCLES, BIAS = 3.0, 6.0, 0.01
#: Samples of the picture whose regions are compared.
_BIAS_SPP = 256


@dataclass(frozen=True)
class Options:
    """What to measure."""

    scenes: tuple[str, ...] = ALL_NAMES
    """Which of the six scenes."""
    spp: tuple[int, ...] = (8, 16, 32, 64)
    """Samples per pixel, each measured both ways."""
    level: int = 64
    """Samples of the path-traced picture, and of Cycles', whose error is to be reached."""
    views: tuple[int, ...] = (57, 5)
    """Stereo views of a scene, each judged."""
    paths: int = 40
    """Paths that find the light of a node, on the average; `render-scene` takes as many for large scenes."""
    repeats: int = 2
    """Pictures that each figure is the mean of."""
    width: int = 640
    """Width of the picture [px]."""
    height: int = 480
    """Height of the picture [px]."""
    reference_spp: int = 1024
    """Samples per pixel of the references."""
    cycles_python: Path | None = None
    """Python that has bpy 4.5; without it Cycles is left out."""
    cache: Path = Path(".scratch/references")
    """Folder of the references."""
    pictures: Path | None = None
    """Folder for PNG files: reference, both ways, and their difference from the reference."""
    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


@dataclass(frozen=True, eq=False)
class _Lit:
    """A scene with its light stored."""

    name: str
    ours: Ours
    stored: IrradianceCache
    tracer: Tracer
    seconds: float  #: that storing took
    kept: Reference

    @property
    def exposure(self) -> float:
        return self.ours.kernel.description.cameras[0].exposure


def main() -> int:
    """Measure and print."""
    options = tyro.cli(Options, description=__doc__)
    ratios: dict[str, list[float]] = {}
    names, last = options.scenes, options.scenes[-1]

    def rows_of(name: str) -> list[Row]:
        rows = _scene_rows(name, options, ratios)
        return rows + (_median_rows(ratios, names) if name == last else [])

    return report_scenes("Stored light", options, rows_of)


def _median_rows(ratios: dict[str, list[float]], names: tuple[str, ...]) -> list[Row]:
    rows = []
    for against, values in ratios.items():
        least = LEAST_OF_CYCLES if against == "Cycles" else LEAST
        middle = float(np.median(values))
        title = f"median of {len(values)} scenes: times faster than {against}"
        rows.append(Row(title, middle, bound=least, ok=middle >= least, note=" ".join(f"{x:.2f}" for x in values)))
    return rows


def _scene_rows(name: str, options: Options, ratios: dict[str, list[float]]) -> list[Row]:
    lit = _lit(name, options)
    rows = [
        Row(f"{name}: storing the light", lit.seconds, "s", note=f"{lit.stored.samples.sum()} paths"),
        Row(f"{name}: memory of the stored light", lit.stored.moments.nbytes / 1e6, "MB"),
    ]
    curves = _curves(lit, options)
    for path, shared in zip(*curves, strict=True):
        at = f"{name}, {path.spp} spp:"
        rows += [
            Row(f"{at} a picture", shared.seconds, "s", peer=path.seconds, ratio=path.seconds / shared.seconds),
            Row(f"{at} relMSE before denoising", shared.noisy, peer=path.noisy, ratio=path.noisy / shared.noisy),
            Row(f"{at} relMSE after denoising", shared.clean, peer=path.clean, ratio=path.clean / shared.clean),
        ]
    error = next(point for point in curves[0] if point.spp == options.level).clean
    for views in options.views:
        row = _whole_scene(lit, curves[1], views, error, time_to(curves[0], error)[0], "paths")
        if views == max(options.views):
            ratios.setdefault("paths", []).append(row.ratio or 0.0)
        rows.append(row)
    if options.cycles_python is not None and name in NAMES:
        rows.append(_against_cycles(lit, curves[1], options))
        ratios.setdefault("Cycles", []).append(rows[-1].ratio or 0.0)
    return [*rows, *_stage_rows(lit, curves[1]), *_bias_rows(lit, options)]


def _lit(name: str, options: Options) -> _Lit:
    ours = loaded(bench_scene(name, options.width, options.height), cut=True)
    kept = our_reference(ours, options.cache, options.reference_spp, plain=False)
    start = perf_counter()
    stored = fill_cache(ours.kernel, cache_points_of(ours.kernel), options.paths, seed=1)
    tracer = cached_tracer(ours.kernel, stored)
    return _Lit(name, ours, stored, tracer, perf_counter() - start, kept)


def _curves(lit: _Lit, options: Options) -> tuple[list[Point], list[Point]]:
    """Measure both ways in turn, so that whatever else the machine does meets both."""
    for tracer in (PATH_TRACER, lit.tracer):
        render(lit.ours, min(options.spp), 0, tracer=tracer)  # compiles, for more samples where glass is as well
    curves: tuple[list[Point], list[Point]] = ([], [])
    for spp in sorted({*options.spp, options.level}):
        figures: tuple[list, list] = ([], [])
        for repeat in range(options.repeats):
            for found, tracer in zip(figures, (PATH_TRACER, lit.tracer), strict=True):
                made = render(lit.ours, spp, repeat + 1, tracer=tracer)
                errors = [relmse(picture * lit.exposure, lit.kept) for picture in (made.noisy, made.denoised)]
                found.append((made.trace_seconds + made.denoise_seconds, *errors))
                if options.pictures is not None:
                    way = "path" if tracer is PATH_TRACER else "shared"
                    write_exposed(options.pictures / f"{lit.name}-{spp}-{way}.png", made.denoised * lit.exposure)
        for curve, found in zip(curves, figures, strict=True):
            curve.append(Point(spp, *map(float, np.mean(found, axis=0))))
    return curves


def _whole_scene(lit: _Lit, curve: list[Point], views: int, error: float, peer_seconds: float, peer: str) -> Row:
    """Compare the time of a scene's stereo pictures from stored light, storing it included, with a peer's."""
    seconds, measured = time_to(curve, error)
    shared, other = 2 * views * seconds + lit.seconds, 2 * views * peer_seconds
    return Row(
        f"{lit.name}: {views} stereo views, to the error of {peer}, relMSE {error:.4g}",
        shared,
        "s",
        peer=other,
        ratio=other / shared,
        note="" if measured else "beyond measured samples: drawn on",
    )


def _against_cycles(lit: _Lit, curve: list[Point], options: Options) -> Row:
    scene, python = lit.ours.kernel.description, cycles_python(options.cycles_python)
    with peer_of(python, scene, PeerOptions(), plain=False) as peer:
        path = options.cache / f"cycles-{peer.version.split()[0]}-{digest(scene)}.npz"
        one_pass = lambda seed: peer.render(PASS_SPP, seed, clean=False).noisy * lit.exposure  # noqa: E731
        kept = reference(path, options.reference_spp, one_pass)
        peer.render(1, 0)  # loads
        made = [peer.render(options.level, repeat + 1) for repeat in range(options.repeats)]
    error = float(np.mean([relmse(picture.denoised * lit.exposure, kept) for picture in made]))
    seconds = float(np.mean([picture.render_seconds for picture in made]))
    return _whole_scene(lit, curve, max(options.views), error, seconds, "Cycles")


def _stage_rows(lit: _Lit, curve: list[Point]) -> list[Row]:
    """Tell where the time of one more picture goes, at the middle number of samples."""
    spp = curve[len(curve) // 2].spp
    start = perf_counter()
    trace_guides(lit.ours.kernel, lit.ours.kernel.description.cameras[0])
    guides = perf_counter() - start
    made = render(lit.ours, spp, 9, tracer=lit.tracer)
    parts = {"guides": guides, "samples": made.trace_seconds - guides, "fireflies and denoiser": made.denoise_seconds}
    at = f"{lit.name}, {spp} spp: one more picture,"
    return [Row(f"{at} {part}", seconds, "s") for part, seconds in parts.items()]


def _bias_rows(lit: _Lit, options: Options) -> list[Row]:
    """Compare means by region; the error counts the noise of the reference, not that of the stored light."""
    spp = max(_BIAS_SPP, options.level)
    picture = render(lit.ours, spp, 7, clean=False, tracer=lit.tracer).noisy * lit.exposure
    rows = []
    for region, inside in regions(lit.ours.kernel, lit.stored).items():
        kept, variance = lit.kept.picture[inside], lit.kept.variance[inside]
        mean, error = kept.mean(), np.sqrt(variance.sum()) / variance.size
        off = (picture[inside].mean() - mean) / mean
        note = f"{inside.sum()} pixels, standard error of the reference {100 * error / mean:.2g} %"
        title = f"{lit.name}: mean of {region} against paths"
        rows.append(
            Row(title, 100 * off, "%", bound=100 * BIAS, ok=bool(abs(off) <= BIAS + 3 * error / mean), note=note)
        )
    if options.pictures is not None:
        write_exposed(options.pictures / f"{lit.name}-reference.png", lit.kept.picture)
        write_exposed(options.pictures / f"{lit.name}-difference.png", np.abs(picture - lit.kept.picture) * 4.0)
    return rows


if __name__ == "__main__":
    sys.exit(main())
