"""BOP, scenewise: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md.

::

    camera.json  dataset_info.json  test_targets_bop19.json
    models/models_info.json  models/obj_000002.ply
    train_pbr/000000/                     val/ and test/ for scenes of these splits
        rgb/000000.png  depth/000000.png
        mask/000000_000000.png  mask_visib/000000_000000.png      <view>_<object>
        scene_camera.json  scene_gt.json  scene_gt_info.json  scene_gt_coco.json  scene_models_info.json
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ....core.atomic_io import atomic_folder
from ....core.json_file import json_text, read_json
from ...format import layout
from ...reader import StoredScene, StoredView
from ..depth import depth_picture
from ..files import add_picture, write_grey_png
from ..job import Exporter, Job
from .bop_objects import FOLDERS, LABELS, BopObject, bop_objects, infos_of, write_head, write_json, write_models
from .bop_view import IGNORED_BELOW, camera_record, coco_annotation, gt_info, instances_of, pose_record


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / FOLDERS[job.split_of(scene.scene_id)] / layout.scene_name(scene.scene_id)


def write(job: Job, scene: StoredScene) -> None:
    """Write the models of a scene, then its folder."""
    objects = bop_objects(job, scene)
    infos = infos_of(objects)
    records: dict[str, dict[str, Any]] = {"scene_camera": {}, "scene_gt": {}, "scene_gt_info": {}}
    coco: dict[str, list] = {"images": [], "annotations": []}
    with atomic_folder(place(job, scene)) as folder:
        for name in ("rgb", *filter(job.has, LABELS)):
            (folder / name).mkdir()
        for view in scene.views:
            _write_view(job, view, objects, folder, records, coco)
        for name, record in records.items():
            (folder / f"{name}.json").write_text(json_text(record), "utf-8")
        head = {"info": {}, "licenses": [], "categories": _categories(infos)}
        (folder / "scene_gt_coco.json").write_text(json_text(head | coco), "utf-8")
        (folder / "scene_models_info.json").write_text(json_text(infos), "utf-8")
        write_models(job, objects)


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write camera, models and targets of all scenes."""
    infos: dict[str, Any] = {}
    for scene in scenes:
        infos |= read_json(place(job, scene) / "scene_models_info.json")
    write_head(job, scenes, infos)
    tests = [scene for scene in scenes if job.split_of(scene.scene_id) == "test"]
    if tests:
        write_json(job.out / "test_targets_bop19.json", [target for scene in tests for target in _targets(job, scene)])


EXPORTER = Exporter(
    purpose="BOP, scenewise: 6D poses, models, masks, depth",
    place=place,
    write=write,
    finish=finish,
    labels=LABELS,
)


def _write_view(
    job: Job,
    view: StoredView,
    objects: Sequence[BopObject],
    folder: Path,
    records: dict[str, dict[str, Any]],
    coco: dict[str, list],
) -> None:
    camera, geometry = view.camera(), view.geometry()
    name, key = f"{view.number:06d}", str(view.number)
    add_picture(job, view.folder / "left.png", folder / "rgb" / f"{name}.png")
    depth, scale = depth_picture(geometry.Z)
    if job.has("depth"):
        write_grey_png(folder / "depth" / f"{name}.png", depth)
    instances = instances_of(objects, view, camera, geometry)
    for instance in instances:
        for kind, mask in (("mask", instance.whole), ("mask_visib", instance.visible)):
            if job.has(kind):
                write_grey_png(folder / kind / f"{name}_{instance.number:06d}.png", mask)
    infos = [gt_info(instance, camera, depth) for instance in instances]
    records["scene_camera"][key] = camera_record(camera, scale)
    records["scene_gt"][key] = [pose_record(instance) for instance in instances]
    records["scene_gt_info"][key] = infos
    size = {"width": camera.width, "height": camera.height}
    coco["images"].append({"id": view.number, "file_name": f"rgb/{name}.png"} | size)
    for instance, info in zip(instances, infos, strict=True):
        if info["px_count_visib"]:
            identity = {"id": len(coco["annotations"]) + 1, "image_id": view.number}
            coco["annotations"].append(identity | size | coco_annotation(instance, info))


def _categories(infos: dict[str, Any]) -> list[dict[str, Any]]:
    return [{"id": int(number), "name": number, "supercategory": info["category"]} for number, info in infos.items()]


def _targets(job: Job, scene: StoredScene) -> list[dict[str, int]]:
    """Return what BOP's challenge asks for: objects of which a tenth can be seen."""
    folder = place(job, scene)
    poses, infos = read_json(folder / "scene_gt.json"), read_json(folder / "scene_gt_info.json")
    return [
        {"scene_id": scene.scene_id, "im_id": int(view), "obj_id": pose["obj_id"], "inst_count": 1}
        for view in sorted(poses, key=int)
        for pose, info in zip(poses[view], infos[view], strict=True)
        if info["visib_fract"] >= IGNORED_BELOW
    ]
