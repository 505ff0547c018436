"""One sample: what a network gave against what is there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from ...core.errors import InputError
from ..data.ground_truth import Truth
from ..decoding.decode import Detections, decode
from ..metrics.box_iou import object_iou
from ..metrics.depth import DepthErrors, cleargrasp_errors, depth_errors
from ..metrics.detection import PictureOverlaps, matches
from ..metrics.instances import PictureMasks, picture_masks
from ..metrics.pose import PoseErrors, pose_errors
from ..targets.encoding import Encoding
from ..targets.objects import ViewObject
from ..targets.view import NOTHING, OPAQUE, TABLE, TRANSPARENT, findable, semantic

#: Overlap of the boxes from which an object counts as found (the released code's value).
FOUND = 0.25
#: Pixels over which depth is compared: the classes of their first surface.
PIXELS = {
    "transparent": (TRANSPARENT,),
    "opaque": (OPAQUE,),
    "objects": (TRANSPARENT, OPAQUE),
    "all": (NOTHING, TABLE, TRANSPARENT, OPAQUE),
}


@dataclass(frozen=True, eq=False)
class ObjectScore:
    """One object that was to be found."""

    label: ViewObject
    iou: float  #: of the boxes; 0 where it was missed
    pose: PoseErrors | None  #: None where it was missed
    points: int  #: keypoints of the object
    depth_mae: float | None  #: over its visible pixels [m]; None where their depth is unknown


@dataclass(frozen=True, eq=False)
class SampleScore:
    """One sample."""

    name: str
    full: dict[str, DepthErrors | None]  #: by `PIXELS`, at full size
    small: dict[str, DepthErrors | None]  #: at ClearGrasp's size
    boxes: PictureOverlaps
    masks: PictureMasks
    objects: tuple[ObjectScore, ...]


def score_sample(name: str, outputs: Mapping[str, Tensor], K: Tensor, truth: Truth, encoding: Encoding) -> SampleScore:
    """Return the score of one sample.

    Parameters
    ----------
    name : str
        Of the sample.
    outputs : mapping of Tensor
        Of a network, a batch of one.
    K : (3, 3) Tensor
        Of the reference view [px].
    truth : Truth
        Its labels.
    encoding : Encoding
        Of the network's fields.
    """
    fields = {key: value for key, value in outputs.items() if key not in ("planes", "plane_logits")}
    check_finite(fields, name)
    (found,) = decode(fields, K[None].double(), encoding)
    depth = outputs["depth"][0].cpu().numpy()
    classes = semantic(truth.instances, truth.objects)
    masks = {kind: np.isin(classes, wanted) for kind, wanted in PIXELS.items()}
    wanted = {item.id for item in findable(truth.objects, K.double().cpu().numpy())}
    boxes = _box_overlaps(found, truth, wanted)
    return SampleScore(
        name=name,
        full={kind: depth_errors(depth, truth.Z, mask) for kind, mask in masks.items()},
        small={kind: cleargrasp_errors(depth, truth.Z, mask) for kind, mask in masks.items()},
        boxes=boxes,
        masks=_masks(found, truth, wanted),
        objects=_objects(found, boxes, truth, depth),
    )


def check_finite(outputs: Mapping[str, Tensor], where: str) -> None:
    """Raise InputError where a network gives what is no number: its weights are spoilt."""
    for name, value in outputs.items():
        if not bool(torch.isfinite(value).all()):
            raise InputError(f"{where}: {name}", "finite numbers from the network", "others; its weights are spoilt")


def _box_overlaps(found: Detections, truth: Truth, wanted: set[int]) -> PictureOverlaps:
    poses, sizes = found.camera_T_object.cpu().numpy(), found.size.cpu().numpy()
    overlaps = np.zeros((len(found), len(truth.objects)))
    for column, item in enumerate(truth.objects):
        for row in range(len(found)):
            overlaps[row, column] = object_iou(poses[row], sizes[row], item.camera_T_object, item.size, item.symmetry)
    ignored = np.array([item.id not in wanted for item in truth.objects], bool)
    return PictureOverlaps(found.score.cpu().numpy().astype(np.float64), overlaps, ignored)


def _masks(found: Detections, truth: Truth, wanted: set[int]) -> PictureMasks:
    seen = [item.id for item in truth.objects if item.visible]
    true = np.stack([truth.instances == number for number in seen]) if seen else np.zeros((0, *truth.Z.shape), bool)
    ignored = np.array([number not in wanted for number in seen], bool)
    return picture_masks(found.score.cpu().numpy().astype(np.float64), found.mask.cpu().numpy(), true, ignored)


def _objects(found: Detections, boxes: PictureOverlaps, truth: Truth, depth: np.ndarray) -> tuple[ObjectScore, ...]:
    label_of = matches(boxes, FOUND).label_of
    rows = {int(label): row for row, label in enumerate(label_of) if label >= 0}
    scores = []
    for column, item in enumerate(truth.objects):
        if boxes.ignored[column]:
            continue
        row, points = rows.get(column), truth.keypoints[item.id]
        pose = None
        if row is not None:
            pose = pose_errors(found.camera_T_object[row].cpu().numpy(), item.camera_T_object, points, item.symmetry)
        iou = 0.0 if row is None else float(boxes.overlaps[row, column])
        errors = depth_errors(depth, truth.Z, truth.instances == item.id)
        scores.append(ObjectScore(item, iou, pose, len(points), None if errors is None else errors.mae))
    return tuple(scores)


def frozen(network: torch.nn.Module) -> torch.nn.Module:
    """Return a network in evaluation mode, none of whose weights has a gradient."""
    return network.eval().requires_grad_(False)
