"""Average precision (AP) over a data set, from overlaps of any kind.

(Everingham et al., "The Pascal Visual Object Classes Challenge", IJCV 2010, section 4.2, with all points of the curve,
as from VOC 2010 on.) All detections of the data set are ranked by score. In that order each is matched to the label of
its image with the greatest overlap, among unmatched labels with an overlap of the threshold or more; without one it is
a false positive. Precision is replaced by its maximum at the same or greater recall; its integral over recall is the
average precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class ImageOverlaps:
    """Detections of one image, compared with its labels."""

    scores: np.ndarray  #: (n,) float, of the detections
    overlaps: np.ndarray  #: (n, m) float in [0, 1], of detections with labels
    ignored: np.ndarray  #: (m,) bool: labels that are neither false negatives nor make false positives


@dataclass(frozen=True, eq=False)
class Matches:
    """Matches of detections and labels in one image."""

    label_of: np.ndarray  #: (n,) int: the label that each detection is matched to; -1 for none
    left_out: np.ndarray  #: (n,) bool: detections of ignored labels, neither true nor false positives


def matches(image: ImageOverlaps, threshold: float) -> Matches:
    """Return the matches of detections and labels of an image, by descending score.

    Detections of other images have no influence, so the ranking within the image is enough.
    """
    count = len(image.scores)
    label_of, left_out = np.full(count, -1), np.zeros(count, bool)
    unmatched = ~image.ignored
    for index in np.argsort(-image.scores, kind="stable"):
        overlap = image.overlaps[index]
        candidates = np.where(unmatched & (overlap >= threshold), overlap, -1.0)
        if candidates.size and candidates.max() >= 0.0:
            label_of[index] = candidates.argmax()
            unmatched[label_of[index]] = False
        else:
            left_out[index] = bool((image.ignored & (overlap >= threshold)).any())
    return Matches(label_of, left_out)


def average_precision(images: Sequence[ImageOverlaps], threshold: float) -> float:
    """Return the average precision, 0 to 1; NaN without labels."""
    labels = sum(int((~image.ignored).sum()) for image in images)
    if not labels:
        return float("nan")
    scores, correct = [np.zeros(0)], [np.zeros(0, bool)]
    for image in images:
        found = matches(image, threshold)
        counted = ~found.left_out
        scores.append(image.scores[counted])
        correct.append(found.label_of[counted] >= 0)
    order = np.argsort(-np.concatenate(scores), kind="stable")
    hits = np.concatenate(correct)[order]
    recall = np.cumsum(hits) / labels
    precision = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    envelope = np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.sum(np.diff(recall, prepend=0.0) * envelope))


def mean_overlap(images: Sequence[ImageOverlaps], threshold: float) -> tuple[float, float]:
    """Return the mean overlap of labels and their detections: over the detected labels, and over all, 0 if missed.

    NaN without labels. The 3D IoU of the paper is the first; it favours a network that detects easy objects only.
    """
    overlaps, missed = [], 0
    for image in images:
        label_of = matches(image, threshold).label_of
        rows = np.flatnonzero(label_of >= 0)
        overlaps += image.overlaps[rows, label_of[rows]].tolist()
        missed += int((~image.ignored).sum()) - len(rows)
    found = float(np.mean(overlaps)) if overlaps else float("nan")
    return found, float(np.sum(overlaps) / (len(overlaps) + missed)) if overlaps or missed else float("nan")
