"""``glassware verify``: what is wrong with a data set, from its files alone, and by making views again."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from pydantic import Field
from rich.console import Console
from rich.progress import track

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed, run_command
from ...core.model import Model
from ...core.stopping import check_stop
from ...core.user_text import UserPath
from ..builds.rerender import chosen, ready, rerendered
from ..builds.verify import head_faults, index_faults, scene_faults
from ..format import layout
from ..format.dataset_file import DatasetFile
from ..settings.config import parsed
from ..writer import read_head

_DESCRIPTION = """Check a data set: schema, completeness, checksums and index from its files alone.

Each fault is a line; the exit code is 1 where there is one."""
#: Most faults that are told of one by one.
_MOST_TOLD = 100


class Verify(Model):
    """The request: which data set, and how many views to make again."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set")
    rerender: int = Field(default=0, ge=0, description="Random views to make again and compare bit for bit")
    draw: int | None = Field(default=None, ge=0, description="Seed of the choice of these views; another each time")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _verify(given))


def _verify(arguments: Sequence[str]) -> None:
    request = parsed(Verify, None, arguments, "glassware verify", _DESCRIPTION)
    root, console = request.directory, Console()
    if not (root / layout.DATASET).is_file():
        raise InputError(root, f"the folder of a data set, with {layout.DATASET}", "none")
    head = _head(root)
    if request.rerender:
        ready(root, head)
    rng = np.random.Generator(np.random.PCG64(request.draw))
    picked = chosen(root, request.rerender, rng) if request.rerender else {}
    count = 0
    for fault in _faults(root, head, picked, console):
        check_stop()
        count += 1
        if count <= _MOST_TOLD:
            console.print(fault, markup=False, highlight=False, soft_wrap=True)
    if count:
        raise WorkFailed(
            f"{root}: {count} {'fault' if count == 1 else 'faults'}"
            + (f", {_MOST_TOLD} of them told" if count > _MOST_TOLD else "")
        )
    scenes = len(layout.scene_ids(root))
    again = f", {sum(map(len, picked.values()))} views made again bit for bit" if picked else ""
    console.print(f"{root}: {scenes} scenes, all is well{again}", markup=False, highlight=False, soft_wrap=True)


def _head(root: Path) -> DatasetFile:
    try:
        return read_head(root)
    except InputError as error:  # here a damaged file is what was asked about, and not a wrong request
        raise WorkFailed(str(error)) from error


def _faults(root: Path, head: DatasetFile, picked: dict[int, list[int]], console: Console) -> Iterator[str]:
    yield from head_faults(root, head)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    scenes = layout.scene_ids(root)
    with ThreadPoolExecutor(cores) as pool:
        found = pool.map(lambda scene: list(scene_faults(root, head, scene)), scenes)
        for faults in _tracked(found, "checking scenes", len(scenes), console):
            yield from faults
    yield from index_faults(root)
    for scene, views in _tracked(picked.items(), "making views again", len(picked), console):
        yield from rerendered(root, head, scene, views)


def _tracked(items: Iterable, what: str, total: int, console: Console) -> Iterator:
    if not console.is_terminal:
        return iter(items)
    return iter(track(items, what, total, console=console, transient=True))


if __name__ == "__main__":
    sys.exit(main())
