"""Point clouds of each view and of each scene, with colours, normals and ids.

::

    000000/scene.ply  000000/000.ply  000000/001.ply
"""

from __future__ import annotations

from pathlib import Path

from ....core.atomic_io import atomic_folder
from ...format import layout
from ...reader import StoredScene
from ..job import Exporter, Job, chosen_ids, write_nothing
from .points import cloud_file, cloud_of, write_cloud


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / layout.scene_name(scene.scene_id)


def write(job: Job, scene: StoredScene) -> None:
    """Write a cloud for each view, and one of all its views."""
    ids = frozenset(chosen_ids(job, scene.objects())) if job.options.vessels_only else None
    with atomic_folder(place(job, scene)) as folder, cloud_file(folder / "scene.ply") as add:
        for view in scene.views:
            cloud = cloud_of(view, ids, job.options.layers)
            write_cloud(folder / f"{layout.view_name(view.number)}.ply", cloud)
            add(cloud)


EXPORTER = Exporter(
    purpose="point clouds: Open3D, MeshLab, CloudCompare",
    place=place,
    write=write,
    finish=write_nothing,
)
