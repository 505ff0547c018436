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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....annotate.labels import ObjectLabel
from ....annotate.projection import inverse_pose, transformed
from ....core.atomic_io import atomic_file, atomic_folder, write_atomically
from ....core.json_file import json_text, read_json
from ....core.mesh import Mesh
from ....core.mesh_file import write_mesh
from ....procedural.description.camera import Camera
from ...format import layout
from ...reader import StoredScene, StoredView
from ..depth import DEPTH_SCALES, MM, depth_picture
from ..files import add_picture, write_grey_png
from ..job import Exporter, Job, chosen_ids, chosen_labels
from .models import model_id, model_info, model_mesh, scaled_mesh
from .silhouette import wide_silhouette

#: Folders by split; `pbr` is BOP's word for pictures that were rendered.
FOLDERS = {"train": "train_pbr", "val": "val", "test": "test"}
#: Objects with a smaller visible fraction are to be ignored in `scene_gt_coco.json` (calc_gt_coco.py).
_IGNORED_BELOW = 0.1
#: Of objects without a visible pixel.
_NO_BOX = [-1, -1, -1, -1]


@dataclass(frozen=True, eq=False)
class Instance:
    """An object in a view."""

    number: int  #: in `scene_gt.json`
    model: int  #: `obj_id`
    mesh: Mesh  #: [m]
    label: ObjectLabel
    whole: np.ndarray  #: (H, W) bool, silhouette
    visible: np.ndarray  #: (H, W) bool


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / FOLDERS[job.split_of(scene.scene_id)] / layout.scene_name(scene.scene_id)


def write(job: Job, scene: StoredScene) -> None:
    """Write the models of a scene, then its folder."""
    objects, description = scene.objects(), scene.scene()
    ids = chosen_ids(job, objects)
    meshes = {item.id: model_mesh(item) for item in description.objects if item.id in ids}
    infos = {
        str(model_id(scene.scene_id, record.id)): model_info(meshes[record.id], record)
        for record in objects.objects
        if record.id in ids
    }
    records: dict[str, dict[str, Any]] = {"scene_camera": {}, "scene_gt": {}, "scene_gt_info": {}}
    coco: dict[str, list] = {"images": [], "annotations": []}
    with atomic_folder(place(job, scene)) as folder:
        for name in ("rgb", "depth", "mask", "mask_visib"):
            (folder / name).mkdir()
        for view in scene.views:
            _write_view(job, scene, view, meshes, folder, records, coco)
        for name, record in records.items():
            (folder / f"{name}.json").write_text(json_text(record), "utf-8")
        head = {"info": {}, "licenses": [], "categories": _categories(infos)}
        (folder / "scene_gt_coco.json").write_text(json_text(head | coco), "utf-8")
        (folder / "scene_models_info.json").write_text(json_text(infos), "utf-8")
        _write_models(job, scene, meshes)


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write camera, models and targets of all scenes."""
    camera = scenes[0].views[0].camera()
    (cx, cy), scale = camera.centre, DEPTH_SCALES[0]
    numbers = {"fx": camera.fx, "fy": camera.fy, "cx": cx, "cy": cy, "width": camera.width, "height": camera.height}
    _write_json(job.out / "camera.json", numbers | {"depth_scale": scale})
    infos: dict[str, Any] = {}
    for scene in scenes:
        infos |= read_json(place(job, scene) / "scene_models_info.json")
    _write_json(job.out / "models" / "models_info.json", infos)
    head = job.dataset.head
    _write_json(job.out / "dataset_info.json", {"name": head.name, "description": f"glassware, seed {head.seed}"})
    tests = [scene for scene in scenes if job.split_of(scene.scene_id) == "test"]
    if tests:
        _write_json(job.out / "test_targets_bop19.json", [target for scene in tests for target in _targets(job, scene)])


EXPORTER = Exporter(
    purpose="BOP, scenewise: poses, models, masks, depth, for 6D pose estimators",
    place=place,
    write=write,
    finish=finish,
)


def _write_view(
    job: Job,
    scene: StoredScene,
    view: StoredView,
    meshes: dict[int, Mesh],
    folder: Path,
    records: dict[str, dict[str, Any]],
    coco: dict[str, list],
) -> None:
    camera, labels, geometry = view.camera(), view.labels(), view.geometry()
    name, key = f"{view.number:06d}", str(view.number)
    add_picture(job, view.folder / "left.png", folder / "rgb" / f"{name}.png")
    depth, scale = depth_picture(geometry.Z)
    write_grey_png(folder / "depth" / f"{name}.png", depth)
    rows = {label.id: row for row, label in enumerate(labels.objects)}
    instances = [
        Instance(
            number=number,
            model=model_id(scene.scene_id, label.id),
            mesh=meshes[label.id],
            label=label,
            whole=geometry.crossed[rows[label.id]],
            visible=geometry.id == label.id,
        )
        for number, label in enumerate(chosen_labels(labels, list(meshes), view))
    ]
    for instance in instances:
        for kind, mask in (("mask", instance.whole), ("mask_visib", instance.visible)):
            write_grey_png(folder / kind / f"{name}_{instance.number:06d}.png", mask)
    infos = [gt_info(instance, camera, depth) for instance in instances]
    records["scene_camera"][key] = _camera(camera, scale)
    records["scene_gt"][key] = [_pose(instance) for instance in instances]
    records["scene_gt_info"][key] = infos
    size = {"width": camera.width, "height": camera.height}
    coco["images"].append({"id": view.number, "file_name": f"rgb/{name}.png"} | size)
    for instance, info in zip(instances, infos, strict=True):
        if info["px_count_visib"]:
            identity = {"id": len(coco["annotations"]) + 1, "image_id": view.number}
            coco["annotations"].append(identity | size | _coco_annotation(instance, info))


def gt_info(instance: Instance, camera: Camera, depth: np.ndarray) -> dict[str, Any]:
    """Return counts and boxes of an instance, as calc_gt_info.py defines them.

    `px_count_all` and `bbox_obj` count pixels outside the picture as well, on a canvas of three pictures by three.
    Boxes are (left, top, right - left, bottom - top) of pixel numbers: one less than the width in pixels.
    """
    whole = instance.whole
    origin = (0, 0)
    if _leaves_the_picture(instance.label, camera):
        points = transformed(np.array(instance.label.camera_T_object), instance.mesh.vertices)
        canvas = wide_silhouette(points, instance.mesh.faces, camera.K, camera.width, camera.height)
        canvas[camera.height : 2 * camera.height, camera.width : 2 * camera.width] = whole
        whole, origin = canvas, (camera.width, camera.height)
    total, visible = int(whole.sum()), int(instance.visible.sum())
    return {
        "px_count_all": total,
        "px_count_valid": int((instance.whole & (depth > 0)).sum()),
        "px_count_visib": visible,
        "visib_fract": visible / total if total else 0.0,
        "bbox_obj": box_of(whole, origin) if visible else _NO_BOX,
        "bbox_visib": box_of(instance.visible) if visible else _NO_BOX,
    }


def box_of(mask: np.ndarray, origin: tuple[int, int] = (0, 0)) -> list[int]:
    """Return left, top, right - left, bottom - top of a mask with pixels, as the toolkit's calc_2d_bbox does."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return [left - origin[0], top - origin[1], int(columns[-1]) - left, int(rows[-1]) - top]


def _leaves_the_picture(label: ObjectLabel, camera: Camera) -> bool:
    box = label.box2d.amodal
    if box is None:
        return True
    left, top, right, bottom = box
    return left < -0.5 or top < -0.5 or right > camera.width - 0.5 or bottom > camera.height - 0.5


def _camera(camera: Camera, depth_scale: float) -> dict[str, Any]:
    camera_T_world = inverse_pose(np.array(camera.world_T_camera))
    return {
        "cam_K": camera.K.ravel().tolist(),
        "cam_R_w2c": camera_T_world[:3, :3].ravel().tolist(),
        "cam_t_w2c": (camera_T_world[:3, 3] * MM).tolist(),
        "depth_scale": depth_scale,
    }


def _pose(instance: Instance) -> dict[str, Any]:
    camera_T_object = np.array(instance.label.camera_T_object)
    return {
        "cam_R_m2c": camera_T_object[:3, :3].ravel().tolist(),
        "cam_t_m2c": (camera_T_object[:3, 3] * MM).tolist(),
        "obj_id": instance.model,
    }


def _coco_annotation(instance: Instance, info: dict[str, Any]) -> dict[str, Any]:
    """Return an annotation as calc_gt_coco.py writes it: here a box's width is the number of pixels."""
    mask = instance.visible
    left, top, across, down = box_of(mask)
    edges = np.flatnonzero(np.diff(mask.ravel(order="F").astype(np.int8), prepend=0)).tolist()
    runs = np.diff([0, *edges, mask.size]).tolist()
    return {
        "category_id": instance.model,
        "iscrowd": 0,
        "area": info["px_count_visib"],
        "bbox": [left, top, across + 1, down + 1],
        "segmentation": {"counts": runs, "size": list(mask.shape)},
        "ignore": info["visib_fract"] < _IGNORED_BELOW,
    }


def _categories(infos: dict[str, Any]) -> list[dict[str, Any]]:
    return [{"id": int(number), "name": number, "supercategory": info["category"]} for number, info in infos.items()]


def _write_models(job: Job, scene: StoredScene, meshes: dict[int, Mesh]) -> None:
    folder = job.out / "models"
    folder.mkdir(exist_ok=True)
    for number, mesh in meshes.items():
        with atomic_file(folder / f"obj_{model_id(scene.scene_id, number):06d}.ply") as partial:
            write_mesh(scaled_mesh(mesh), partial)


def _targets(job: Job, scene: StoredScene) -> list[dict[str, int]]:
    """Return what BOP's challenge asks for: objects of which a tenth can be seen."""
    folder = place(job, scene)
    poses, infos = read_json(folder / "scene_gt.json"), read_json(folder / "scene_gt_info.json")
    return [
        {"scene_id": scene.scene_id, "im_id": int(view), "obj_id": pose["obj_id"], "inst_count": 1}
        for view in sorted(poses, key=int)
        for pose, info in zip(poses[view], infos[view], strict=True)
        if info["visib_fract"] >= _IGNORED_BELOW
    ]


def _write_json(path: Path, data: object) -> None:
    path.parent.mkdir(exist_ok=True)
    write_atomically(path, json_text(data).encode())
