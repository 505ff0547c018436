"""``glassware verify``: check a data set from its files alone, and by rendering views again."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed, run_command
from ...core.model import Model
from ...core.stopping import check_stop
from ...core.user_text import UserPath, counted
from ..builds.rerender import chosen, ready, rerendered
from ..builds.verify import head_faults, index_faults, label_faults, scene_faults
from ..format import layout
from ..format.dataset_file import DatasetFile, read_head
from ..settings.config import parse_request
from .progress import tracked

_DESCRIPTION = """Check a data set: schema, completeness, checksums and index from its files alone.

Each fault is printed as one line, and the exit code is 1 where any is found."""
#: Most faults that are printed.
_MAX_PRINTED = 100


class Verify(Model):
    """The request: the data set, and which checks to run besides those of its files."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set")
    labels: bool = Field(
        default=False, description="Prove each view's labels by the scene's description and its meshes"
    )
    rerender: int = Field(default=0, ge=0, description="Random views to render again and compare bit for bit")
    draw: int | None = Field(default=None, ge=0, description="Seed of the choice of these views; random by default")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _verify(given))


def _verify(arguments: Sequence[str]) -> None:
    request = parse_request(Verify, arguments, "glassware verify", _DESCRIPTION)
    root, console = request.directory, Console()
    if not (root / layout.DATASET).is_file():
        raise InputError(root, f"the folder of a data set, with {layout.DATASET}", "none")
    head = _head(root)
    if request.rerender:
        ready(root, head)
    rng = np.random.Generator(np.random.PCG64(request.draw))
    picked = chosen(root, request.rerender, rng) if request.rerender else {}
    count = 0
    for fault in _faults(request, head, picked, console):
        check_stop()
        count += 1
        if count <= _MAX_PRINTED:
            console.print(fault, markup=False, highlight=False, soft_wrap=True)
    if count:
        raise WorkFailed(
            f"{root}: {count} {'fault' if count == 1 else 'faults'}"
            + (f", {_MAX_PRINTED} of them printed" if count > _MAX_PRINTED else "")
        )
    scenes = len(layout.scene_ids(root))
    also = ""
    if request.labels:
        also = ", labels correct" if head.converted is None else ", its labels agree with each other"
    also += f", {counted(sum(map(len, picked.values())), 'view')} rendered again bit for bit" if picked else ""
    console.print(f"{root}: {counted(scenes, 'scene')}, no faults{also}", markup=False, highlight=False, soft_wrap=True)


def _head(root: Path) -> DatasetFile:
    try:
        return read_head(root)
    except InputError as error:  # a damaged file is a finding here, and not an invalid request
        raise WorkFailed(str(error)) from error


def _faults(request: Verify, head: DatasetFile, picked: dict[int, list[int]], console: Console) -> Iterator[str]:
    root = request.directory
    yield from head_faults(root, head)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    scenes = layout.scene_ids(root)
    with ThreadPoolExecutor(cores) as pool:
        found = pool.map(lambda scene: list(scene_faults(root, head, scene)), scenes)
        for faults in tracked(found, "checking scenes", len(scenes), console):
            yield from faults
        yield from index_faults(root)
        if request.labels:
            found = pool.map(lambda scene: list(label_faults(root, scene, head)), scenes)
            for faults in tracked(found, "checking labels", len(scenes), console):
                yield from faults
    for scene, views in tracked(picked.items(), "rendering views again", len(picked), console):
        yield from rerendered(root, head, scene, views)


if __name__ == "__main__":
    sys.exit(main())
