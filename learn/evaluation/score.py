"""Scores of one sample: predictions compared with ground labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from ...core.errors import InputError
from ..data.ground_truth import GroundTruth
from ..decoding.decode import Detections, decode
from ..metrics.box_iou import object_iou
from ..metrics.depth import DepthErrors, cleargrasp_errors, depth_errors
from ..metrics.detection import ImageOverlaps, matches
from ..metrics.instances import ImageMasks, image_masks
from ..metrics.pose import PoseErrors, pose_errors
from ..targets.encoding import Encoding
from ..targets.keypoints import keypoint_distances, object_keypoints
from ..targets.objects import ViewObject
from ..targets.view import BACKGROUND, OPAQUE, TABLE, TRANSPARENT, detectable, semantic
from .floors import FloorScore, floor_scores

#: Least IoU of the boxes of an object and its detection (from the released code).
FOUND_IOU = 0.25
#: Groups of pixels over which depth is compared, by the classes of their first surface.
PIXEL_GROUPS = {
    "transparent": (TRANSPARENT,),
    "opaque": (OPAQUE,),
    "objects": (TRANSPARENT, OPAQUE),
    "all": (BACKGROUND, TABLE, TRANSPARENT, OPAQUE),
}
#: Parts of a picture: what lies within the picture of another view, hidden there or not, and what can be matched with
#: none. Of a stereo pair the second is a strip at the side, as wide as the disparity.
PICTURE_PARTS = ("overlap", "outside")


@dataclass(frozen=True, eq=False)
class ObjectScore:
    """Scores of one detectable object."""

    label: ViewObject
    iou: float  #: IoU of the boxes; 0 for a missed object
    pose: PoseErrors | None  #: None for a missed object
    points: int  #: number of keypoints
    depth_mae: float | None  #: over its visible pixels [m]; None where their depth is unknown
    keypoints: tuple[float, ...] | None = None  #: distances of the compared keypoints [m]; None for a missed object
    keypoint_count: int = 2  #: number of these: two on the axis, unless KeyPose predicts others


@dataclass(frozen=True, eq=False)
class SampleScore:
    """Scores of one sample."""

    name: str
    full: dict[str, DepthErrors | None]  #: by `PIXEL_GROUPS`, at full size
    small: dict[str, DepthErrors | None]  #: by `PIXEL_GROUPS`, at the size of ClearGrasp
    parts: dict[str, dict[str, DepthErrors | None]]  #: by `PICTURE_PARTS` and `PIXEL_GROUPS`, at full size
    floors: dict[str, FloorScore]  #: by size, full and cleargrasp
    boxes: ImageOverlaps
    masks: ImageMasks
    objects: tuple[ObjectScore, ...]


def score_sample(
    name: str,
    outputs: Mapping[str, Tensor],
    K: Tensor,
    labels: GroundTruth,
    encoding: Encoding,
    matched: np.ndarray | None = None,
    overlap: np.ndarray | None = None,
) -> SampleScore:
    """Return the scores of one sample.

    Parameters
    ----------
    name : str
        Name of the sample.
    outputs : mapping of Tensor
        Outputs of a network for a batch of one.
    K : (3, 3) Tensor
        Intrinsic matrix of the reference view [px].
    labels : GroundTruth
        Its ground labels.
    encoding : Encoding
        Encoding of the network's fields.
    matched : (H, W) float, optional
        Depth by semi-global matching [m].
    overlap : (H, W) bool, optional
        Which pixels lie within the picture of another view.
    """
    fields = {key: value for key, value in outputs.items() if key not in ("planes", "plane_logits", "focal_baseline")}
    check_finite(fields, name)
    (found,) = decode(fields, K[None].double(), encoding)
    depth = outputs["depth"][0].cpu().numpy()
    classes = semantic(labels.instances, labels.objects)
    masks = {kind: np.isin(classes, wanted) for kind, wanted in PIXEL_GROUPS.items()}
    wanted = {item.id for item in detectable(labels.objects)}
    boxes = _box_overlaps(found, labels, wanted)
    return SampleScore(
        name=name,
        full={kind: depth_errors(depth, labels.Z, mask) for kind, mask in masks.items()},
        small={kind: cleargrasp_errors(depth, labels.Z, mask) for kind, mask in masks.items()},
        parts={} if overlap is None else _parts(depth, labels.Z, masks, overlap),
        floors=floor_scores(labels.Z, masks, matched),
        boxes=boxes,
        masks=_masks(found, labels, wanted),
        objects=_objects(found, boxes, labels, depth),
    )


def _parts(
    depth: np.ndarray, true: np.ndarray, masks: Mapping[str, np.ndarray], overlap: np.ndarray
) -> dict[str, dict[str, DepthErrors | None]]:
    parts = dict(zip(PICTURE_PARTS, (overlap, ~overlap), strict=True))
    return {
        name: {kind: depth_errors(depth, true, mask & part) for kind, mask in masks.items()}
        for name, part in parts.items()
    }


def check_finite(outputs: Mapping[str, Tensor], where: str) -> None:
    """Raise InputError where an output of a network is not finite: its weights are damaged."""
    for name, value in outputs.items():
        if not bool(torch.isfinite(value).all()):
            raise InputError(f"{where}: {name}", "finite numbers from the network", "others; its weights are damaged")


def _box_overlaps(found: Detections, labels: GroundTruth, wanted: set[int]) -> ImageOverlaps:
    poses, sizes = found.camera_T_object.cpu().numpy(), found.size.cpu().numpy()
    overlaps = np.zeros((len(found), len(labels.objects)))
    for column, item in enumerate(labels.objects):
        for row in range(len(found)):
            overlaps[row, column] = object_iou(poses[row], sizes[row], item.camera_T_object, item.size, item.symmetry)
    ignored = np.array([item.id not in wanted for item in labels.objects], bool)
    return ImageOverlaps(found.score.cpu().numpy().astype(np.float64), overlaps, ignored)


def _masks(found: Detections, labels: GroundTruth, wanted: set[int]) -> ImageMasks:
    visible = [item.id for item in labels.objects if item.visible]
    true = labels.instances == np.array(visible, np.int64)[:, None, None]  # (m, H, W); none visible: (0, H, W)
    ignored = np.array([number not in wanted for number in visible], bool)
    return image_masks(found.score.cpu().numpy().astype(np.float64), found.mask.cpu().numpy(), true, ignored)


def _objects(
    found: Detections, boxes: ImageOverlaps, labels: GroundTruth, depth: np.ndarray
) -> tuple[ObjectScore, ...]:
    label_of = matches(boxes, FOUND_IOU).label_of
    rows = {int(label): row for row, label in enumerate(label_of) if label >= 0}
    scores = []
    for column, item in enumerate(labels.objects):
        if boxes.ignored[column]:
            continue
        row, points = rows.get(column), labels.keypoints[item.id]
        pose = None
        if row is not None:
            camera_T_object = found.camera_T_object[row].cpu().numpy()
            surface = labels.surface.get(item.id)
            pose = pose_errors(camera_T_object, item.camera_T_object, points, item.symmetry, surface)
        iou = 0.0 if row is None else float(boxes.overlaps[row, column])
        errors = depth_errors(depth, labels.Z, labels.instances == item.id)
        axis = None if row is None else axis_distances(found.camera_T_object[row].cpu().numpy(), item)
        scores.append(ObjectScore(item, iou, pose, len(points), None if errors is None else errors.mae, axis))
    return tuple(scores)


def axis_distances(camera_T_object: np.ndarray, item: ViewObject) -> tuple[float, ...]:
    """Return the distances of an object's `axis_points` under a pose that was found [m].

    The best of the orders that look the same counts, as for networks that predict these points alone.
    """
    local, orders = object_keypoints(item, np.zeros((0, 3)))
    found, true = (local @ pose[:3, :3].T + pose[:3, 3] for pose in (camera_T_object, item.camera_T_object))
    return tuple(keypoint_distances(found, true, orders).tolist())


def eval_mode(network: torch.nn.Module) -> torch.nn.Module:
    """Put a network into evaluation mode without gradients, and return it."""
    return network.eval().requires_grad_(False)
