"""Histograms of values, and the numbers that stand beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .quantities import Axis

#: Fewest and most bins of a histogram, bins of fractions (steps of 5 %), most whole numbers that have a bar each [1].
FEWEST_BINS, MOST_BINS, PERCENT_BINS, MOST_BARS = 5, 24, 20, 40
#: Percentiles beside the extremes [%].
PERCENTILES = (5.0, 50.0, 95.0)


@dataclass(frozen=True, eq=False)
class Histogram:
    """Counts between edges."""

    edges: np.ndarray  #: (n + 1,) float64, ascending, in the unit that is shown
    counts: np.ndarray  #: (n,) int64


def histogram(values: np.ndarray, axis: Axis) -> Histogram:
    """Return the histogram of values.

    Parameters
    ----------
    values : (n,) float
        At least one, in the unit that is shown.
    axis : {"linear", "log", "whole", "percent"}
        ``whole``: a bin for each number from 0 on, while these are few. ``percent``: steps of 5 %. ``log``: bins of
        equal ratios; with a value that is not positive they are of equal width after all.
    """
    edges = _edges(values, axis)
    inside = np.clip(values, edges[0], edges[-1])  # the outer edges are rounded
    return Histogram(edges, np.histogram(inside, edges)[0])


def _edges(values: np.ndarray, axis: Axis) -> np.ndarray:
    low, high = float(values.min()), float(values.max())
    if axis == "percent":
        return np.linspace(0.0, 100.0, PERCENT_BINS + 1)
    if axis == "whole" and high < MOST_BARS:
        return np.arange(-0.5, max(high, 1.0) + 1.0)
    if high - low <= 1e-6 * abs(high):  # one value, as float32 has it: in the middle bin
        if axis == "log" and low > 0.0:
            return np.geomspace(low / 1.1, high * 1.1, FEWEST_BINS + 1)
        reach = 0.1 * abs(high) or 1.0
        return np.linspace(low - reach, high + reach, FEWEST_BINS + 1)
    # Rice's rule: twice the cube root of the number of values (Lane et al., Online Statistics Education, 2.B).
    bins = int(np.clip(np.ceil(2.0 * np.cbrt(values.size)), FEWEST_BINS, MOST_BINS))
    return np.geomspace(low, high, bins + 1) if axis == "log" and low > 0.0 else np.linspace(low, high, bins + 1)


def number_text(value: float, digits: int = 4) -> str:
    """Return a number with so many digits, and thousands apart: ``0.1235``, ``12,350``."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 1000.0 else f"{rounded:g}"


def statistics(values: np.ndarray) -> list[tuple[str, str]]:
    """Return the numbers below a histogram, each with its heading."""
    low, middle, high = np.percentile(values, PERCENTILES)
    return [
        ("n", f"{values.size:,}"),
        ("min", number_text(values.min())),
        ("5 %", number_text(low)),
        ("median", number_text(middle)),
        ("mean", number_text(values.mean())),
        ("95 %", number_text(high)),
        ("max", number_text(values.max())),
    ]
