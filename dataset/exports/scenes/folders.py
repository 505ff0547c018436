"""Exports that write a folder, or a file, for each scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ....core.atomic_io import atomic_folder
from ....procedural.description.scene import Scene
from ...format import layout
from ...format.objects_file import ObjectRecord
from ...reader import StoredScene
from ..job import Exporter, Job, chosen_ids, write_nothing

#: Writes a scene to a path: (path, scene, ``objects.json``, ids of the chosen objects).
WriteScene = Callable[[Path, Scene, Sequence[ObjectRecord], Sequence[int]], None]


def scene_folders(purpose: str, fill: WriteScene) -> Exporter:
    """Return an exporter whose scenes are folders.

    Parameters
    ----------
    purpose : str
        What the format is for, and who reads it.
    fill : callable
        Writes the files of a scene into a new folder.
    """

    def place(job: Job, scene: StoredScene) -> Path:
        return job.out / layout.scene_name(scene.scene_id)

    def write(job: Job, scene: StoredScene) -> None:
        objects = scene.objects()
        with atomic_folder(place(job, scene)) as folder:
            fill(folder, scene.scene(), objects.objects, chosen_ids(job, objects))

    return Exporter(purpose=purpose, place=place, write=write, finish=write_nothing)


def scene_files(purpose: str, ending: str, write_file: WriteScene) -> Exporter:
    """Return an exporter whose scenes are files.

    Parameters
    ----------
    purpose : str
        What the format is for, and who reads it.
    ending : str
        Of the files' names, such as ``".glb"``.
    write_file : callable
        Writes the file of a scene; it appears whole or not at all.
    """

    def place(job: Job, scene: StoredScene) -> Path:
        return job.out / f"{layout.scene_name(scene.scene_id)}{ending}"

    def write(job: Job, scene: StoredScene) -> None:
        objects = scene.objects()
        write_file(place(job, scene), scene.scene(), objects.objects, chosen_ids(job, objects))

    return Exporter(purpose=purpose, place=place, write=write, finish=write_nothing)
