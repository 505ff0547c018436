"""COCO: instances, amodal masks and keypoints, as pycocotools and Detectron2 read them.

::

    images/000000/000.png                  <scene>/<view>, the left picture
    annotations/instances_train.json       what no opaque surface hides
    annotations/amodal_train.json          the whole silhouettes
    annotations/keypoints_train.json

Coordinates are COCO's: the first pixel covers 0 to 1, so a pixel's centre is half a pixel more than in our labels.
(Lin et al., *Microsoft COCO: Common Objects in Context*, ECCV 2014; cocodataset.org, "Data format".)
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pycocotools import mask as coco

from ....annotate.labels import Keypoint, ObjectLabel, Rle
from ....annotate.masks import decode_mask
from ....core.atomic_io import atomic_file, write_atomically
from ....core.errors import InputError
from ....core.json_file import read_json
from ....procedural.scene.splits import Split
from ...format import layout
from ...reader import StoredScene, StoredView
from ..files import add_picture, compact_json
from ..job import Exporter, Job, chosen_ids, chosen_labels, vessel_ids
from .category_ids import Supercategory, category_ids, category_name
from .partial import coco_part
from .polygons import polygons_of

#: The files of annotations.
KINDS = ("instances", "amodal", "keypoints")
#: Standard deviation of every keypoint, as a fraction of the root of the object's area: at an error of twice this
#: fraction the similarity (OKS) is exp(-1/2). COCO's own are 0.025 for eyes to 0.107 for hips; ours are no joints, so
#: all get a value between these.
SIGMA = 0.05
#: COCO's flags of keypoints by our states: not labelled, labelled but hidden, seen.
VISIBILITY = {"outside": 0, "occluded": 1, "through_glass": 2, "visible": 2}
_PARTS = ".parts"


class Numbered(NamedTuple):
    """A part of a scene, with the number of its first image."""

    part: dict[str, Any]
    first_image: int


def place(job: Job, scene: StoredScene) -> Path:
    """Return the file of a scene's annotations, which the end puts together."""
    return job.out / _PARTS / f"{layout.scene_name(scene.scene_id)}.json"


def write(job: Job, scene: StoredScene) -> None:
    """Write the pictures of a scene and its part of the annotations."""
    if job.dataset.head.converted is not None:
        write_atomically(place(job, scene), compact_json(coco_part(job, scene)).encode())
        return
    objects = scene.objects()
    ids, vessels = chosen_ids(job, objects), vessel_ids(objects)
    images, annotations = [], []
    folder = job.out / "images" / layout.scene_name(scene.scene_id)
    folder.mkdir(parents=True, exist_ok=True)
    for number, view in enumerate(scene.views):
        camera, labels = view.camera(), view.labels()
        name = f"{layout.view_name(view.number)}.png"
        add_picture(job, view.folder / "left.png", folder / name)
        images.append({"file_name": f"{folder.name}/{name}", "width": camera.width, "height": camera.height})
        annotations += [
            _annotations(job, label, view, "vessel" if label.id in vessels else "prop") | {"image": number}
            for label in chosen_labels(labels, ids, view)
        ]
    part = {"images": images, "annotations": annotations}
    write_atomically(place(job, scene), compact_json(part).encode())


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Put the parts together, one file for each split and kind."""
    folder = job.out / "annotations"
    folder.mkdir(exist_ok=True)
    categories = _categories(job, scenes)
    for split in job.splits(scenes):
        chosen = [scene for scene in scenes if job.split_of(scene.scene_id) == split]
        for kind in filter(job.has, KINDS):
            with atomic_file(folder / f"{kind}_{split}.json") as partial, partial.open("w", encoding="utf-8") as file:
                file.writelines(_file(job, chosen, kind, split, categories))
    shutil.rmtree(job.out / _PARTS)


EXPORTER = Exporter(
    purpose="instances, amodal masks and keypoints, for detectors",
    place=place,
    write=write,
    finish=finish,
    labels=KINDS,
)


def _annotations(job: Job, label: ObjectLabel, view: StoredView, supercategory: Supercategory) -> dict[str, Any]:
    """Return the three annotations of an object in a view; None for a kind of which nothing is in the picture."""
    where = f"{view.folder / layout.LABELS}: object {label.id}"
    seen, whole = _masked(job, label.mask_seen, where), _masked(job, label.mask_amodal, where)
    common = {"iscrowd": 0, "object": label.id}
    if label.fractions is not None:
        common |= {f"{name}_fraction": value for name, value in label.fractions.model_dump().items()}
    return {
        "category": category_name(label.category, supercategory),
        "supercategory": supercategory,
        "instances": seen and common | seen,
        "amodal": whole and common | whole,
        "keypoints": seen and common | seen | keypoints_of(label.keypoints),
    }


def _masked(job: Job, rle: Rle, where: str) -> dict[str, Any] | None:
    try:
        mask = decode_mask(rle.counts, rle.size)
    except ValueError as error:
        raise InputError(where, "a mask", error) from error
    if not mask.any():
        return None
    code: Any = {"size": list(rle.size), "counts": rle.counts}
    box = [float(value) for value in coco.toBbox(code)]
    segmentation = polygons_of(mask) if job.options.polygons else code
    return {"segmentation": segmentation, "area": int(mask.sum()), "bbox": box}


def keypoints_of(keypoints: Sequence[Keypoint]) -> dict[str, Any]:
    """Return keypoints as COCO has them: x, y and a flag each, zeros where there is nothing in the picture."""
    flat: list[float] = []
    for point in keypoints:
        flag = VISIBILITY[point.state]
        u, v = (0.0, 0.0) if point.pixel is None or not flag else (point.pixel[0] + 0.5, point.pixel[1] + 0.5)
        flat += [u, v, flag]
    shown = sum(VISIBILITY[point.state] > 0 for point in keypoints)
    return {"keypoints": flat, "num_keypoints": shown, "keypoint_states": [point.state for point in keypoints]}


def _parts(job: Job, scenes: Sequence[StoredScene]) -> Iterator[Numbered]:
    first = 1
    for scene in scenes:
        part = read_json(place(job, scene))
        yield Numbered(part, first)
        first += len(part["images"])


def _categories(job: Job, scenes: Sequence[StoredScene]) -> list[dict[str, Any]]:
    """Return the categories of all scenes, by id."""
    counts: dict[str, int] = {}
    above: dict[str, Supercategory] = {}
    for part, _ in _parts(job, scenes):
        for entry in part["annotations"]:
            name, count = entry["category"], len((entry["keypoints"] or {}).get("keypoint_states", ()))
            counts[name], above[name] = max(count, counts.get(name, 0)), entry["supercategory"]
    return [
        {
            "id": number,
            "name": name,
            "supercategory": above[name],
            "keypoints": [f"p{index}" for index in range(counts[name])],
            "skeleton": [],
            "sigmas": [SIGMA] * counts[name],
        }
        for name, number in category_ids(counts).items()
    ]


def _file(
    job: Job, scenes: Sequence[StoredScene], kind: str, split: Split, categories: list[dict[str, Any]]
) -> Iterator[str]:
    """Yield the text of a file of annotations."""
    info = {"description": f"{job.dataset.head.name}, seed {job.dataset.head.seed}: {kind}, {split}", "version": "1"}
    shown = categories if kind == "keypoints" else [_plain(category) for category in categories]
    yield f'{{"info": {compact_json(info)},\n"licenses": [],\n"categories": {compact_json(shown)},\n"images": [\n'
    yield from _joined(_image(part, first) for part, first in _parts(job, scenes))
    yield '\n],\n"annotations": [\n'
    ids = {category["name"]: category["id"] for category in categories}
    yield from _joined(_entries(_parts(job, scenes), kind, ids))
    yield "\n]}\n"


def _plain(category: dict[str, Any]) -> dict[str, Any]:
    return {name: category[name] for name in ("id", "name", "supercategory")}


def _image(part: dict[str, Any], first: int) -> list[dict[str, Any]]:
    return [{"id": first + number} | image for number, image in enumerate(part["images"])]


def _entries(parts: Iterator[Numbered], kind: str, ids: dict[str, int]) -> Iterator[list[dict[str, Any]]]:
    number = 0
    for part, first in parts:
        entries = []
        for entry in part["annotations"]:
            if entry[kind] is not None:
                number += 1
                place = {"id": number, "image_id": first + entry["image"], "category_id": ids[entry["category"]]}
                entries.append(place | entry[kind])
        yield entries


def _joined(groups: Iterator[list[dict[str, Any]]]) -> Iterator[str]:
    """Yield objects as JSON, a line each, with commas between them."""
    comma = ""
    for group in groups:
        for item in group:
            yield comma + compact_json(item)
            comma = ",\n"
