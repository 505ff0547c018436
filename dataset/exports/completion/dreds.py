"""DREDS' layout for depth restoration, as SwinDRNet's loader reads it.

::

    train/00012/                       val/ and test/ for scenes of these splits
        0004_color.png                 view 4, the left picture
        0004_depth_120.exr             depth of the first surface
        0004_simDepthImage.exr         the sensor's depth
        0004_coord.png                 object coordinates (NOCS)
        0004_mask.exr                  instances
        0004_meta.txt                  a line for each instance: class, scale, material, pose

(Dai et al., *Domain Randomization-Enhanced Depth Simulation and Restoration*, ECCV 2022; PKU-EPIC/DREDS:
SwinDRNet/datasets/datasets.py, which reads these files, and DepthSensorSimulator/renderer.py, which writes them.)
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ....annotate.coordinates import box_diagonal, object_coordinates
from ....annotate.labels import ObjectLabel
from ....core.atomic_io import atomic_folder
from ....core.errors import InputError
from ...format.exr import write_exr
from ...format.objects_file import ObjectRecord
from ...format.pictures import write_png
from ...reader import StoredScene, StoredView
from ..depth import known_depth
from ..files import add_picture, plain_name
from ..job import Exporter, Job, chosen_ids, chosen_labels, write_nothing

#: Value of the background in the mask, which has 8 bits in the original.
BACKGROUND = 255
#: DREDS' numbers of classes; everything else is 0, other.
CLASSES = {"bottle": 1, "bowl": 2, "camera": 3, "can": 4, "car": 5, "mug": 6, "aeroplane": 7}
#: DREDS' numbers of materials.
DIFFUSE, TRANSPARENT, SPECULAR = 1, 2, 3
#: Metalness from which an opaque object is specular [1], and roughness up to which [1]: polished, as its porcelain.
_METALLIC, _POLISHED = 0.5, 0.2
#: From our object axes, z up, to those of DREDS' models, y up.
DREDS_T_OBJECT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / job.split_of(scene.scene_id) / f"{scene.scene_id:05d}"


def write(job: Job, scene: StoredScene) -> None:
    """Write the folder of a scene."""
    objects = scene.objects()
    ids = chosen_ids(job, objects)
    records = {record.id: record for record in objects.objects}
    if len(ids) >= BACKGROUND:
        raise InputError(scene.folder, f"fewer than {BACKGROUND} objects, as DREDS' masks hold them", len(ids))
    with atomic_folder(place(job, scene)) as folder:
        for view in scene.views:
            _write_view(job, view, [records[number] for number in ids], folder)


EXPORTER = Exporter(
    purpose="DREDS: depth restoration with a sensor's depth",
    place=place,
    write=write,
    finish=write_nothing,
)


def _write_view(job: Job, view: StoredView, records: Sequence[ObjectRecord], folder: Path) -> None:
    camera, geometry, stem = view.camera(), view.geometry(), f"{view.number:04d}"
    labels = list(chosen_labels(view.labels(), [record.id for record in records], view))
    sensed = known_depth(view.sensor_depth())  # which a data set without a depth camera does not have
    add_picture(job, view.folder / "left.png", folder / f"{stem}_color.png")
    for name, depth in (("depth_120", known_depth(geometry.Z)), ("simDepthImage", sensed)):
        write_exr(folder / f"{stem}_{name}.exr", dict.fromkeys("RGB", depth))
    coordinates = object_coordinates(geometry.Z, geometry.id, labels, camera.K)
    write_png(folder / f"{stem}_coord.png", coordinate_picture(coordinates))
    mask = np.full(geometry.id.shape, BACKGROUND)
    for number, label in enumerate(labels, start=1):
        mask[geometry.id == label.id] = number
    write_exr(folder / f"{stem}_mask.exr", dict.fromkeys("RGB", mask_values(mask)))
    lines = [meta_line(number, *pair) for number, pair in enumerate(zip(labels, records, strict=True), start=1)]
    (folder / f"{stem}_meta.txt").write_text("".join(f"{line}\n" for line in lines), "utf-8")


def coordinate_picture(coordinates: np.ndarray) -> np.ndarray:
    """Return object coordinates as colours, (H, W, 3) uint8; black for none.

    DREDS colours by x, y and 1 - z of models that are y up. In our axes, z up, that is x, z and y.
    """
    colours = np.nan_to_num(coordinates[..., [0, 2, 1]], nan=0.0).clip(0.0, 1.0)
    return np.rint(255.0 * colours).astype(np.uint8)


def mask_values(mask: np.ndarray) -> np.ndarray:
    """Return instance numbers as fractions of 255, float32.

    The loader multiplies by 255 and cuts off the rest, so that 255 x / 255 must not come out below x: the next larger
    number is taken where it would.
    """
    values = (mask / 255.0).astype(np.float32)
    short = (values * np.float32(255.0)).astype(np.int32) < mask
    return np.where(short, np.nextafter(values, np.float32(2.0)), values)


def meta_line(number: int, label: ObjectLabel, record: ObjectRecord) -> str:
    """Return the line of an instance: number, class, two names, scale, material, quaternion, translation.

    The scale is the length of the box's diagonal [m]; the quaternion, w first, turns the camera's axes to the model's,
    which is the inverse of a pose's rotation; the translation is the model's middle in the camera's frame [m].
    """
    rotation = np.array(label.camera_T_object)[:3, :3] @ DREDS_T_OBJECT[:3, :3].T
    x, y, z, w = Rotation.from_matrix(rotation.T).as_quat().tolist()
    numbers = [w, x, y, z, *np.array(label.camera_T_object)[:3, 3].tolist()]
    words = [str(number), str(CLASSES.get(label.category, 0)), plain_name(label.category), plain_name(label.name)]
    words += [repr(box_diagonal(label)), str(material_number(record)), *map(repr, numbers)]
    return " ".join(words)


def material_number(record: ObjectRecord) -> int:
    """Return DREDS' number of an object's material: transparent, specular or diffuse."""
    material = record.material
    if material.kind == "glass":
        return TRANSPARENT
    return SPECULAR if material.metallic > _METALLIC or material.roughness < _POLISHED else DIFFUSE
