"""What is compared with Cycles, and the worker that renders for it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.console import Console
from scenes import NAMES
from table import cores

from glassware.procedural.description.scene import Scene

from .peer import Cycles


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
    thresholds: tuple[float, ...] = (0.1,)
    """Speed: thresholds of Cycles' adaptive sampling, each measured as well."""
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


@contextmanager
def peer_of(python: Path, scene: Scene, options: Options, plain: bool) -> Iterator[Cycles]:
    """Hold a Cycles worker with the scene, opaque surfaces as ideal diffusers where `plain`."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Cycles(python, scene, Path(folder), options.threads, plain) as peer,
    ):
        yield peer


def say(text: str) -> None:
    """Tell what is being measured."""
    Console(stderr=True).print(text, highlight=False)
