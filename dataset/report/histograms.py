"""Histograms of values, and the numbers that stand beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .quantities import Axis

#: Bins of a histogram, and of fractions: steps of 5 %. Most whole numbers that have a bar each [1].
BINS, PERCENT_BINS, MOST_BARS = 24, 20, 40
#: Percentiles beside the extremes [%].
PERCENTILES = (5.0, 50.0, 95.0)


@dataclass(frozen=True, eq=False)
class Histogram:
    """Counts between edges."""

    edges: np.ndarray  #: (n + 1,) float64, ascending, in the unit that is shown
    counts: np.ndarray  #: (n,) int64


def histogram(values: np.ndarray, axis: Axis) -> Histogram:
    """Return the histogram of values: whole numbers with a bar each, fractions by 5 %, others in 24 equal steps.

    Parameters
    ----------
    values : (n,) float
        At least one, in the unit that is shown.
    axis : {"linear", "log", "whole", "percent"}
        ``log``: steps have equal ratios; with a value that is not positive they are linear after all.
    """
    low, high = float(values.min()), float(values.max())
    if axis == "percent":
        edges = np.linspace(0.0, 100.0, PERCENT_BINS + 1)
        values = np.clip(values, 0.0, 100.0)  # a brimful vessel, rounded
    elif axis == "whole" and high - low < MOST_BARS:
        edges = np.arange(low - 0.5, high + 1.0)
    elif high - low <= 1e-6 * abs(high):  # one value, as float32 has it
        half = max(0.05 * abs(high), 1e-6)
        edges = np.array([low - half, high + half])
    elif axis == "log" and low > 0.0:
        edges = np.geomspace(low, high, BINS + 1)
    else:
        edges = np.linspace(low, high, BINS + 1)
    inside = np.clip(values, edges[0], edges[-1])  # the outer edges are rounded
    return Histogram(edges, np.histogram(inside, edges)[0])


def number_text(value: float) -> str:
    """Return a number with four digits, and thousands apart: ``0.1235``, ``12,350``."""
    rounded = float(f"{value:.4g}")
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
