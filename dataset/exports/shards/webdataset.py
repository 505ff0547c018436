"""WebDataset shards with the card of a data set on the Hugging Face Hub.

::

    README.md
    pictures/train-000000.tar    a shard for each scene; val- and test- for scenes of these splits
    geometry/train-000000.tar
    labels/train-000000.tar

A sample is a view; its key, such as ``000000_003``, is the same in the three configurations.
(github.com/webdataset/webdataset; huggingface.co/docs/datasets, "Structure your repository", "WebDataset".)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from ....annotate.labels import ObjectLabel
from ....core.atomic_io import write_atomically
from ....procedural.description.camera import Camera
from ....procedural.scene.splits import Split
from ...format import layout
from ...format.exr import channel, read_exr
from ...format.objects_file import ObjectRecord, ObjectsFile
from ...reader import StoredScene, StoredView
from ..depth import depth_picture
from ..files import compact_json, grey_png, read_bytes, whole_png
from ..job import Exporter, Job, chosen_ids, chosen_labels
from ..tar_files import write_tar
from .features import CAMERA, GEOMETRY, OBJECT, Kind, features_yaml

#: Splits by the names that the Hub gives them.
_HUB_SPLITS = {"train": "train", "val": "validation", "test": "test"}
#: Members of a sample by their endings.
Members = Iterator[tuple[str, bytes]]


def place(job: Job, scene: StoredScene) -> Path:
    """Return the shard of a scene that is written last."""
    return _shard(job, scene, "labels")


def write(job: Job, scene: StoredScene) -> None:
    """Write the three shards of a scene."""
    objects = scene.objects()
    writers: dict[str, Callable[[StoredView], Members]] = {
        "pictures": partial(_pictures, job, scene),
        "geometry": _geometry,
        "labels": partial(_labels, job, objects),
    }
    for config, members in writers.items():
        shard = _shard(job, scene, config)
        shard.parent.mkdir(exist_ok=True)
        write_tar(shard, ((key_of(scene, view), members(view)) for view in scene.views))


def key_of(scene: StoredScene, view: StoredView) -> str:
    """Return the key of a sample."""
    return f"{layout.scene_name(scene.scene_id)}_{layout.view_name(view.number)}"


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write the card."""
    write_atomically(job.out / "README.md", card(job, job.splits(scenes), len(scenes)).encode())


EXPORTER = Exporter(
    purpose="tar shards with a Hugging Face card, for streaming",
    place=place,
    write=write,
    finish=finish,
    eyes=True,
)


def columns(job: Job) -> dict[str, dict[str, Kind]]:
    """Return the columns of each configuration with their types."""
    own: dict[str, dict[str, Kind]] = {
        "pictures": {f"{eye}.png": "image" for eye in job.eyes()} | {"camera.json": CAMERA},
        "geometry": {
            "depth.png": "image",
            "instances.png": "image",
            "geometry.exr": "binary",
            "geometry.json": GEOMETRY,
        },
        "labels": {"labels.json": {"objects": [OBJECT]}},
    }
    return {config: {"__key__": "string", "__url__": "string"} | kinds for config, kinds in own.items()}


def card(job: Job, splits: Sequence[Split], scenes: int) -> str:
    """Return the text of ``README.md``."""
    head, configs = job.dataset.head, columns(job)
    files = {name: [{"split": _HUB_SPLITS[s], "path": f"{name}/{s}-*.tar"} for s in splits] for name in configs}
    first = next(iter(configs))
    data = {
        "pretty_name": head.name,
        "task_categories": ["depth-estimation", "image-segmentation", "object-detection"],
        "tags": ["synthetic", "transparent objects", "stereo", "6d-pose"],
        "configs": [
            {"config_name": name, "data_files": files[name]} | ({"default": True} if name == first else {})
            for name in configs
        ],
        "dataset_info": [{"config_name": name, "features": features_yaml(kinds)} for name, kinds in configs.items()],
    }
    rows = [f"| `{asset.source}` | {asset.licence} | `{asset.sha256[:16]}` |" for asset in head.assets]
    assets = ["| asset file | licence | SHA-256 |", "|---|---|---|", *rows] if rows else ["No asset files were used."]
    lines = [
        f"# {head.name}",
        "",
        f"{scenes} scenes of transparent objects, rendered and labelled by glassware (seed {head.seed}).",
        "Metres and radians, OpenCV camera axes; the centre of pixel (0, 0) is at 0. `depth.png` is the planar depth",
        "of the first surface in steps of `depth_step_mm`, 0 without one. Masks are COCO's compressed run lengths.",
        "",
        "## Assets",
        "",
        *assets,
    ]
    return "---\n" + yaml.safe_dump(data, sort_keys=False) + "---\n\n" + "\n".join(lines) + "\n"


def _shard(job: Job, scene: StoredScene, config: str) -> Path:
    return job.out / config / f"{job.split_of(scene.scene_id)}-{layout.scene_name(scene.scene_id)}.tar"


def _pictures(job: Job, scene: StoredScene, view: StoredView) -> Members:
    for eye in job.eyes():
        yield f"{eye}.png", whole_png(view.folder / f"{eye}.png")
    yield "camera.json", compact_json(_camera(view.camera(), scene.scene_id, view.number)).encode()


def _geometry(view: StoredView) -> Members:
    path = view.folder / layout.GEOMETRY
    steps, scale = depth_picture(channel(read_exr(path), "Z", path))
    yield "depth.png", grey_png(steps)
    yield "instances.png", whole_png(view.folder / layout.INSTANCES)
    yield "geometry.exr", read_bytes(path)
    yield "geometry.json", compact_json({"depth_step_mm": scale}).encode()


def _labels(job: Job, objects: ObjectsFile, view: StoredView) -> Members:
    records = {record.id: record for record in objects.objects}
    labels = chosen_labels(view.labels(), chosen_ids(job, objects), view)
    yield "labels.json", compact_json({"objects": [_object(label, records[label.id]) for label in labels]}).encode()


def _camera(camera: Camera, scene_id: int, view: int) -> dict[str, Any]:
    fields = {"scene": scene_id, "view": view, "K": camera.K.tolist()}
    for name in ("world_T_camera", "world_T_right"):
        fields[name] = [[float(value) for value in row] for row in getattr(camera, name)]
    return fields | {name: getattr(camera, name) for name in ("width", "height", "baseline", "exposure", "grid_index")}


def _object(label: ObjectLabel, record: ObjectRecord) -> dict[str, Any]:
    pose = [[float(value) for value in row] for row in label.camera_T_object]
    fractions = dict.fromkeys(("visible", "seen_through", "occluded"))
    fractions |= label.fractions.model_dump() if label.fractions is not None else {}
    return {
        "id": label.id,
        "name": label.name,
        "category": label.category,
        "vessel": record.material.kind == "glass",
        "size": list(record.size),
        "camera_T_object": pose,
        "box_modal": label.box2d.modal,
        "box_amodal": label.box2d.amodal,
        "mask_size": list(label.mask_seen.size),
        "mask_amodal": label.mask_amodal.counts,
        "mask_seen": label.mask_seen.counts,
        "visible_pixels": label.pixels.visible,
        "keypoints": [_keypoint(point.pixel, point.Z, point.state) for point in label.keypoints],
    } | {f"{name}_fraction": value for name, value in fractions.items()}


def _keypoint(pixel: tuple[float, float] | None, Z: float, state: str) -> dict[str, Any]:
    u, v = pixel if pixel is not None else (None, None)
    return {"u": u, "v": v, "Z": Z, "state": state}
