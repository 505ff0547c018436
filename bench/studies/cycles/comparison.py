"""What is compared with Cycles, and the worker that renders for it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from command import PictureOptions
from references import PASS_SPP, Reference, reference
from rich.console import Console
from scenes import digest
from table import cores

from glassware.procedural.description.scene import Scene

from .peer import Cycles


@dataclass(frozen=True, kw_only=True)
class Options(PictureOptions):
    """What to compare."""

    cycles_python: Path | None = None
    """Python that has bpy 4.5; the environment variable GLASSWARE_CYCLES_PYTHON by default."""
    speed: bool = False
    """Measure time to equal error instead of agreement."""
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
    thresholds: tuple[float, ...] = (0.1,)
    """Speed: thresholds of Cycles' adaptive sampling, each measured as well."""


@contextmanager
def peer_of(python: Path, scene: Scene, threads: int, lambertian: bool = False) -> Iterator[Cycles]:
    """Hold a Cycles worker with the scene, opaque surfaces as ideal diffusers where `lambertian`."""
    with tempfile.TemporaryDirectory() as folder, Cycles(python, scene, Path(folder), threads, lambertian) as peer:
        yield peer


def peer_reference(peer: Cycles, folder: Path, spp: int) -> Reference:
    """Return Cycles' converged picture; passes that the folder holds are not rendered again."""
    exposure = peer.scene.cameras[0].exposure
    path = folder / f"cycles-{peer.version.split()[0]}-{digest(peer.scene)}.npz"
    return reference(path, spp, lambda seed: peer.render(PASS_SPP, seed, denoise=False).noisy * exposure)


def progress(text: str) -> None:
    """Print what was measured."""
    Console(stderr=True).print(text, highlight=False)
