"""What of a converted data set can be exported: masks, boxes and keypoints as COCO, and nothing without its labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pycocotools import mask as coco

from ....annotate.masks import encode_mask
from ....core.errors import InputError
from ...format import layout
from ...format.dataset_file import DatasetFile
from ...format.partial_labels import PartialKeypoint, PartialObject
from ...reader import StoredScene, StoredView
from ..files import add_picture
from ..job import Job
from .category_ids import Supercategory, category_name
from .polygons import polygons_of

#: Formats that need no more than a converted data set can have.
PARTIAL_FORMATS = ("coco",)


def check_exportable(head: DatasetFile, name: str) -> None:
    """Refuse a format that needs labels which a converted data set does not have."""
    if head.converted is None:
        return
    has = ", ".join(head.converted.has)
    if name not in PARTIAL_FORMATS:
        expected = f"{' or '.join(PARTIAL_FORMATS)}, because the data set was converted from {head.converted.title}"
        raise InputError("--format", expected, f"{name}, which needs more than it has ({has})")
    if "instances" not in head.converted.has:
        found = f"{head.converted.title}, which has {has}"
        raise InputError(f"--format {name}", "a data set with instances of objects", found)


def coco_part(job: Job, scene: StoredScene) -> dict[str, Any]:
    """Write the pictures of a converted scene, and return its part of the annotations, as `coco.write` has it."""
    folder = job.out / "images" / layout.scene_name(scene.scene_id)
    folder.mkdir(parents=True, exist_ok=True)
    images, annotations = [], []
    for view in scene.views:
        labels, camera = view.partial_labels(), view.camera_record()
        if not labels.objects or not (view.folder / layout.INSTANCES).is_file():
            continue
        name = f"{layout.view_name(view.number)}.png"
        add_picture(job, view.folder / "left.png", folder / name)
        images.append({"file_name": f"{folder.name}/{name}", "width": camera.width, "height": camera.height})
        annotations += [entry | {"image": len(images) - 1} for entry in _entries(job, view, labels.objects)]
    return {"images": images, "annotations": annotations}


def _entries(job: Job, view: StoredView, objects: Sequence[PartialObject]) -> list[dict[str, Any]]:
    """Return the annotations of a view; the whole silhouette is unknown, so there are none of that kind."""
    ids, found = view.instances(), []
    for item in objects:
        if job.options.vessels_only and not item.transparent:
            continue
        above: Supercategory = "prop" if item.transparent is False else "vessel"
        mask = ids == item.id
        seen = None
        if mask.any():
            code: Any = {"size": list(mask.shape), "counts": encode_mask(mask)}
            seen = {
                "iscrowd": 0,
                "object": item.id,
                "segmentation": polygons_of(mask) if job.options.polygons else code,
                "area": int(mask.sum()),
                "bbox": [float(value) for value in coco.toBbox(code)],
            }
        points = None if item.keypoints is None else _keypoints(item.keypoints)
        found.append(
            {
                "category": category_name(item.category, above),
                "supercategory": above,
                "instances": seen,
                "amodal": None,
                "keypoints": seen and points and seen | points,
            }
        )
    return found


def _keypoints(keypoints: Sequence[PartialKeypoint]) -> dict[str, Any]:
    """Return keypoints with COCO's flags: 2 seen, 1 labelled and not seen. COCO's first pixel covers 0 to 1."""
    flat: list[float] = []
    for point in keypoints:
        flat += [point.pixel[0] + 0.5, point.pixel[1] + 0.5, 2 if point.visible else 1]
    states = ["visible" if point.visible else "hidden" for point in keypoints]
    return {"keypoints": flat, "num_keypoints": len(keypoints), "keypoint_states": states}
