"""nerfstudio's ``transforms.json`` with depth and masks, and a COLMAP text model beside it.

::

    000000/transforms.json  transforms_objects.json     the second has masks of the objects
    000000/images/left_000.png  depths/left_000.png  masks/left_000.png
    000000/sparse_pc.ply
    000000/sparse/0/cameras.txt  images.txt  points3D.txt

Both count pixels from the corner: the centre of the first is at 0.5, so cx and cy are half a pixel more than ours.
nerfstudio's cameras have OpenGL axes (x right, y up, z back), COLMAP's OpenCV's.
(docs.nerf.studio, "Data conventions"; colmap.github.io, "Output format".)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ....annotate.projection import inverse_pose
from ....core.atomic_io import atomic_folder
from ....core.json_file import json_text
from ....procedural.description.camera import Camera
from ...format import layout
from ...reader import StoredScene, StoredView
from ..files import add_picture, write_grey_png
from ..job import Exporter, Job, chosen_ids, write_nothing
from .points import Cloud, cloud_of, joined_clouds, thinned, write_cloud

#: From the centre of the first pixel at 0 to 0.5.
HALF_PIXEL = 0.5
#: From OpenGL's camera axes to OpenCV's: y and z turned round.
CV_T_GL = np.diag([1.0, -1.0, -1.0, 1.0])
#: nerfstudio's unit of depth (`depth_unit_scale_factor` 1e-3) [steps per metre].
DEPTH_STEPS = 1000.0
#: What can be left out.
LABELS = ("depths", "masks")
#: Every eighth picture is held out for validation and test, as for LLFF data (Mildenhall et al., ECCV 2020).
HELD_OUT = 8
#: Most points of the sparse cloud: splats are grown from them, and COLMAP finds some ten thousand in a scene.
SPARSE_POINTS = 50_000


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a scene."""

    name: str
    camera: Camera
    world_T_camera: np.ndarray  #: (4, 4), OpenCV axes
    held_out: bool


def place(job: Job, scene: StoredScene) -> Path:
    """Return the folder of a scene."""
    return job.out / layout.scene_name(scene.scene_id)


def write(job: Job, scene: StoredScene) -> None:
    """Write the folder of a scene."""
    labels = tuple(filter(job.has, LABELS)) if job.options.eye == "left" else ()
    ids = chosen_ids(job, scene.objects())
    pictures: list[Picture] = []
    clouds: list[Cloud] = []
    each = max(1, SPARSE_POINTS // max(1, len(scene.views)))
    with atomic_folder(place(job, scene)) as folder:
        for name in ("images", *labels):
            (folder / name).mkdir()
        for number, view in enumerate(scene.views):
            pictures += _pictures(job, view, folder, number % HELD_OUT == 0 and len(scene.views) >= HELD_OUT)
            clouds.append(thinned(cloud_of(view), each))
            _write_labels(view, ids, folder, pictures[-1].name, labels)
        cloud = joined_clouds(clouds)
        write_cloud(folder / "sparse_pc.ply", cloud)
        _write_text(folder / "transforms.json", json_text(transforms(pictures, "depths" in labels, masks=False)))
        if "masks" in labels:
            _write_text(
                folder / "transforms_objects.json", json_text(transforms(pictures, "depths" in labels, masks=True))
            )
        (folder / "sparse" / "0").mkdir(parents=True)
        for name, lines in (("cameras", _cameras(pictures)), ("images", _images(pictures)), ("points3D", _rows(cloud))):
            _write_text(folder / "sparse" / "0" / f"{name}.txt", "".join(f"{line}\n" for line in lines))


EXPORTER = Exporter(
    purpose="nerfstudio and COLMAP: radiance fields and splats",
    place=place,
    write=write,
    finish=write_nothing,
    eyes=True,
    labels=LABELS,
)


def transforms(pictures: Sequence[Picture], depth: bool, masks: bool) -> dict[str, Any]:
    """Return the content of ``transforms.json``; names are relative to its folder.

    Parameters
    ----------
    pictures : sequence of Picture
        In the order of their names, by which nerfstudio sorts them.
    depth, masks : bool
        Whether there are depth pictures and masks for all of them.
    """
    files = {"file_path": "images"} | ({"depth_file_path": "depths"} if depth else {})
    files |= {"mask_path": "masks"} if masks else {}
    pictures = sorted(pictures, key=lambda picture: picture.name)
    frames = [
        {key: f"{folder}/{picture.name}" for key, folder in files.items()}
        | _intrinsics(picture.camera)
        | {"transform_matrix": (picture.world_T_camera @ CV_T_GL).tolist()}
        for picture in pictures
    ]
    record: dict[str, Any] = {
        "camera_model": "PINHOLE",
        # The world as it is, z up: nothing is turned.
        "orientation_override": "none",
        "ply_file_path": "sparse_pc.ply",
        "frames": frames,
    }
    held = [f"images/{picture.name}" for picture in pictures if picture.held_out]
    if held:  # all three or none
        others = [f"images/{picture.name}" for picture in pictures if not picture.held_out]
        record |= {"train_filenames": others, "val_filenames": held, "test_filenames": held}
    return record


def _intrinsics(camera: Camera) -> dict[str, float]:
    cx, cy = camera.centre
    return {
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": cx + HALF_PIXEL,
        "cy": cy + HALF_PIXEL,
        "w": camera.width,
        "h": camera.height,
    }


def _pictures(job: Job, view: StoredView, folder: Path, held_out: bool) -> Iterator[Picture]:
    camera = view.camera()
    poses = {"left": camera.world_T_camera, "right": camera.world_T_right}
    for eye in job.eyes():
        name = f"{eye}_{layout.view_name(view.number)}.png"
        add_picture(job, view.folder / f"{eye}.png", folder / "images" / name)
        yield Picture(name, camera, np.array(poses[eye]), held_out)


def _write_labels(view: StoredView, ids: Sequence[int], folder: Path, name: str, labels: Sequence[str]) -> None:
    geometry = view.geometry()
    if "depths" in labels:
        steps = np.rint(np.where(np.isfinite(geometry.Z), geometry.Z, 0.0).astype(np.float64) * DEPTH_STEPS)
        write_grey_png(folder / "depths" / name, np.where(steps < 1 << 16, steps, 0).astype(np.uint16))
    if "masks" in labels:
        write_grey_png(folder / "masks" / name, np.isin(geometry.id, ids))


def _cameras(pictures: Sequence[Picture]) -> Iterator[str]:
    yield "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[] (fx, fy, cx, cy)"
    for number, picture in enumerate(pictures, start=1):
        values = _intrinsics(picture.camera)
        numbers = " ".join(repr(float(values[name])) for name in ("fl_x", "fl_y", "cx", "cy"))
        yield f"{number} PINHOLE {picture.camera.width} {picture.camera.height} {numbers}"


def _images(pictures: Sequence[Picture]) -> Iterator[str]:
    yield "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; an empty line for no 2D points"
    for number, picture in enumerate(pictures, start=1):
        camera_T_world = inverse_pose(picture.world_T_camera)
        x, y, z, w = Rotation.from_matrix(camera_T_world[:3, :3]).as_quat().tolist()
        numbers = " ".join(map(repr, (w, x, y, z, *camera_T_world[:3, 3].tolist())))
        yield f"{number} {numbers} {number} {picture.name}\n"


def _rows(cloud: Cloud) -> Iterator[str]:
    yield "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]"
    rows = zip(cloud.points.tolist(), cloud.colours.tolist(), strict=True)
    for number, (point, colour) in enumerate(rows, start=1):
        yield f"{number} {' '.join(map(repr, point))} {' '.join(map(str, colour))} 0"


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, "utf-8")
