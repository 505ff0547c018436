"""Prediction: a trained network on images of your own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from ...annotate.masks import encode_mask
from ...core.atomic_io import write_atomically
from ...core.errors import InputError, cause_of
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.setting_errors import shortened
from ...core.silence import quiet
from ...dataset.format import layout
from ...dataset.format.camera_file import CAMERA_SCHEMA, CameraFile, known_K
from ...dataset.format.exr import write_exr
from ...dataset.format.pictures import write_png
from ..data.samples import image_tensor
from ..data.scaling import Fit, fitted, restored, restored_points, scaled_view
from ..data.views import MAX_VALUE, CameraView, check_camera, check_picture, check_sizes
from ..data.visualise import coloured_depth, depth_limits, with_boxes
from ..decoding.decode import Detections, decode
from ..targets.encoding import encoding_of
from ..training.checkpoint import load_network
from ..training.out_folder import make_out_folder
from .camera_checks import check_cameras, check_rectified
from .score import check_finite, eval_mode

#: What a network finds: it does not tell families of vessels apart, nor vessels from opaque props.
CATEGORY = "object"


@dataclass(frozen=True, eq=False)
class Prediction:
    """Depth and objects that a network predicts for a reference image."""

    depth: np.ndarray  #: (H, W) float32 [m], at the size of the image
    objects: Detections


def predict(
    checkpoint: Path, images: Sequence[Path], out: Path, device: str = "cpu", trust_cameras: bool = False
) -> Prediction:
    """Predict objects and depth of the first of several images of one scene, and write them.

    ``prediction.png`` is the image with boxes and masks, beside its depth; ``prediction.json`` has the objects,
    with masks as run lengths, and ``depth.exr`` the depth as channel Z [m].

    Parameters
    ----------
    checkpoint : Path
        A checkpoint of ours, or of the released code.
    images : sequence of Path
        Two images or more, each with its camera (`read_image_and_camera`); the first is the reference.
    out : Path
        Output folder.
    device : str
        Torch's name of the device.
    trust_cameras : bool
        Whether to take suspicious cameras too (`camera_checks`).

    Raises
    ------
    InputError
        Where an image is missing, or cannot be used, or has no camera, or the cameras are suspicious.
    """
    if len(images) < 2:
        raise InputError("pictures", "two or more views of one scene", len(images))
    network, settings = load_network(checkpoint)
    name = settings.network.name
    if name not in ("mvtrans", "simnet"):
        raise InputError(checkpoint, "a network that finds objects (mvtrans, simnet)", name)
    make_out_folder(out)
    stored = [read_image_and_camera(path) for path in images]
    if not trust_cameras:
        check_cameras(stored, images)
    if name == "simnet":
        check_rectified(stored, images)
    views = [scaled_view(view, settings.views.size, settings.views.fit) for view in stored]
    check_sizes(views, images[0])
    for view, path in zip(views, images, strict=True):
        check_picture(view.picture, path)
    encoding = encoding_of(settings.network)
    pictures = image_tensor(np.stack([view.picture for view in views]), encoding)[None]
    poses = torch.from_numpy(np.stack([view.world_T_camera for view in views])).float()[None]
    K = torch.from_numpy(np.stack([view.K for view in views])).float()[None]
    with torch.inference_mode():
        outputs = eval_mode(network.to(device))(pictures.to(device), poses.to(device), K.to(device))
    fields = {name: value.float().cpu() for name, value in outputs.items()}
    check_finite(fields, str(images[0]))
    (found,) = decode(fields, K[:, 0].double(), encoding)
    first = stored[0]
    fit = fitted((first.picture.shape[0], first.picture.shape[1]), settings.views.size, settings.views.fit)
    prediction = Prediction(restored(fields["depth"][0].numpy(), fit), _restored(found, fit))
    _write(prediction, first.picture, first.K, images, out)
    return prediction


def _restored(found: Detections, fit: Fit) -> Detections:
    """Return detections with masks and peaks in the pixels of the stored picture."""
    mask = torch.from_numpy(restored(found.mask.cpu().numpy(), fit))
    peak = torch.from_numpy(restored_points(found.peak.cpu().numpy(), fit))
    return replace(found, mask=mask, peak=peak)


def read_image_and_camera(path: Path) -> CameraView:
    """Read an image, PNG or JPEG, and its camera.

    The camera is in a JSON file with the name of the image (``a.png``: ``a.json``) with ``K`` and ``world_T_camera`` as
    in ``camera.json``, or in the ``camera.json`` of the same folder, whose right camera belongs to ``right.png``.
    """
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, "a readable picture", cause_of(error)) from error
    # Cameras refer to pixels as stored, so the orientation tag of a JPEG is ignored.
    how = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        with quiet():
            picture = cv2.imdecode(data, how) if data.size else None
    except cv2.error as error:
        raise InputError(path, "a PNG or JPEG picture", "one of too many pixels") from error
    if picture is None:
        raise InputError(path, "a PNG or JPEG picture", "something else")
    picture = np.ascontiguousarray(picture[..., ::-1])
    camera = path.with_suffix(".json")
    return _with_own_camera(picture, camera) if camera.is_file() else _with_stored_camera(picture, path)


def _with_own_camera(picture: np.ndarray, path: Path) -> CameraView:
    record = read_json(path)
    matrices = []
    for name, shape in (("K", (3, 3)), ("world_T_camera", (4, 4))):
        value = record.get(name) if isinstance(record, dict) else None
        if not _is_matrix(value, shape):
            raise InputError(f"{path}: {name}", f"{shape[0]} rows of {shape[1]} finite numbers", shortened(value))
        matrices.append(np.array(value, np.float64))
    K, pose = matrices
    check_camera(K, pose, path)
    return CameraView(picture, pose, K)


def _is_matrix(value: Any, shape: tuple[int, int]) -> bool:
    rows, columns = shape
    return (
        isinstance(value, list)
        and [len(row) if isinstance(row, list) else -1 for row in value] == [columns] * rows
        and all(type(number) in (int, float) and abs(number) < MAX_VALUE for row in value for number in row)
    )


def _with_stored_camera(picture: np.ndarray, path: Path) -> CameraView:
    camera = path.with_name(layout.CAMERA)
    if not camera.is_file():
        raise InputError(path, f"its camera in {path.with_suffix('.json').name} or {layout.CAMERA}", "neither")
    data = read_json(camera)
    check_schema(camera, data, CAMERA_SCHEMA)
    record = parsed(CameraFile, data, camera)
    if picture.shape[:2] != (record.height, record.width):
        raise InputError(path, f"a picture of {record.height} x {record.width} px", picture.shape[:2])
    pose = record.world_T_right if path.stem == "right" else record.world_T_camera
    if pose is None:
        raise InputError(f"{camera}: world_T_right", "the pose of the right camera", "null")
    K = np.array(known_K(record, camera))
    check_camera(K, pose, camera)
    return CameraView(picture, pose, K)


def _write(found: Prediction, picture: np.ndarray, K: np.ndarray, images: Sequence[Path], out: Path) -> None:
    depth = coloured_depth(found.depth, depth_limits(found.depth))
    write_png(out / "prediction.png", np.concatenate([with_boxes(picture, found.objects, K), depth], axis=1))
    write_exr(out / "depth.exr", {"Z": found.depth})
    record = {"images": [str(path) for path in images], "objects": _object_records(found.objects)}
    write_atomically(out / "prediction.json", json_text(record).encode())


def _object_records(found: Detections) -> list[dict[str, Any]]:
    masks = [found.mask[index].cpu().numpy() for index in range(len(found))]
    return [
        {
            "category": CATEGORY,
            "score": float(found.score[index]),
            "peak": found.peak[index].tolist(),
            "camera_T_object": found.camera_T_object[index].tolist(),
            "size": found.size[index].tolist(),
            "pixels": int(mask.sum()),
            # As in labels.json; pycocotools.mask.decode takes it as it is.
            "mask": {"size": list(mask.shape), "counts": encode_mask(mask)},
        }
        for index, mask in enumerate(masks)
    ]
