"""The irradiance cache against path tracing and against Cycles: time to equal error of a scene, and bias by region.

A study: it backs the section "Light once per scene" of docs/performance.md, last run 2026-11-26. It is not maintained
beyond importing.

    python bench/studies/shared_light.py --scenes filled clutter
    python bench/studies/shared_light.py --scenes filled clutter --cycles-python ~/bpy/bin/python

One view of a scene is rendered both ways, alternating, at several numbers of samples, and compared with a path-traced
reference: relMSE after the denoiser, less what the reference's own noise adds. The time of a whole scene is that of one
picture times the number of pictures, and once the time to fill the cache. The mean of a picture from the cache is
compared with the reference's by region.

With a Python that has Blender's package (`render_vs_cycles.py` says how to install it), Cycles renders the same view at
`--level` samples; the cache then has to reach the error that Cycles has after its denoiser, against its own reference.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))
from command import PictureOptions, run
from cycles.comparison import peer_of, peer_reference
from cycles.peer import cycles_python
from equal_error import Point, Way, curve_rows, measure, time_to
from ours import Ours, our_reference, prepare, render
from picture import Picture, write_exposed
from references import Reference
from scenes import ALL_NAMES, NAMES, bench_scene
from table import Row, cores, report

from glassware.annotate.projection import transformed, unproject
from glassware.procedural.description.scene import TABLE_ID
from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.irradiance_cache import IrradianceCache
from glassware.render.cache.trace_cached import cached_tracer
from glassware.render.labels.geometry import trace_straight
from glassware.render.pictures.guides import trace_guides
from glassware.render.pictures.picture import Tracer

#: How many times faster than path tracing and than Cycles a scene of the most views must be, median over the scenes;
#: and the maximum relative error of a region's mean.
MIN_RATIO, MIN_RATIO_TO_CYCLES, MAX_BIAS = 3.0, 6.0, 0.01
#: A point of the table is in a caustic above, and in a deep shadow below, this multiple of the table's median
#: irradiance [1].
CAUSTIC, SHADOW = 1.4, 0.5
#: Regions of fewer pixels are too noisy.
MIN_PIXELS = 100
#: Samples of the picture whose regions are compared.
_BIAS_SPP = 256


@dataclass(frozen=True, kw_only=True)
class Options(PictureOptions):
    """What to measure."""

    scenes: tuple[str, ...] = ALL_NAMES
    """Names of the scenes."""
    width: int = 640
    """Width of the picture [px]."""
    height: int = 480
    """Height of the picture [px]."""
    reference_spp: int = 1024
    """Samples per pixel of the references."""
    spp: tuple[int, ...] = (8, 16, 32, 64)
    """Samples per pixel, each measured both ways."""
    level: int = 64
    """Samples of the path-traced picture, and of Cycles', whose error is to be reached."""
    views: tuple[int, ...] = (57, 5)
    """Stereo views of a scene, each compared."""
    paths: int = 40
    """Mean number of paths of a cache point."""
    cycles_python: Path | None = None
    """Python that has bpy 4.5; without it Cycles is left out."""


@dataclass(frozen=True, eq=False)
class _Cached:
    """A scene with its irradiance cache."""

    name: str
    ours: Ours
    cache: IrradianceCache
    tracer: Tracer
    seconds: float  #: to fill the cache
    kept: Reference


@dataclass(frozen=True)
class _Ratios:
    """How many times faster each scene is."""

    paths: list[float] = field(default_factory=list)
    cycles: list[float] = field(default_factory=list)


def main(options: Options) -> int:
    """Measure and print."""
    ratios = _Ratios()
    rows = [row for name in options.scenes for row in _scene_rows(name, options, ratios)]
    for values, bound, peer in (
        (ratios.paths, MIN_RATIO, "path tracing"),
        (ratios.cycles, MIN_RATIO_TO_CYCLES, "Cycles"),
    ):
        if values:
            middle, note = float(np.median(values)), " ".join(f"{x:.2f}" for x in values)
            title = f"median of {len(values)} scenes: times faster than {peer}"
            rows.append(Row(title, middle, bound=bound, ok=middle >= bound, note=note))
    size = f"{options.width}x{options.height}"
    return report(f"Irradiance cache, {size}", rows, options.json_file, reference_spp=options.reference_spp)


def _scene_rows(name: str, options: Options, ratios: _Ratios) -> list[Row]:
    scene = _cached(name, options)
    rows = [
        Row(f"{name}: filling the cache", scene.seconds, "s", note=f"{scene.cache.samples.sum()} paths"),
        Row(f"{name}: memory of the cache", scene.cache.moments.nbytes / 1e6, "MB"),
    ]
    paths, cached = _curves(scene, options)
    rows += curve_rows(name, cached, paths)
    error = next(point for point in paths if point.spp == options.level).clean
    for views in options.views:
        row = _whole_scene(scene, cached, views, error, time_to(paths, error)[0], "path tracing")
        if views == max(options.views):
            ratios.paths.append(row.ratio or 0.0)
        rows.append(row)
    if options.cycles_python is not None and name in NAMES:
        rows.append(_against_cycles(scene, cached, options))
        ratios.cycles.append(rows[-1].ratio or 0.0)
    return [*rows, *_stage_rows(scene, cached), *_bias_rows(scene, options)]


def _cached(name: str, options: Options) -> _Cached:
    ours = prepare(bench_scene(name, options.width, options.height), for_cache=True)
    kept = our_reference(ours, options.cache, options.reference_spp)
    start = perf_counter()
    cache = fill_cache(ours.loaded, cache_points_of(ours.loaded), options.paths, seed=1)
    tracer = cached_tracer(ours.loaded, cache)
    return _Cached(name, ours, cache, tracer, perf_counter() - start, kept)


def _curves(scene: _Cached, options: Options) -> list[list[Point]]:
    """Return the curves of path tracing and of the cache."""

    def show(spp: int, pictures: list[Picture]) -> None:
        if options.pictures is not None:
            for way, picture in zip(("path", "shared"), pictures, strict=True):
                file = options.pictures / f"{scene.name}-{spp}-{way}.png"
                write_exposed(file, picture.denoised * scene.ours.exposure)

    ways = (
        Way(lambda spp, seed: render(scene.ours, spp, seed), scene.kept),
        Way(lambda spp, seed: render(scene.ours, spp, seed, tracer=scene.tracer), scene.kept),
    )
    for way in ways:
        way.render(min(options.spp), 0)  # compiles, the kernels of adaptive sampling as well
    return measure(ways, (*options.spp, options.level), options.repeats, scene.ours.exposure, show)


def _whole_scene(scene: _Cached, curve: list[Point], views: int, error: float, peer_seconds: float, peer: str) -> Row:
    """Compare the time of all stereo pictures of a scene, the filling of the cache included, with a peer's."""
    seconds, measured = time_to(curve, error)
    total, other = 2 * views * seconds + scene.seconds, 2 * views * peer_seconds
    title = f"{scene.name}: {views} stereo views, to the error of {peer}, relMSE {error:.4g}"
    return Row(title, total, "s", peer=other, ratio=other / total, note="" if measured else "extrapolated")


def _against_cycles(scene: _Cached, curve: list[Point], options: Options) -> Row:
    python = cycles_python(options.cycles_python)
    with peer_of(python, scene.ours.loaded.description, cores()) as peer:
        kept = peer_reference(peer, options.cache, options.reference_spp)
        peer.render(1, 0)  # loads
        made = [peer.render(options.level, repeat + 1) for repeat in range(options.repeats)]
    error = float(np.mean([picture.errors(scene.ours.exposure, kept)[1] for picture in made]))
    seconds = float(np.mean([picture.seconds for picture in made]))
    return _whole_scene(scene, curve, max(options.views), error, seconds, "Cycles")


def _stage_rows(scene: _Cached, curve: list[Point]) -> list[Row]:
    """Return the stages of one more picture, at the middle number of samples."""
    spp = curve[len(curve) // 2].spp
    start = perf_counter()
    trace_guides(scene.ours.loaded, scene.ours.loaded.description.cameras[0])
    guides = perf_counter() - start
    made = render(scene.ours, spp, 9, tracer=scene.tracer)
    tracing = made.seconds - made.denoise_seconds - guides
    parts = {"guides": guides, "samples": tracing, "fireflies and denoiser": made.denoise_seconds}
    return [Row(f"{scene.name}, {spp} spp: one more picture, {part}", value, "s") for part, value in parts.items()]


def _bias_rows(scene: _Cached, options: Options) -> list[Row]:
    """Compare means by region; the error counts the noise of the reference, not that of the cache."""
    ours = scene.ours
    spp = max(_BIAS_SPP, options.level)
    picture = render(ours, spp, 7, denoise=False, tracer=scene.tracer).noisy * ours.exposure
    rows = []
    for region, inside in _regions(scene).items():
        kept, variance = scene.kept.picture[inside], scene.kept.variance[inside]
        mean, error = kept.mean(), np.sqrt(variance.sum()) / variance.size
        off = (picture[inside].mean() - mean) / mean
        note = f"{inside.sum()} pixels, standard error of the reference {100 * error / mean:.2g} %"
        title, ok = f"{scene.name}: mean of {region} against paths", bool(abs(off) <= MAX_BIAS + 3 * error / mean)
        rows.append(Row(title, 100 * off, "%", bound=100 * MAX_BIAS, ok=ok, note=note))
    if options.pictures is not None:
        write_exposed(options.pictures / f"{scene.name}-reference.png", scene.kept.picture)
        write_exposed(options.pictures / f"{scene.name}-difference.png", np.abs(picture - scene.kept.picture) * 4.0)
    return rows


def _regions(scene: _Cached) -> dict[str, np.ndarray]:
    """Return the pixels of each region where the cache could be wrong, (H, W) bool."""
    loaded = scene.ours.loaded
    camera = loaded.description.cameras[0]
    geometry = trace_straight(loaded, camera, 0)[0]
    glass = trace_guides(loaded, camera).glass
    table = (geometry.id == TABLE_ID) & ~glass
    local = unproject(geometry.Z, camera.K)[table]
    irradiance = np.zeros(table.shape)
    irradiance[table] = _nearest_irradiance(scene.cache, transformed(camera.world_T_camera, local))
    median = np.median(irradiance[table])
    found = {
        "open table": table & (irradiance < CAUSTIC * median) & (irradiance > SHADOW * median),
        "caustics": table & (irradiance >= CAUSTIC * median),
        "deep shadows": table & (irradiance <= SHADOW * median),
        "props": np.isin(geometry.id, [prop.id for prop in loaded.description.props]) & ~glass,
        "glass": glass,
    }
    return {name: inside for name, inside in found.items() if inside.sum() >= MIN_PIXELS}


def _nearest_irradiance(cache: IrradianceCache, points: np.ndarray) -> np.ndarray:
    """Return the irradiance of the nearest cache point of the table's grid, mean of the channels, (n,)."""
    x, y = cache.points.axes
    column = np.clip(np.rint(x.cell_position(points[:, 0])), 0, x.lines - 1).astype(int)
    row = np.clip(np.rint(y.cell_position(points[:, 1])), 0, y.lines - 1).astype(int)
    return cache.moments[row * x.lines + column, :3].mean(1)


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
