"""Whether the two renderers agree: differences of block means against the noise of both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from agreement import Agreement, block_means, compared
from ours import Ours, prepare, render
from picture import write_exposed, write_signed
from scenes import bench_scene
from table import Row

from glassware.procedural.description.scene import Vessel
from glassware.render.labels.geometry import trace_geometry

from .comparison import Options, peer_of, progress
from .peer import Cycles


def agreement_rows(python: Path, options: Options) -> tuple[list[Row], str]:
    """Return the rows of every scene, and Cycles' version."""
    rows, version = [], ""
    for name in options.scenes:
        scene = bench_scene(name, options.width, options.height)
        ours = prepare(scene, lambertian=True)
        with peer_of(python, scene, options.threads, lambertian=True) as peer:
            version = peer.version
            rows += _agreement_rows(name, ours, peer, options)
    return rows, version


def _agreement_rows(name: str, ours: Ours, peer: Cycles, options: Options) -> list[Row]:
    blocks: tuple[list, list] = ([], [])
    means = np.zeros((2, options.height, options.width, 3))
    for number in range(options.passes):
        progress(f"{name}: pass {number + 1} of {options.passes}")
        pair = [
            one.noisy * ours.exposure
            for one in (
                render(ours, options.pass_spp, number + 1, denoise=False),
                peer.render(options.pass_spp, number + 1, denoise=False),
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
    # The block without rough glass whose difference is largest for its limit.
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
    scene = ours.loaded.description
    crossed = trace_geometry(ours.loaded, scene.cameras[0]).crossed
    rough = [isinstance(item, Vessel) and item.roughness > 0.0 for item in scene.objects]
    seen = crossed[rough].any(axis=0)
    return block_means(np.repeat(np.asarray(seen)[..., None], 3, axis=-1), found.block)[..., 0] > 0.0


def _where(ours: Ours, found: Agreement, index: tuple) -> str:
    """Return what the most different block shows, and its difference."""
    scene = ours.loaded.description
    row, column, channel = (int(i) for i in index)
    ids = trace_geometry(ours.loaded, scene.cameras[0]).id
    seen = ids[row * found.block : (row + 1) * found.block, column * found.block : (column + 1) * found.block]
    names = {0: "environment", 1: "table", **{item.id: item.name for item in scene.objects}}
    what = ", ".join(names[int(i)] for i in np.unique(seen))
    percent = 100.0 * found.relative[row, column, channel]
    return f"worst at ({column * found.block}, {row * found.block}) px: {percent:+.2f} % on {what}"
