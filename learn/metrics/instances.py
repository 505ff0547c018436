"""Instance segmentation by pycocotools.

(Lin et al., "Microsoft COCO", ECCV 2014: average precision over 101 recalls, at IoU 0.50 to 0.95 in steps of 0.05.)
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np
from pycocotools import mask as coco_mask
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from .detection import PictureOverlaps

#: The only category: any object.
_CATEGORY = 1


#: A mask in pycocotools' compressed run-length encoding.
Rle = Any


@dataclass(frozen=True, eq=False)
class PictureMasks:
    """Masks found in one picture, and those that are there."""

    size: tuple[int, int]  #: height and width [px]
    scores: np.ndarray  #: (n,) float
    found: tuple[Rle, ...]  #: n of them
    true: tuple[Rle, ...]  #: m of them
    ignored: np.ndarray  #: (m,) bool: need not be found (COCO's ``iscrowd``)


def picture_masks(scores: np.ndarray, found: np.ndarray, true: np.ndarray, ignored: np.ndarray) -> PictureMasks:
    """Return the masks of a picture, packed; those found, (n, H, W), and those that are there, (m, H, W), are bool."""
    size = (true.shape[1], true.shape[2])
    return PictureMasks(size, scores, tuple(map(_packed, found)), tuple(map(_packed, true)), ignored)


@dataclass(frozen=True)
class InstancePrecision:
    """COCO's figures, 0 to 1; NaN where there is nothing to be found."""

    ap: float  #: mean over the IoU thresholds
    ap50: float
    ap75: float


def instance_precision(pictures: Sequence[PictureMasks]) -> InstancePrecision:
    """Return the average precisions of masks over a data set."""
    annotations, results, images = [], [], []
    for number, picture in enumerate(pictures, start=1):
        height, width = picture.size
        images.append({"id": number, "height": height, "width": width})
        for mask, ignored in zip(picture.true, picture.ignored, strict=True):
            annotations.append(_annotation(mask, number, len(annotations) + 1) | {"iscrowd": int(ignored)})
        for mask, score in zip(picture.found, picture.scores, strict=True):
            results.append(_annotation(mask, number, len(results) + 1) | {"score": float(score)})
    if all(annotation["iscrowd"] for annotation in annotations):
        return InstancePrecision(*[float("nan")] * 3)
    if not results:
        return InstancePrecision(0.0, 0.0, 0.0)
    return _evaluated(images, annotations, results)


def mask_overlaps(picture: PictureMasks) -> PictureOverlaps:
    """Return the IoU of each found mask with each true one."""
    shape = (len(picture.found), len(picture.true))
    if not all(shape):
        return PictureOverlaps(picture.scores, np.zeros(shape), picture.ignored)
    overlaps = coco_mask.iou(list(picture.found), list(picture.true), [0] * len(picture.true))
    return PictureOverlaps(picture.scores, np.asarray(overlaps), picture.ignored)


def _packed(mask: np.ndarray) -> Rle:
    return coco_mask.encode(np.asfortranarray(mask.astype(np.uint8)))


def _annotation(mask: Rle, image: int, number: int) -> dict[str, Any]:
    return {
        "id": number,
        "image_id": image,
        "category_id": _CATEGORY,
        "segmentation": mask,
        "area": float(coco_mask.area(mask)),
        "bbox": coco_mask.toBbox(mask).tolist(),
    }


def _dataset(images: list, annotations: list) -> Any:
    categories = [{"id": _CATEGORY, "name": "object"}]
    return {"images": images, "annotations": annotations, "categories": categories}


def _evaluated(images: list, annotations: list, results: list) -> InstancePrecision:
    with redirect_stdout(io.StringIO()):  # pycocotools tells what it does
        truth, found = COCO(), COCO()
        truth.dataset = _dataset(images, annotations)
        found.dataset = _dataset(images, results)
        truth.createIndex()
        found.createIndex()
        evaluation = COCOeval(truth, found, "segm")
        evaluation.evaluate()
        evaluation.accumulate()
        evaluation.summarize()
    return InstancePrecision(*(float(value) for value in evaluation.stats[:3]))
