"""Which scenes a build has to make: those asked for that are not there, whole and right."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import InputError
from ..format import layout
from ..format.checksums import faults_of
from ..format.views_table import scene_views
from .journal import last_attempts


@dataclass(frozen=True)
class Plan:
    """What is to be made, in order, and what is kept."""

    make: tuple[int, ...]
    kept: tuple[int, ...]


def planned(
    root: Path, scenes: Iterable[int], contents: bool, threads: int, say: Callable[[str], None], failed_only: bool
) -> Plan:
    """Look at the scenes that are there.

    Parameters
    ----------
    root : Path
        The data set.
    scenes : iterable of int
        Those asked for, in the order in which they are to be made.
    contents : bool
        Whether the files of scenes that are there are hashed; their names and sizes are compared in any case.
    threads : int
        Scenes to check at a time.
    say : callable
        Takes a line about each scene that has to be made again.
    failed_only : bool
        Whether only scenes whose last try failed are to be made.
    """
    asked = list(scenes)
    there = set(layout.scene_ids(root))
    present = [scene for scene in asked if scene in there]
    with ThreadPoolExecutor(threads) as pool:
        faults = list(pool.map(lambda scene: first_fault(root, scene, contents), present))
    for scene, fault in zip(present, faults, strict=True):
        if fault is not None:
            say(f"scene {scene} is made again: {fault}")
    kept = {scene for scene, fault in zip(present, faults, strict=True) if fault is None}
    make = [scene for scene in asked if scene not in kept]
    if failed_only:
        failed = {scene for scene, attempt in last_attempts(root).items() if attempt.state != "made"}
        make = [scene for scene in make if scene in failed]
    return Plan(tuple(make), tuple(scene for scene in asked if scene in kept))


def first_fault(root: Path, scene: int, contents: bool) -> str | None:
    """Return the first thing wrong with the files of a scene; None where all is well."""
    fault = next(faults_of(layout.scene_folder(root, scene), contents), None)
    if fault is None:
        try:
            scene_views(root, scene)
        except InputError as error:
            return str(error)
    return fault
