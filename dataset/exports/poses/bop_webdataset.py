"""BOP as WebDataset shards, which the toolkit calls bop-webdataset (bop_toolkit_lib/dataset).

::

    camera.json  dataset_info.json  models/
    train_pbr_web/                        val_web/ and test_web/ for scenes of these splits
        shard-000012.tar                  a shard for each scene
            000012_000003.rgb.png .depth.png .mask.json .mask_visib.json .gt.json .gt_info.json .camera.json
        key_to_shard.json                 number of the shard by the key of a sample

Poses, masks, depth and counts are those of the scenewise layout (`bop_view`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ....core.json_file import json_text, read_json
from ...format import layout
from ...reader import StoredScene, StoredView
from ..depth import depth_picture
from ..files import compact_json, grey_png, whole_png
from ..job import Exporter, Job
from ..tar_files import write_tar
from .bop_objects import FOLDERS, LABELS, BopObject, bop_objects, infos_of, write_head, write_json, write_models
from .bop_view import camera_record, gt_info, instances_of, pose_record, run_lengths


def place(job: Job, scene: StoredScene) -> Path:
    """Return the shard of a scene."""
    return _folder(job, scene) / f"shard-{layout.scene_name(scene.scene_id)}.tar"


def write(job: Job, scene: StoredScene) -> None:
    """Write the shard of a scene, and its models before the shard appears."""
    write_tar(place(job, scene), _samples(job, scene))


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write camera, models, and which shard has which key."""
    infos: dict[str, Any] = {}
    shards: dict[Path, dict[str, int]] = {}
    for scene in scenes:
        infos |= read_json(_infos_path(job, scene))
        keys = {_key(scene, view): scene.scene_id for view in scene.views}
        shards.setdefault(_folder(job, scene), {}).update(keys)
    write_head(job, scenes, infos)
    for folder, keys in shards.items():
        write_json(folder / "key_to_shard.json", keys)


EXPORTER = Exporter(
    purpose="BOP in tar shards, for streaming",
    place=place,
    write=write,
    finish=finish,
    labels=LABELS,
)


def _folder(job: Job, scene: StoredScene) -> Path:
    return job.out / f"{FOLDERS[job.split_of(scene.scene_id)]}_web"


def _infos_path(job: Job, scene: StoredScene) -> Path:
    return job.out / "models" / f"models_info_{layout.scene_name(scene.scene_id)}.json"


def _key(scene: StoredScene, view: StoredView) -> str:
    return f"{scene.scene_id:06d}_{view.number:06d}"


def _samples(job: Job, scene: StoredScene) -> Iterator[tuple[str, Iterator[tuple[str, bytes]]]]:
    objects = bop_objects(job, scene)
    for view in scene.views:
        yield _key(scene, view), _members(job, view, objects)
    write_models(job, objects)
    write_json(_infos_path(job, scene), infos_of(objects))


def _members(job: Job, view: StoredView, objects: Sequence[BopObject]) -> Iterator[tuple[str, bytes]]:
    """Yield the files of a view, in the order of the toolkit's converter."""
    camera, geometry = view.camera(), view.geometry()
    depth, scale = depth_picture(geometry.Z)
    instances = instances_of(objects, view, camera, geometry)
    yield "rgb.png", whole_png(view.folder / "left.png")
    if job.has("depth"):
        yield "depth.png", grey_png(depth)
    for kind, name in (("mask", "whole"), ("mask_visib", "visible")):
        if job.has(kind):
            masks = {str(instance.number): run_lengths(getattr(instance, name)) for instance in instances}
            yield f"{kind}.json", compact_json(masks).encode()
    yield "gt.json", json_text([pose_record(instance) for instance in instances]).encode()
    yield "gt_info.json", json_text([gt_info(instance, camera, depth) for instance in instances]).encode()
    yield "camera.json", json_text(camera_record(camera, scale)).encode()
