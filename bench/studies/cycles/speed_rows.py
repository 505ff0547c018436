"""Error against time for both renderers, and how long each takes to the same error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from equal_error import Point, Way, curve_rows, measure, rate, time_to
from ours import our_reference, prepare, render
from picture import Picture, write_exposed
from scenes import bench_scene
from table import Row

from .comparison import Options, peer_of, peer_reference, progress
from .peer import Cycles

#: How many times faster than Cycles our renderer must be at equal error (median over the scenes).
MIN_RATIO = 4.0
#: Maximum samples of a pixel in Cycles' adaptive sampling.
MAX_ADAPTIVE = 512


def speed_rows(python: Path, options: Options) -> tuple[list[Row], str]:
    """Return the rows of every scene, and Cycles' version."""
    rows, version = [], ""
    ratios: dict[int, list[float]] = {level: [] for level in options.levels}
    for name in options.scenes:
        scene = bench_scene(name, options.width, options.height)
        with peer_of(python, scene, options.threads) as peer:
            version = peer.version
            found, curves = _scene_rows(name, peer, options)
        rows += found
        for level in options.levels:
            row = _level_row(name, curves, level)
            ratios[level].append(row.ratio or 0.0)
            rows.append(row)
    for level, values in ratios.items():
        title, middle = f"median over scenes, Cycles' error at {level} spp: times faster", float(np.median(values))
        rows.append(Row(title, middle, bound=MIN_RATIO, ok=middle >= MIN_RATIO))
    return rows, version


def _scene_rows(name: str, peer: Cycles, options: Options) -> tuple[list[Row], list[list[Point]]]:
    ours = prepare(peer.scene)
    kept = our_reference(ours, options.cache, options.reference_spp)
    peer_kept = peer_reference(peer, options.cache, options.reference_spp)
    first = peer.render(1, 0)
    loading, peer_loading = ours.load_seconds + ours.compile_seconds, peer.build_seconds + first.setup_seconds

    def show(spp: int, pictures: list[Picture]) -> None:
        progress(f"{name}: {spp} samples")
        if options.pictures is not None:
            write_exposed(options.pictures / f"{name}-{spp}.png", *(x.denoised * ours.exposure for x in pictures))

    ways = Way(lambda spp, seed: render(ours, spp, seed), kept), Way(peer.render, peer_kept)
    curves = measure(ways, (*options.spp, *options.levels), options.repeats, ours.exposure, show)
    speeds = [rate(curve, options.width * options.height) / 1e6 for curve in curves]
    rows = [
        Row(f"{name}: loading and compiling", loading, "s", peer=peer_loading),
        Row(f"{name}: relMSE of the reference itself", kept.floor, peer=peer_kept.floor),
        *curve_rows(name, *curves),
        Row(f"{name}: samples", speeds[0], "M/s", peer=speeds[1], ratio=speeds[0] / speeds[1]),
    ]
    for threshold in options.thresholds:
        progress(f"{name}: adaptive sampling of Cycles, threshold {threshold:g}")
        made = [peer.render(MAX_ADAPTIVE, seed, threshold=threshold) for seed in range(1, options.repeats + 1)]
        error = float(np.mean([picture.errors(ours.exposure, peer_kept)[1] for picture in made]))
        seconds = float(np.mean([picture.seconds for picture in made]))
        rows.append(_adaptive_row(f"{name}: {threshold:g}", curves, error, seconds))
    return rows, curves


def _adaptive_row(at: str, curves: list[list[Point]], error: float, seconds: float) -> Row:
    """Compare with Cycles' adaptive sampling: our time to the error that it reaches."""
    (ours, measured), (uniform, _) = (time_to(curve, error) for curve in curves)
    note = f"Cycles without it: {uniform:.3g} s" + ("" if measured else "; extrapolated")
    title = f"{at}, time to the error of Cycles' adaptive sampling, relMSE {error:.4g}"
    return Row(title, ours, "s", peer=seconds, ratio=seconds / ours, note=note)


def _level_row(name: str, curves: list[list[Point]], level: int) -> Row:
    peer = next(point for point in curves[1] if point.spp == level)
    ours, measured = time_to(curves[0], peer.clean)
    title = f"{name}: time to Cycles' error at {level} spp, relMSE {peer.clean:.4g}"
    note = "" if measured else "extrapolated"
    return Row(title, ours, "s", peer=peer.seconds, ratio=peer.seconds / ours, note=note)
