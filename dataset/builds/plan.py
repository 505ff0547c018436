"""Which scenes a build has to render: the requested ones that are missing, incomplete or damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import InputError
from ..format import layout
from ..format.checksums import faults_of
from ..format.views_table import scene_views
from .build_log import last_attempts


@dataclass(frozen=True)
class Plan:
    """Scenes to render, in order, and scenes to keep."""

    to_render: tuple[int, ...]
    to_keep: tuple[int, ...]


def plan_build(
    root: Path, scenes: Iterable[int], contents: bool, threads: int, say: Callable[[str], None], failed_only: bool
) -> Plan:
    """Check the existing scenes, and decide which of the requested ones to render.

    Parameters
    ----------
    root : Path
        The data set.
    scenes : iterable of int
        The requested scenes, in the order in which they are to be rendered.
    contents : bool
        Whether the files of existing scenes are hashed; their names and sizes are compared in any case.
    threads : int
        Scenes to check at a time.
    say : callable
        Receives a line about each scene that has to be rendered again.
    failed_only : bool
        Whether only scenes whose last attempt failed are to be rendered.
    """
    requested = list(scenes)
    existing = set(layout.scene_ids(root))
    present = [scene for scene in requested if scene in existing]
    with ThreadPoolExecutor(threads) as pool:
        faults = list(pool.map(lambda scene: first_fault(root, scene, contents), present))
    for scene, fault in zip(present, faults, strict=True):
        if fault is not None:
            say(f"scene {scene} is rendered again: {fault}")
    intact = {scene for scene, fault in zip(present, faults, strict=True) if fault is None}
    to_render = [scene for scene in requested if scene not in intact]
    if failed_only:
        failed = {scene for scene, attempt in last_attempts(root).items() if attempt.state != "made"}
        to_render = [scene for scene in to_render if scene in failed]
    return Plan(tuple(to_render), tuple(scene for scene in requested if scene in intact))


def first_fault(root: Path, scene: int, contents: bool) -> str | None:
    """Return the first fault in the files of a scene; None where they are intact."""
    fault = next(faults_of(layout.scene_folder(root, scene), contents), None)
    if fault is None:
        try:
            scene_views(root, scene)
        except InputError as error:
            return str(error)
    return fault
