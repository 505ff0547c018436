"""Visualisation of detections, depth, classes and heatmaps."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
import torch
from torch import Tensor

from ...annotate.boxes import EDGES
from ...annotate.projection import project_camera
from ..decoding.decode import Detections, decode
from ..networks.settings import NetworkSettings
from ..targets.encoding import encoding_of
from ..targets.objects import box_points
from .samples import Batch

#: Colours of the classes (background, table, transparent, opaque, one more of SimNet), and of objects in turn, sRGB.
_CLASSES = np.array([[30, 30, 40], [120, 100, 80], [80, 180, 255], [255, 160, 60], [255, 0, 0]], np.uint8)
_OBJECTS = ((255, 80, 80), (80, 220, 80), (90, 140, 255), (255, 210, 60), (220, 90, 255), (60, 220, 220))


def sample_picture(batch: Batch, outputs: Mapping[str, Tensor], settings: NetworkSettings) -> np.ndarray:
    """Return the first sample of a batch as an image, predictions above targets, (2 H, 4 W, 3) uint8.

    From left to right: the reference image with detections, depth, classes, heatmap. Of networks that see one object,
    its window with keypoints, or with points of its surface.
    """
    if settings.name in ("keypose", "densefusion"):
        return _object_picture(batch, outputs)
    first = {name: value[:1].detach().float().cpu() for name, value in outputs.items() if value.ndim > 2}
    (found,) = decode(first, batch.K[:1, 0].detach().double().cpu(), encoding_of(settings))
    picture = rgb(batch.images[0, 0])
    true = {name: value[0].detach().cpu().numpy() for name, value in batch.targets.items()}
    limits = depth_limits(true["depth"])
    top = [with_boxes(picture, found, batch.K[0, 0].cpu().numpy()), coloured_depth(first["depth"][0].numpy(), limits)]
    top += [_CLASSES[first["seg"][0].argmax(0).numpy()], _grey(first["heatmap"][0].numpy())]
    bottom = [picture, coloured_depth(true["depth"], limits), _CLASSES[true["seg"]], _grey(true["heatmap"])]
    return np.concatenate([np.concatenate(top, axis=1), np.concatenate(bottom, axis=1)], axis=0)


def _object_picture(batch: Batch, outputs: Mapping[str, Tensor]) -> np.ndarray:
    targets = {name: value[0].detach().cpu().numpy() for name, value in batch.targets.items()}
    found = {name: value[0].detach().float().cpu().numpy() for name, value in outputs.items()}
    picture = rgb(batch.images[0, 0])
    if "keypoints" in found:
        shown = (found["keypoints"][:, :2], targets["keypoints"][0, :, :2])
        return np.concatenate([_with_dots(picture, points) for points in shown], axis=0)
    # The window's pixels of the points are known, and what lies between them is nearly linear over an object.
    rows, columns = np.divmod(targets["pixels"], picture.shape[1])
    cloud = targets["cloud"]
    directions = np.stack([cloud[:, 0] / cloud[:, 2], cloud[:, 1] / cloud[:, 2], np.ones(len(cloud))], axis=1)
    to_window = np.linalg.lstsq(directions, np.stack([columns, rows], axis=1), rcond=None)[0]
    drawn = []
    for pose in (found["pose"], targets["pose"]):
        points = targets["model"] @ pose[:3, :3].T + pose[:3, 3]
        rays = np.stack([points[:, 0] / points[:, 2], points[:, 1] / points[:, 2], np.ones(len(points))], axis=1)
        drawn.append(_with_dots(picture, rays @ to_window, radius=0))
    return np.concatenate(drawn, axis=0)


def _with_dots(picture: np.ndarray, points: np.ndarray, radius: int = 2) -> np.ndarray:
    drawn = picture.copy()
    for number, (x, y) in enumerate(points):
        if max(abs(x), abs(y)) < 1e4:
            cv2.circle(drawn, (round(float(x)), round(float(y))), radius, _OBJECTS[number % len(_OBJECTS)], -1)
    return drawn


def rgb(image: Tensor) -> np.ndarray:
    """Return an image in [0, 1], (3, H, W), as (H, W, 3) uint8."""
    return (image.detach().cpu().clamp(0.0, 1.0) * 255.0).round().to(torch.uint8).movedim(0, -1).contiguous().numpy()


def depth_limits(depth: np.ndarray) -> tuple[float, float]:
    """Return the least and the greatest known depth [m]; they differ by 1 mm or more."""
    known = depth[(depth > 0.0) & np.isfinite(depth)]
    if not known.size:
        return 0.0, 1.0
    return float(known.min()), max(float(known.max()), float(known.min()) + 1e-3)


def coloured_depth(depth: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Return depth in false colours (turbo, near is red), (H, W, 3) uint8; black where it is unknown."""
    near, far = limits
    nearness = np.clip((far - depth) / (far - near), 0.0, 1.0)
    colours = cv2.applyColorMap((np.nan_to_num(nearness) * 255.0).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1]
    return np.where(((depth > 0.0) & np.isfinite(depth))[..., None], colours, 0).astype(np.uint8)


def with_boxes(picture: np.ndarray, found: Detections, K: np.ndarray) -> np.ndarray:
    """Return an image with the boxes and masks of detections, (H, W, 3) uint8."""
    drawn = picture.copy()
    for index in range(len(found)):
        colour = _OBJECTS[index % len(_OBJECTS)]
        mask = found.mask[index].cpu().numpy()
        drawn[mask] = (0.6 * drawn[mask] + 0.4 * np.array(colour)).astype(np.uint8)
        corners = box_points(found.camera_T_object[index].cpu().numpy(), found.size[index].cpu().numpy())
        pixels, Z = project_camera(corners, np.asarray(K, np.float64))
        if (Z > 0.0).all() and np.abs(pixels).max() < 1e6:
            ends = np.rint(pixels).astype(int).tolist()
            for a, b in EDGES:
                cv2.line(drawn, ends[a], ends[b], colour, 1, cv2.LINE_AA)
    return drawn


def _grey(heat: np.ndarray) -> np.ndarray:
    return np.repeat((np.clip(heat, 0.0, 1.0) * 255.0).astype(np.uint8)[..., None], 3, axis=-1)
