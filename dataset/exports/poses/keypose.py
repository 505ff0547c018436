"""KeyPose's layout: stereo pictures with keypoints in the text form of protobuf, a sequence for each vessel of a scene.

::

    train/bottle/texture_12_pose_3/        scene 12, object 3; val/ and test/ for scenes of these splits
        000004_L.png  000004_R.png         view 4
        000004_L.pbtxt  000004_R.pbtxt     camera, pose and keypoints, and the same keypoints in other views
        000004_mask.png  000004_border.png
        000004_Do.exr  000004_Dt.exr       depth of the first surface; the sensor's, where the data set has it
        data_params.pbtxt
    train/objects/bottle_12_3.obj          vertices and keypoints
    scenes/000012.json                     the sequences of scene 12

(Liu et al., *KeyPose*, CVPR 2020; google-research, keypose/README.md and data.proto.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ....annotate.projection import transformed
from ....core.atomic_io import atomic_file, atomic_folder, write_atomically
from ....core.json_file import json_text
from ....core.mesh import Mesh
from ....procedural.description.camera import Camera
from ....procedural.scene.splits import Split
from ....render.frame import EYES, Geometry
from ...format import layout
from ...format.exr import write_exr
from ...format.objects_file import ObjectRecord
from ...reader import StoredScene, StoredView
from ..depth import known_depth
from ..files import add_picture, plain_name, write_grey_png
from ..job import Exporter, Job, chosen_ids, vessel_ids, write_nothing
from ..sensor import sensor_depth
from .keypose_text import data_params, key_targets, target
from .models import model_mesh

#: Views in which a file has the keypoints, its own first: as many as KeyPose's records keep (`MAX_TARGET_FRAMES`).
TARGETS = 5
#: Most keypoints of an object: as KeyPose's own have, and as many as its `show_keypoints` has colours for.
MOST_KEYPOINTS = 4
#: Most vertices in an object's file: KeyPose draws 300 of them, and searches all for each.
_VERTICES = 2000


@dataclass(frozen=True, eq=False)
class SeenView:
    """A view of a scene, read once for all its objects."""

    view: StoredView
    camera: Camera
    geometry: Geometry


def place(job: Job, scene: StoredScene) -> Path:
    """Return the list of a scene's sequences, which is written last."""
    return job.out / "scenes" / f"{layout.scene_name(scene.scene_id)}.json"


def write(job: Job, scene: StoredScene) -> None:
    """Write a sequence for each vessel that a view shows, then their list."""
    objects, split = scene.objects(), job.split_of(scene.scene_id)
    ids = [number for number in chosen_ids(job, objects) if number in vessel_ids(objects)]
    views = [SeenView(view, view.camera(), view.geometry()) for view in scene.views]
    meshes = {item.id: model_mesh(item) for item in scene.scene().objects if item.id in ids}
    sequences = []
    for record in (record for record in objects.objects if record.id in ids):
        shown = [one for one in views if (one.geometry.id == record.id).any()]
        if not shown:
            continue
        name = plain_name(record.category)
        path = Path(split, name, f"texture_{scene.scene_id}_pose_{record.id}")
        (job.out / path.parent).mkdir(parents=True, exist_ok=True)
        with atomic_folder(job.out / path) as folder:
            _write_sequence(job, folder, record, shown, views)
        _write_object(job, split, f"{name}_{scene.scene_id}_{record.id}", meshes[record.id], record)
        sequences.append(path.as_posix())
    write_atomically(place(job, scene), json_text({"sequences": sequences}).encode())


EXPORTER = Exporter(
    purpose="KeyPose: stereo keypoints of vessels",
    place=place,
    write=write,
    finish=write_nothing,
    labels=("masks", "depth"),
)


def keypoints_of(record: ObjectRecord) -> np.ndarray:
    """Return the keypoints of an object as KeyPose chooses them, (n, 3) float64, object frame [m].

    Of a ball its centre; of another solid of revolution the ends of its axis, top first, as of KeyPose's cups and
    bottles; of everything else the first four of our keypoints, which are spread over its surface.
    """
    axes = len(record.symmetries_continuous)
    if axes > 1:
        return np.zeros((1, 3))
    if axes == 1:
        half = 0.5 * record.size[2]
        return np.array([[0.0, 0.0, half], [0.0, 0.0, -half]])
    return np.array(record.keypoints)[:MOST_KEYPOINTS]


def _write_sequence(
    job: Job, folder: Path, record: ObjectRecord, shown: Sequence[SeenView], views: Sequence[SeenView]
) -> None:
    keypoints = transformed(np.asarray(record.world_T_object), keypoints_of(record))
    (folder / "data_params.pbtxt").write_text(data_params(shown[0].camera, len(keypoints)), "ascii")
    for one in shown:
        stem, place = f"{one.view.number:06d}", views.index(one)
        near = [views[(place + step) % len(views)] for step in range(min(TARGETS, len(views)))]
        for eye, letter in zip(EYES, "LR", strict=True):
            add_picture(job, one.view.folder / f"{eye}.png", folder / f"{stem}_{letter}.png")
            others = [target(other.camera, eye, keypoints) for other in near]
            text = key_targets(others[0], others)
            (folder / f"{stem}_{letter}.pbtxt").write_text(text, "ascii")
        mask = (one.geometry.id == record.id).astype(np.uint8)
        if job.has("masks"):
            write_grey_png(folder / f"{stem}_mask.png", mask == 1)
            # The pixels around the mask, as KeyPose's own tool finds them (`MeshObj.segmentation`).
            write_grey_png(folder / f"{stem}_border.png", cv2.dilate(mask, np.ones((3, 3), np.uint8)) > mask)
        if job.has("depth"):
            _write_depth(one, folder, stem)


def _write_depth(one: SeenView, folder: Path, stem: str) -> None:
    write_exr(folder / f"{stem}_Do.exr", {"D": known_depth(one.geometry.Z)})
    sensed = sensor_depth(one.view)
    if sensed is not None:
        write_exr(folder / f"{stem}_Dt.exr", {"D": sensed})


def _write_object(job: Job, split: Split, name: str, mesh: Mesh, record: ObjectRecord) -> None:
    """Write an object's vertices and keypoints as KeyPose reads them: OBJ files without faces."""
    vertices = mesh.vertices[:: max(1, -(-len(mesh.vertices) // _VERTICES))]
    lines = ["o mesh", *_points(vertices)]
    for number, point in enumerate(keypoints_of(record)):
        lines += [f"o kp.{number:03d}", *_points(point[None])]
    folder = job.out / split / "objects"
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(folder / f"{name}.obj") as partial:
        partial.write_text("\n".join(lines) + "\n", "ascii")


def _points(points: np.ndarray) -> list[str]:
    return [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
