"""Light stored once per scene against light traced anew for every picture: time to equal error, and what it changes.

    python bench/shared_light.py --scenes filled clutter

One view of a scene is rendered both ways, in turn, at several numbers of samples, and compared with a path-traced
reference: relMSE after the denoiser, less what the reference's own noise adds. A whole scene is so many stereo views:
the time of a picture that often, and once the time to store the light (as many paths as the `syn-todd` preset takes).
Then the mean of a picture from stored light is compared with the reference's, for the table, the props and glass apart.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated

import numpy as np
import tyro
from each_scene import report_scenes
from ours import Ours, loaded, our_reference, render
from pngs import write_exposed
from references import Reference, relmse
from scenes import NAMES, bench_scene
from speed import Point, time_to
from table import Row

from glassware.procedural.description import TABLE_ID
from glassware.render.light.gather import gather_light
from glassware.render.light.nodes import place_nodes
from glassware.render.light.stored import opaque_light
from glassware.render.pictures.guides import trace_guides
from glassware.render.pictures.integrator import OpaqueLight

#: Least times that a whole scene of the most views must be faster, and the most that a region's mean may be off.
LEAST, BIAS = 3.0, 0.01


@dataclass(frozen=True)
class Options:
    """What to measure."""

    scenes: tuple[str, ...] = NAMES
    """Which of the five scenes."""
    spp: tuple[int, ...] = (4, 16, 64)
    """Samples per pixel, each measured both ways."""
    level: int = 64
    """Samples of the path-traced picture whose error both have to reach."""
    views: tuple[int, ...] = (57, 5)
    """Stereo views of a scene, each judged."""
    paths: int = 128
    """Paths that find the light of a node, on the average."""
    width: int = 640
    """Width of the picture [px]."""
    height: int = 480
    """Height of the picture [px]."""
    reference_spp: int = 1024
    """Samples per pixel of the references."""
    cache: Path = Path(".scratch/references")
    """Folder of the references."""
    pictures: Path | None = None
    """Folder for PNG files: reference, both ways, and their difference from the reference."""
    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


def main() -> int:
    """Measure and print."""
    options = tyro.cli(Options, description=__doc__)
    return report_scenes("Stored light", options, lambda name: _scene_rows(name, options))


def _scene_rows(name: str, options: Options) -> list[Row]:
    ours = loaded(bench_scene(name, options.width, options.height), cut=True)
    kept = our_reference(ours, options.cache, options.reference_spp, plain=False)
    start = perf_counter()
    nodes = place_nodes(ours.kernel)
    stored = gather_light(ours.kernel, nodes, options.paths, seed=1)
    seconds = perf_counter() - start
    event = opaque_light(ours.kernel, stored)
    rows = [
        Row(f"{name}: storing the light", seconds, "s", note=f"{nodes.count} nodes, {stored.samples.sum()} paths"),
        Row(f"{name}: memory of the stored light", stored.moments.nbytes / 1e6, "MB"),
    ]
    curves = _curves(name, ours, event, kept, options)
    for path, shared in zip(*curves, strict=True):
        at = f"{name}, {path.spp} spp:"
        rows += [
            Row(f"{at} a picture", shared.seconds, "s", peer=path.seconds, ratio=path.seconds / shared.seconds),
            Row(f"{at} relMSE before denoising", shared.noisy, peer=path.noisy, ratio=path.noisy / shared.noisy),
            Row(f"{at} relMSE after denoising", shared.clean, peer=path.clean, ratio=path.clean / shared.clean),
        ]
    rows += [_scene_row(name, curves, seconds, views, options) for views in options.views]
    return rows + _bias_rows(name, ours, event, kept, options)


def _curves(
    name: str, ours: Ours, event: OpaqueLight, kept: Reference, options: Options
) -> tuple[list[Point], list[Point]]:
    exposure = ours.kernel.description.cameras[0].exposure
    render(ours, 1, 0, opaque_light=event)  # compiles
    curves: tuple[list[Point], list[Point]] = ([], [])
    for spp in sorted({*options.spp, options.level}):
        for curve, light in zip(curves, (None, event), strict=True):
            made = render(ours, spp, 1, opaque_light=light)
            errors = [relmse(picture * exposure, kept) for picture in (made.noisy, made.clean)]
            curve.append(Point(spp, made.trace_seconds + made.denoise_seconds, *errors))
            if options.pictures is not None:
                way = "path" if light is None else "shared"
                write_exposed(options.pictures / f"{name}-{spp}-{way}.png", made.clean * exposure)
    return curves


def _scene_row(name: str, curves: tuple[list[Point], list[Point]], stored: float, views: int, options: Options) -> Row:
    error = next(point for point in curves[0] if point.spp == options.level).clean
    (path, _), (shared, measured) = (time_to(curve, error) for curve in curves)
    path, shared = 2 * views * path, 2 * views * shared + stored
    least = LEAST if views == max(options.views) else 1.0
    return Row(
        f"{name}: {views} stereo views, to relMSE {error:.4g}",
        shared,
        "s",
        peer=path,
        ratio=path / shared,
        bound=path / least,
        ok=path / shared >= least,
        note="" if measured else "beyond measured samples: drawn on",
    )


def _bias_rows(name: str, ours: Ours, event: OpaqueLight, kept: Reference, options: Options) -> list[Row]:
    """Compare means by region; the error counts the noise of both pictures, not that of the stored light."""
    from glassware.render.labels.geometry import trace_straight

    scene = ours.kernel.description
    camera, spp = scene.cameras[0], max(256, options.level)
    picture = render(ours, spp, 7, clean=False, opaque_light=event).noisy * camera.exposure
    first = trace_straight(ours.kernel, camera, 0)[0].id
    *_, glass = trace_guides(ours.kernel, camera)
    opaque = np.isin(first, [prop.id for prop in scene.props])
    regions = {"table": (first == TABLE_ID) & ~glass, "props": opaque & ~glass, "glass": glass}
    rows = []
    for region, inside in regions.items():
        if inside.sum() < 100:
            continue
        mean, error = kept.picture[inside].mean(), np.sqrt(kept.variance[inside].sum()) / kept.variance[inside].size
        off = (picture[inside].mean() - mean) / mean
        ok = bool(abs(off) <= BIAS)
        rows.append(
            Row(
                f"{name}: mean of {region} against paths",
                100 * off,
                "%",
                bound=100 * BIAS,
                ok=ok,
                note=f"standard error of the reference {100 * error / mean:.2g} %",
            )
        )
    if options.pictures is not None:
        write_exposed(options.pictures / f"{name}-reference.png", kept.picture)
        write_exposed(options.pictures / f"{name}-difference.png", np.abs(picture - kept.picture) * 4.0)
    return rows


if __name__ == "__main__":
    sys.exit(main())
