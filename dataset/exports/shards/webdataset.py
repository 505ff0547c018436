"""WebDataset shards with the card of a data set on the Hugging Face Hub.

::

    README.md                    the card of a data set on the Hugging Face Hub
    croissant.json               the same for programs, in MLCommons' Croissant 1.0
    SHA256SUMS                   digests of all shards, for `sha256sum --check`
    pictures/train-000000.tar    a shard for each scene; val- and test- for scenes of these splits
    geometry/train-000000.tar
    sensor/train-000000.tar      of data sets with a depth camera
    polarisation/train-000000.tar    of data sets with a polarisation camera
    labels/train-000000.tar

A sample is a view; its key, such as ``000000_003``, is the same in all configurations.
(github.com/webdataset/webdataset; huggingface.co/docs/datasets, "Structure your repository", "WebDataset".)
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ....annotate.labels import ObjectLabel
from ....core.atomic_io import write_atomically
from ....core.json_file import json_text
from ....procedural.description.camera import Camera
from ...format import layout
from ...format.exr import channel, read_exr
from ...format.objects_file import ObjectRecord, ObjectsFile
from ...reader import StoredScene, StoredView
from ..depth import depth_picture
from ..files import compact_json, grey_png, read_bytes, whole_png
from ..job import Exporter, Job, chosen_ids, chosen_labels
from ..tar_files import write_tar
from .card import CONFIGS, card, columns
from .croissant import croissant
from .features import Kind
from .sensors import sensor_members

#: Members of a sample by their endings.
Members = Iterator[tuple[str, bytes]]


def place(job: Job, scene: StoredScene) -> Path:
    """Return the shard of a scene that is written last."""
    return _shard(job, scene, list(columns(job))[-1])


def write(job: Job, scene: StoredScene) -> None:
    """Write the shards of a scene, one for each configuration."""
    objects = scene.objects()
    writers: dict[str, Callable[[StoredView], Members]] = {
        "pictures": partial(_pictures, job, scene),
        "geometry": _geometry,
        "labels": partial(_labels, job, objects),
    }
    for config, kinds in columns(job).items():
        members = writers.get(config) or partial(sensor_members, config, own_members(kinds))
        shard = _shard(job, scene, config)
        shard.parent.mkdir(exist_ok=True)
        write_tar(shard, ((key_of(scene, view), members(view)) for view in scene.views))


def own_members(kinds: dict[str, Kind]) -> list[str]:
    """Return the columns that are members of a sample: its key and address are not."""
    return [name for name in kinds if not name.startswith("__")]


def key_of(scene: StoredScene, view: StoredView) -> str:
    """Return the key of a sample."""
    return f"{layout.scene_name(scene.scene_id)}_{layout.view_name(view.number)}"


def finish(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write the card, the description in Croissant, and the digests of all shards."""
    splits = job.splits(scenes)
    digests = {path.relative_to(job.out).as_posix(): _digest(path) for path in _shards(job, scenes)}
    write_atomically(job.out / "README.md", card(job, splits, scenes).encode())
    write_atomically(job.out / "croissant.json", json_text(croissant(job, digests)).encode())
    write_atomically(job.out / "SHA256SUMS", "".join(f"{digests[name]}  {name}\n" for name in digests).encode())


EXPORTER = Exporter(
    purpose="tar shards with a Hugging Face card, for streaming",
    place=place,
    write=write,
    finish=finish,
    eyes=True,
    labels=CONFIGS,
)


def _shards(job: Job, scenes: Sequence[StoredScene]) -> Iterator[Path]:
    for config in columns(job):
        for scene in scenes:
            yield _shard(job, scene, config)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


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
