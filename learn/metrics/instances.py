"""Average precision of instance masks, by pycocotools.

(Lin et al., "Microsoft COCO", ECCV 2014: precision averaged over 101 recalls and over IoU 0.50 to
0.95 in steps of 0.05.)
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

from .detection import ImageOverlaps

#: The only category: any object.
_CATEGORY = 1


#: A mask in pycocotools' compressed run-length encoding.
Rle = Any


@dataclass(frozen=True, eq=False)
class ImageMasks:
    """Detected and true masks of one image."""

    size: tuple[int, int]  #: height and width [px]
    scores: np.ndarray  #: (n,) float
    found: tuple[Rle, ...]  #: n detected masks
    true: tuple[Rle, ...]  #: m true masks
    ignored: np.ndarray  #: (m,) bool: true masks that are not scored (``iscrowd`` in COCO)


def image_masks(scores: np.ndarray, found: np.ndarray, true: np.ndarray, ignored: np.ndarray) -> ImageMasks:
    """Return the masks of an image, run-length encoded, of detected, (n, H, W), and true, (m, H, W), bool masks."""
    size = (true.shape[1], true.shape[2])
    return ImageMasks(size, scores, tuple(map(_encoded, found)), tuple(map(_encoded, true)), ignored)


@dataclass(frozen=True)
class InstancePrecision:
    """COCO average precision, 0 to 1; NaN without true masks."""

    ap: float  #: mean over the IoU thresholds
    ap50: float
    ap75: float


def instance_precision(images: Sequence[ImageMasks]) -> InstancePrecision:
    """Return the average precisions of masks over a data set."""
    annotations, results, records = [], [], []
    for number, image in enumerate(images, start=1):
        height, width = image.size
        records.append({"id": number, "height": height, "width": width})
        for mask, ignored in zip(image.true, image.ignored, strict=True):
            annotations.append(_annotation(mask, number, len(annotations) + 1) | {"iscrowd": int(ignored)})
        for mask, score in zip(image.found, image.scores, strict=True):
            results.append(_annotation(mask, number, len(results) + 1) | {"score": float(score)})
    if all(annotation["iscrowd"] for annotation in annotations):
        return InstancePrecision(*[float("nan")] * 3)
    if not results:
        return InstancePrecision(0.0, 0.0, 0.0)
    return _evaluated(records, annotations, results)


def mask_overlaps(image: ImageMasks) -> ImageOverlaps:
    """Return the IoU of each detected mask with each true mask."""
    shape = (len(image.found), len(image.true))
    if not all(shape):
        return ImageOverlaps(image.scores, np.zeros(shape), image.ignored)
    overlaps = coco_mask.iou(list(image.found), list(image.true), [0] * len(image.true))
    return ImageOverlaps(image.scores, np.asarray(overlaps), image.ignored)


def _encoded(mask: np.ndarray) -> Rle:
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
    with redirect_stdout(io.StringIO()):  # pycocotools prints its progress
        true, found = COCO(), COCO()
        true.dataset = _dataset(images, annotations)
        found.dataset = _dataset(images, results)
        true.createIndex()
        found.createIndex()
        evaluation = COCOeval(true, found, "segm")
        evaluation.evaluate()
        evaluation.accumulate()
        evaluation.summarize()
    return InstancePrecision(*(float(value) for value in evaluation.stats[:3]))
