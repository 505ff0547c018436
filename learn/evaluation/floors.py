"""Depth errors of what needs no network: a constant, the median of each picture, semi-global matching.

A network that does not beat them has learnt nothing, or has not learnt to match.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..metrics.depth import (
    CLEARGRASP_SIZE,
    DepthErrors,
    constant_errors,
    depth_errors,
    depth_histogram,
    mean_errors,
    resized_nearest,
)

#: Floors in the order of reports.
FLOORS = ("constant", "picture_median", "semi_global")


@dataclass(frozen=True, eq=False)
class FloorScore:
    """Floors of one picture at one size, by kind of pixels."""

    picture_median: dict[str, DepthErrors | None]  #: of the true depth's own median of these pixels
    semi_global: dict[str, DepthErrors | None] | None  #: of semi-global matching, holes filled; None without a pair
    histograms: dict[str, np.ndarray]  #: true depths of these pixels by `metrics.depth.DEPTH_BINS`, pixels


def floor_scores(Z: np.ndarray, masks: Mapping[str, np.ndarray], matched: np.ndarray | None) -> dict[str, FloorScore]:
    """Return the floors of one picture by size: ``full``, and ``cleargrasp``, resized to its size.

    Parameters
    ----------
    Z : (H, W) float
        True depth [m].
    masks : mapping of (H, W) bool
        Pixels of each kind.
    matched : (H, W) float or None
        Depth by semi-global matching [m].
    """

    def at(size: tuple[int, int]) -> FloorScore:
        true = resized_nearest(Z, size)
        pixels = {kind: resized_nearest(mask, size) for kind, mask in masks.items()}
        found = None if matched is None else resized_nearest(matched, size)
        return FloorScore(
            {kind: depth_errors(_median_of(true, mask), true, mask) for kind, mask in pixels.items()},
            None if found is None else {kind: depth_errors(found, true, mask) for kind, mask in pixels.items()},
            {kind: depth_histogram(true, mask) for kind, mask in pixels.items()},
        )

    return {"full": at((Z.shape[0], Z.shape[1])), "cleargrasp": at(CLEARGRASP_SIZE)}


def summarised_floors(scores: Sequence[FloorScore], kind: str) -> dict[str, Any]:
    """Return the floors of a data set for one kind of pixels, as JSON data, by `FLOORS`; None where undefined."""
    constant = constant_errors([score.histograms[kind] for score in scores])
    median = mean_errors([score.picture_median[kind] for score in scores])
    matched = mean_errors([score.semi_global[kind] for score in scores if score.semi_global is not None])
    return {
        "constant": None if constant is None else {"depth": constant[0], **asdict(constant[1])},
        "picture_median": None if median is None else asdict(median),
        "semi_global": None if matched is None else asdict(matched),
    }


def _median_of(Z: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return a map of the median depth of the pixels of a mask: what an estimate of one number can reach at best."""
    known = Z[mask & np.isfinite(Z)]
    return np.full_like(Z, np.median(known) if known.size else 1.0)
