"""Our renderer against Blender's Cycles on the same five scenes: agreement, and time to equal error.

    python bench/render_vs_cycles.py --cycles-python ~/bpy/bin/python
    python bench/render_vs_cycles.py --cycles-python ~/bpy/bin/python --speed

Cycles comes as the package `bpy` 4.5 (LTS) for Python 3.11, in an environment of its own:

    python3.11 -m venv ~/bpy && ~/bpy/bin/pip install "bpy==4.5.*" "numpy<2"

Both draw the same triangles, normals, textures, environment and camera, with the description's longest path, a box
filter one pixel wide and no clamping. Media are clear, because Cycles' glass does not absorb.

Agreement: opaque surfaces are ideal diffusers, because the two principled models differ. Means of independent passes
are compared in blocks against the noise of both. Blocks that show rough glass do not decide: the two models of light
between the facets of a rough surface differ (Cycles scales its single-scattering lobe, ours is a walk).

Speed: opaque surfaces are what each renderer has for our materials, and each is measured against its own converged
reference, in exposed linear units, by the mean of (I - R)^2 / (R^2 + 0.01) less what the reference's own noise adds to
it. The targets are the errors that Cycles has after its denoiser at the two numbers of samples in `--levels`. Time is
tracing and denoising; loading, the tree of triangles and compilation are told apart. Both render in turn on the same
cores.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from agreement import Agreement, block_means, compared
from cycles.peer import Cycles, cycles_python
from ours import Ours, loaded, our_reference, render
from pngs import write_exposed, write_signed
from references import PASS_SPP, Reference, reference, relmse
from rich.console import Console
from scenes import NAMES, bench_scene, digest
from speed import Point, rate, time_to
from table import Row, cores, report

from glassware.procedural.description import Scene, Vessel
from glassware.procedural.errors import InputError
from glassware.render.geometry import trace_geometry

#: How many times faster than Cycles our renderer must be at equal error (median over the scenes).
LEAST_RATIO = 4.0


@dataclass(frozen=True)
class Options:
    """What to compare."""

    cycles_python: Path | None = None
    """Python that has bpy 4.5; the environment variable GLASSWARE_CYCLES_PYTHON by default."""
    speed: bool = False
    """Measure time to equal error instead of agreement."""
    scenes: tuple[str, ...] = NAMES
    """Which of the five scenes."""
    width: int = 320
    """Width of the picture [px]."""
    height: int = 180
    """Height of the picture [px]."""
    threads: int = cores()
    """Threads of Cycles; ours uses all cores that the process may."""
    passes: int = 16
    """Agreement: independent passes of each renderer."""
    pass_spp: int = 64
    """Agreement: samples of each pass."""
    block: int = 20
    """Agreement: side of the blocks [px]."""
    spp: tuple[int, ...] = (4, 16, 64, 256)
    """Speed: samples measured of each renderer."""
    levels: tuple[int, ...] = (16, 64)
    """Speed: the errors to reach are those that Cycles has after its denoiser at these samples."""
    repeats: int = 2
    """Speed: pictures that each figure is the mean of."""
    reference_spp: int = 4096
    """Speed: samples of each renderer's reference."""
    cache: Path = Path(".scratch/references")
    """Speed: folder of the references."""
    pictures: Path | None = None
    """Folder for pictures of both renderers, ours above."""
    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


def main() -> int:
    """Compare and print."""
    options = tyro.cli(Options, description=__doc__)
    try:
        python = cycles_python(options.cycles_python)
        rows, version = _speed(python, options) if options.speed else _agreement(python, options)
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    facts = {"picture": f"{options.width}x{options.height}", "cycles": version, "threads": options.threads}
    if options.speed:
        return report("Time to equal error", rows, options.json_file, reference_spp=options.reference_spp, **facts)
    facts["samples"] = f"{options.passes} passes of {options.pass_spp}"
    return report("Agreement with Cycles", rows, options.json_file, block=options.block, **facts)


@contextmanager
def _peer(python: Path, scene: Scene, options: Options, plain: bool) -> Iterator[Cycles]:
    with (
        tempfile.TemporaryDirectory() as folder,
        Cycles(python, scene, Path(folder), options.threads, plain) as peer,
    ):
        yield peer


# ---- Agreement ----


def _agreement(python: Path, options: Options) -> tuple[list[Row], str]:
    rows, version = [], ""
    for name in options.scenes:
        scene = bench_scene(name, options.width, options.height)
        ours = loaded(scene, plain=True)
        with _peer(python, scene, options, plain=True) as peer:
            version = peer.version
            rows += _agreement_rows(name, ours, peer, options)
    return rows, version


def _agreement_rows(name: str, ours: Ours, peer: Cycles, options: Options) -> list[Row]:
    exposure = ours.kernel.description.cameras[0].exposure
    blocks: tuple[list, list] = ([], [])
    means = np.zeros((2, options.height, options.width, 3))
    for number in range(options.passes):
        _say(f"{name}: pass {number + 1} of {options.passes}")
        pair = [
            one.noisy * exposure
            for one in (
                render(ours, options.pass_spp, number + 1, clean=False),
                peer.render(options.pass_spp, number + 1, clean=False),
            )
        ]
        for k, picture in enumerate(pair):
            blocks[k].append(block_means(picture, options.block))
            means[k] += picture / options.passes
    found = compared(*blocks, options.block)
    if options.pictures is not None:
        write_exposed(options.pictures / f"{name}.png", *means)
        z = found.z[np.arange(len(found.z))[:, None], np.arange(found.z.shape[1]), np.abs(found.z).argmax(-1)]
        write_signed(options.pictures / f"{name}-z.png", np.kron(z, np.ones((options.block,) * 2)), 6.0)
    return _verdict(name, ours, found)


def _verdict(name: str, ours: Ours, found: Agreement) -> list[Row]:
    rough = _shows_rough_glass(ours, found)
    different = found.different & ~rough
    # Where rough glass is not looked at, or nothing differs, this is the most suspicious of what decides.
    excess = np.where(rough[..., None], 0.0, np.abs(found.z) / found.limit)
    worst = np.unravel_index(excess.argmax(), excess.shape)
    rows = [
        Row(
            f"{name}: blocks that differ",
            float(different.sum()),
            f"of {(~rough).sum()}",
            ok=not different.any(),
            note=_where(ours, found, worst) if different.any() else "",
        ),
        Row(f"{name}: largest |z| of a block", float(np.abs(found.z[worst])), bound=float(found.limit[worst])),
        Row(f"{name}: rms of z", float(np.sqrt((found.z[~rough] ** 2).mean()))),
        Row(f"{name}: mean light, ours less Cycles'", 100.0 * float(found.ours.mean() / found.peer.mean() - 1.0), "%"),
        Row(f"{name}: median |difference| of blocks", 100.0 * float(np.median(np.abs(found.relative))), "%"),
    ]
    if rough.any():
        mean = 100.0 * float((found.ours[rough].sum() / found.peer[rough].sum()) - 1.0)
        note = "Cycles spreads what facets send at each other like the rest; ours follows it"
        rows.append(Row(f"{name}: light of the {rough.sum()} blocks with rough glass", mean, "%", note=note))
    return rows


def _shows_rough_glass(ours: Ours, found: Agreement) -> np.ndarray:
    """Return which blocks show a rough vessel anywhere, (rows, columns) bool."""
    scene = ours.kernel.description
    crossed = trace_geometry(ours.kernel, scene.cameras[0]).crossed
    rough = [isinstance(item, Vessel) and item.roughness > 0.0 for item in scene.objects]
    seen = crossed[rough].any(axis=0)
    return block_means(np.repeat(seen[..., None], 3, axis=-1), found.block)[..., 0] > 0.0


def _where(ours: Ours, found: Agreement, index: tuple) -> str:
    """Say what is seen in the block that differs most, and by how much it differs."""
    scene = ours.kernel.description
    row, column, channel = (int(i) for i in index)
    ids = trace_geometry(ours.kernel, scene.cameras[0]).id
    seen = ids[row * found.block : (row + 1) * found.block, column * found.block : (column + 1) * found.block]
    names = {0: "environment", 1: "table", **{item.id: item.name for item in scene.objects}}
    what = ", ".join(names[int(i)] for i in np.unique(seen))
    share = 100.0 * found.relative[row, column, channel]
    return f"worst at ({column * found.block}, {row * found.block}) px: {share:+.2f} % on {what}"


# ---- Speed ----


def _speed(python: Path, options: Options) -> tuple[list[Row], str]:
    rows, version = [], ""
    ratios: dict[int, list[float]] = {level: [] for level in options.levels}
    for name in options.scenes:
        scene = bench_scene(name, options.width, options.height)
        ours = loaded(scene)
        with _peer(python, scene, options, plain=False) as peer:
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
        rows += _curve_rows(name, curves, options)
        for level in options.levels:
            row = _level_row(name, curves, level)
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
            _say(f"{name}: {spp} samples, picture {repeat + 1} of {options.repeats}")
            mine, theirs = render(ours, spp, repeat + 1), peer.render(spp, repeat + 1)
            seconds = (mine.trace_seconds + mine.denoise_seconds, theirs.render_seconds)
            for k, picture in enumerate((mine, theirs)):
                errors = [relmse(p * exposure, kept[k]) for p in (picture.noisy, picture.clean)]
                figures[k].append((seconds[k], *errors))
        for k in range(2):
            curves[k].append(Point(spp, *map(float, np.mean(figures[k], axis=0))))
        if options.pictures is not None:
            write_exposed(options.pictures / f"{name}-{spp}.png", mine.clean * exposure, theirs.clean * exposure)
    return curves


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


def _say(text: str) -> None:
    Console(stderr=True).print(text, highlight=False)


if __name__ == "__main__":
    sys.exit(main())
