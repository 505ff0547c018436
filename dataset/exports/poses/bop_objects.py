"""The objects of a scene as BOP's models: one for each object, and on request one for each liquid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ....core.atomic_io import atomic_file, write_atomically
from ....core.json_file import json_text
from ....core.mesh import Mesh
from ....core.mesh_file import write_mesh
from ....procedural.description.scene import Scene, liquid_solid
from ...format.objects_file import ObjectRecord
from ...reader import StoredScene
from ..depth import DEPTH_SCALES
from ..job import Job, chosen_ids
from .models import model_id, model_info, model_mesh, scaled_mesh

#: Numbers of liquids within a scene begin here; those of objects are below.
FIRST_LIQUID = 500
#: Folders by split; `pbr` is BOP's word for pictures that were rendered.
FOLDERS = {"train": "train_pbr", "val": "val", "test": "test"}

#: What BOP's layouts can leave out.
LABELS = ("depth", "mask", "mask_visib")


@dataclass(frozen=True, eq=False)
class BopObject:
    """A model with its pose: that of the object which it is, or whose liquid it is."""

    model: int  #: `obj_id`
    object_id: int
    mesh: Mesh  #: frame of the object [m]
    info: dict[str, Any]  #: entry of `models_info.json`
    liquid: bool = False


def bop_objects(job: Job, scene: StoredScene) -> list[BopObject]:
    """Return the chosen objects of a scene by their ids, then, on request, the liquids of its vessels."""
    objects, description = scene.objects(), scene.scene()
    ids = chosen_ids(job, objects)
    records = {record.id: record for record in objects.objects}
    found = []
    for item in description.objects:
        if item.id in ids:
            mesh = model_mesh(item)
            info = model_info(mesh, records[item.id])
            found.append(BopObject(model_id(scene.scene_id, item.id), item.id, mesh, info))
    if job.options.liquids:
        found += _liquids(scene.scene_id, description, records)
    return found


def _liquids(scene_id: int, scene: Scene, records: dict[int, ObjectRecord]) -> list[BopObject]:
    found = []
    inside = {item.within for item in scene.objects}
    for body in scene.vessels:
        for number, liquid in enumerate(body.liquids):
            mesh = liquid_solid(body, number)
            # A liquid is as symmetric as its vessel where it stands upright and nothing is in it.
            alike = liquid.up is None and not body.contents and body.name not in inside
            kept = {} if alike else {"symmetries_continuous": (), "symmetries_discrete": ()}
            record = records[body.id].model_copy(update={"name": f"{body.name}-liquid-{number}"} | kept)
            info = model_info(mesh, record) | {"category": f"liquid, {liquid.medium.name}"}
            found.append(BopObject(model_id(scene_id, FIRST_LIQUID + len(found)), body.id, mesh, info, liquid=True))
    return found


def infos_of(objects: Sequence[BopObject]) -> dict[str, Any]:
    """Return ``models_info.json`` of some objects."""
    return {str(one.model): one.info for one in objects}


def write_models(job: Job, objects: Sequence[BopObject]) -> None:
    """Write the PLY files of models [mm]."""
    folder = job.out / "models"
    folder.mkdir(exist_ok=True)
    for one in objects:
        with atomic_file(folder / f"obj_{one.model:06d}.ply") as partial:
            write_mesh(scaled_mesh(one.mesh), partial)


def write_head(job: Job, scenes: Sequence[StoredScene], infos: dict[str, Any]) -> None:
    """Write ``camera.json``, ``dataset_info.json`` and ``models_info.json``."""
    camera = scenes[0].views[0].camera()
    (cx, cy), scale = camera.centre, DEPTH_SCALES[0]
    numbers = {"fx": camera.fx, "fy": camera.fy, "cx": cx, "cy": cy, "width": camera.width, "height": camera.height}
    write_json(job.out / "camera.json", numbers | {"depth_scale": scale})
    write_json(job.out / "models" / "models_info.json", infos)
    head = job.dataset.head
    write_json(job.out / "dataset_info.json", {"name": head.name, "description": f"glassware, seed {head.seed}"})


def write_json(path: Path, data: object) -> None:
    """Write a JSON file, with its folder."""
    path.parent.mkdir(exist_ok=True)
    write_atomically(path, json_text(data).encode())
