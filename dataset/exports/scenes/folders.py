"""Exports that write a folder for each scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ....core.atomic_io import atomic_folder
from ....procedural.description.scene import Scene
from ...format import layout
from ...format.objects_file import ObjectRecord
from ...reader import StoredScene
from ..job import Exporter, Job, chosen_ids, write_nothing


def scene_folders(purpose: str, fill: Callable[[Path, Scene, Sequence[ObjectRecord], Sequence[int]], None]) -> Exporter:
    """Return an exporter whose scenes are folders.

    Parameters
    ----------
    purpose : str
        What the format is for, and who reads it.
    fill : callable
        Writes the files of a scene into a new folder: (folder, scene, ``objects.json``, ids of the chosen objects).
    """

    def place(job: Job, scene: StoredScene) -> Path:
        return job.out / layout.scene_name(scene.scene_id)

    def write(job: Job, scene: StoredScene) -> None:
        objects = scene.objects()
        with atomic_folder(place(job, scene)) as folder:
            fill(folder, scene.scene(), objects.objects, chosen_ids(job, objects))

    return Exporter(purpose=purpose, place=place, write=write, finish=write_nothing)
