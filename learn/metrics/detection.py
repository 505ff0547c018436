"""Average precision over a whole data set, from overlaps of any kind.

(Everingham et al., "The Pascal Visual Object Classes Challenge", IJCV 2010, section 4.2, with every point of the curve,
as from VOC 2010 on.) All detections of the data set are ranked by score. In that order each takes the label of its
picture that overlaps it most among those which are still free and overlap by the threshold or more; one that finds
none is false. Precision is made to fall with recall by taking the greatest one at that recall or above; its integral
over recall is the average precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class PictureOverlaps:
    """What was found in one picture against what is there."""

    scores: np.ndarray  #: (n,) float, of the detections
    overlaps: np.ndarray  #: (n, m) float in [0, 1], of detections with labels
    ignored: np.ndarray  #: (m,) bool: labels that need not be found, and whose detections are not false


@dataclass(frozen=True, eq=False)
class Matches:
    """Who found what, in one picture."""

    label_of: np.ndarray  #: (n,) int: the label that each detection found; -1 for none
    left_out: np.ndarray  #: (n,) bool: detections of ignored labels, neither right nor false


def matches(picture: PictureOverlaps, threshold: float) -> Matches:
    """Return which label each detection of a picture finds, in the order of their scores.

    Detections of other pictures take no part, so the ranking of the picture alone is enough.
    """
    count = len(picture.scores)
    label_of, left_out = np.full(count, -1), np.zeros(count, bool)
    free = ~picture.ignored
    for index in np.argsort(-picture.scores, kind="stable"):
        overlap = picture.overlaps[index]
        candidates = np.where(free & (overlap >= threshold), overlap, -1.0)
        if candidates.size and candidates.max() >= 0.0:
            label_of[index] = candidates.argmax()
            free[label_of[index]] = False
        else:
            left_out[index] = bool((picture.ignored & (overlap >= threshold)).any())
    return Matches(label_of, left_out)


def average_precision(pictures: Sequence[PictureOverlaps], threshold: float) -> float:
    """Return the average precision, 0 to 1; NaN where there is nothing to be found."""
    labels = sum(int((~picture.ignored).sum()) for picture in pictures)
    if not labels:
        return float("nan")
    scores, right = [np.zeros(0)], [np.zeros(0, bool)]
    for picture in pictures:
        found = matches(picture, threshold)
        counted = ~found.left_out
        scores.append(picture.scores[counted])
        right.append(found.label_of[counted] >= 0)
    order = np.argsort(-np.concatenate(scores), kind="stable")
    hits = np.concatenate(right)[order]
    recall = np.cumsum(hits) / labels
    precision = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    falling = np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.sum(np.diff(recall, prepend=0.0) * falling))


def mean_overlap(pictures: Sequence[PictureOverlaps], threshold: float) -> tuple[float, float]:
    """Return the mean overlap of labels with what found them: over those found, and over all with 0 for a missed one.

    NaN where there are none. The paper's 3D IoU is the first; a network that finds only easy objects does well in it.
    """
    overlaps, missed = [], 0
    for picture in pictures:
        label_of = matches(picture, threshold).label_of
        rows = np.flatnonzero(label_of >= 0)
        overlaps += picture.overlaps[rows, label_of[rows]].tolist()
        missed += int((~picture.ignored).sum()) - len(rows)
    found = float(np.mean(overlaps)) if overlaps else float("nan")
    return found, float(np.sum(overlaps) / (len(overlaps) + missed)) if overlaps or missed else float("nan")
