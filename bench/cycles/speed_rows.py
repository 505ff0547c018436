"""Error against time for both renderers, and how long each takes to the same error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from ours import Ours, loaded, our_reference, render
from pngs import write_exposed
from references import PASS_SPP, Reference, reference, relmse
from scenes import bench_scene, digest
from speed import Point, rate, time_to
from table import Row

from glassware.procedural.description.scene import Scene

from .comparison import Options, peer_of, say
from .peer import Cycles

#: How many times faster than Cycles our renderer must be at equal error (median over the scenes).
LEAST_RATIO = 4.0
#: Most samples of a pixel that Cycles' adaptive sampling may take.
MOST_ADAPTIVE = 512


def speed_rows(python: Path, options: Options) -> tuple[list[Row], str]:
    """Return the rows of every scene, and Cycles' version."""
    rows, version = [], ""
    ratios: dict[int, list[float]] = {level: [] for level in options.levels}
    for name in options.scenes:
        scene = bench_scene(name, options.width, options.height)
        ours = loaded(scene)
        with peer_of(python, scene, options, plain=False) as peer:
            version = peer.version
            kept = (
                our_reference(ours, options.cache, options.reference_spp, plain=False),
                _peer_reference(peer, scene, options),
            )
            first = peer.render(1, 0)
            rows += [
                Row(
                    f"{name}: loading and compiling",
                    ours.load_seconds + ours.compile_seconds,
                    "s",
                    peer=peer.build_seconds + first.setup_seconds,
                ),
                Row(f"{name}: relMSE of the reference itself", kept[0].floor, peer=kept[1].floor),
            ]
            curves = _curves(name, ours, peer, kept, options)
            adaptive = [
                _adaptive_row(name, peer, kept[1], curves, scene.cameras[0].exposure, t, options)
                for t in options.thresholds
            ]
        rows += [*_curve_rows(name, curves, options), *adaptive]
        for level in options.levels:
            row = _level_row(name, curves, level)
            assert row.ratio is not None
            ratios[level].append(row.ratio)
            rows.append(row)
    for level, values in ratios.items():
        middle = float(np.median(values))
        rows.append(
            Row(
                f"median over scenes, Cycles' error at {level} spp: times faster",
                middle,
                bound=LEAST_RATIO,
                ok=middle >= LEAST_RATIO,
            )
        )
    return rows, version


def _peer_reference(peer: Cycles, scene: Scene, options: Options) -> Reference:
    exposure = scene.cameras[0].exposure
    path = options.cache / f"cycles-{peer.version.split()[0]}-{digest(scene)}.npz"
    return reference(
        path, options.reference_spp, lambda seed: peer.render(PASS_SPP, seed, clean=False).noisy * exposure
    )


def _curves(
    name: str, ours: Ours, peer: Cycles, kept: tuple[Reference, Reference], options: Options
) -> tuple[list[Point], list[Point]]:
    """Measure both in turn, so that whatever else the machine does meets both."""
    exposure = ours.kernel.description.cameras[0].exposure
    curves: tuple[list[Point], list[Point]] = ([], [])
    for spp in sorted(set(options.spp) | set(options.levels)):
        figures: tuple[list, list] = ([], [])
        for repeat in range(options.repeats):
            say(f"{name}: {spp} samples, picture {repeat + 1} of {options.repeats}")
            mine, theirs = render(ours, spp, repeat + 1), peer.render(spp, repeat + 1)
            seconds = (mine.trace_seconds + mine.denoise_seconds, theirs.render_seconds)
            for k, picture in enumerate((mine, theirs)):
                errors = [relmse(p * exposure, kept[k]) for p in (picture.noisy, picture.denoised)]
                figures[k].append((seconds[k], *errors))
            if options.pictures is not None:
                shown = mine.denoised * exposure, theirs.denoised * exposure
                write_exposed(options.pictures / f"{name}-{spp}.png", *shown)
        for k in range(2):
            curves[k].append(Point(spp, *map(float, np.mean(figures[k], axis=0))))
    return curves


def _adaptive_row(
    name: str,
    peer: Cycles,
    kept: Reference,
    curves: tuple[list[Point], list[Point]],
    exposure: float,
    threshold: float,
    options: Options,
) -> Row:
    """Compare with Cycles' adaptive sampling: our time to the error that it reaches."""
    say(f"{name}: adaptive sampling of Cycles, threshold {threshold:g}")
    made = [peer.render(MOST_ADAPTIVE, repeat + 1, threshold=threshold) for repeat in range(options.repeats)]
    error = float(np.mean([relmse(picture.clean * exposure, kept) for picture in made if picture.clean is not None]))
    seconds = float(np.mean([picture.render_seconds for picture in made]))
    (mine, measured), (plain, _) = (time_to(curve, error) for curve in curves)
    note = f"Cycles without it: {plain:.3g} s" + ("" if measured else "; beyond our measured samples: drawn on")
    title = f"{name}: time to the error of Cycles' adaptive sampling at {threshold:g}, relMSE {error:.4g}"
    return Row(title, mine, "s", peer=seconds, ratio=seconds / mine, note=note)


def _curve_rows(name: str, curves: tuple[list[Point], list[Point]], options: Options) -> list[Row]:
    pixels, rows = options.width * options.height, []
    for mine, theirs in zip(*curves, strict=True):
        at = f"{name}, {mine.spp} spp:"
        rows += [
            Row(
                f"{at} tracing and denoising",
                mine.seconds,
                "s",
                peer=theirs.seconds,
                ratio=theirs.seconds / mine.seconds,
            ),
            Row(f"{at} relMSE before denoising", mine.noisy, peer=theirs.noisy, ratio=theirs.noisy / mine.noisy),
            Row(f"{at} relMSE after denoising", mine.clean, peer=theirs.clean, ratio=theirs.clean / mine.clean),
        ]
    speeds = [rate(curve, pixels) / 1e6 for curve in curves]
    return [*rows, Row(f"{name}: samples", speeds[0], "M/s", peer=speeds[1], ratio=speeds[0] / speeds[1])]


def _level_row(name: str, curves: tuple[list[Point], list[Point]], level: int) -> Row:
    theirs = next(point for point in curves[1] if point.spp == level)
    mine, measured = time_to(curves[0], theirs.clean)
    note = "" if measured else "beyond our measured samples: drawn on"
    title = f"{name}: time to Cycles' error at {level} spp, relMSE {theirs.clean:.4g}"
    return Row(title, mine, "s", peer=theirs.seconds, ratio=theirs.seconds / mine, note=note)
