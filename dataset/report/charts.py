"""Histograms as inline SVG. Colours are the page's: shapes have classes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

import numpy as np

from .histograms import Histogram, histogram, number_text
from .quantities import Quantity

#: Width of a histogram, height of its bars, and of the ticks and the paper's range below them [px].
WIDTH, HEIGHT, TICKS, RANGE = 320, 96, 18, 20
#: Margin beside the bars, in which half of an outer tick's number fits [px].
_MARGIN = 22


@dataclass(frozen=True)
class _Axis:
    """The horizontal axis."""

    low: float  #: at the left end, in the unit that is shown
    high: float
    log: bool

    def place(self, value: float) -> float:
        """Return where a number is [px]."""
        low, high = self.low, self.high
        if self.log:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return _MARGIN + (WIDTH - 2 * _MARGIN) * (value - low) / (high - low)


def svg_histogram(quantity: Quantity, values: np.ndarray) -> str:
    """Return a histogram as an SVG picture.

    Parameters
    ----------
    quantity : Quantity
        What it is of.
    values : (n,) float64
        At least one, in the unit that is shown.
    """
    shown = histogram(values, quantity.axis)
    axis = _axis(quantity, shown)
    parts = [*_bars(quantity, shown, axis), *_below(quantity, shown, axis), _median(axis, float(np.median(values)))]
    height = HEIGHT + TICKS + (RANGE if quantity.paper else 0)
    label = escape(f"{quantity.title}: histogram of {values.size} values")
    head = f'<svg class="histogram" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">'
    return head + "".join(parts) + "</svg>"


def svg_fraction(fraction: float) -> str:
    """Return a bar as long as a fraction, 0 to 1, for a row of a table."""
    inside = f'<rect class="bar" width="{100.0 * fraction:.2f}" height="8"/>'
    return f'<svg class="fraction" viewBox="0 0 100 8" preserveAspectRatio="none" aria-hidden="true">{inside}</svg>'


def _axis(quantity: Quantity, shown: Histogram) -> _Axis:
    low, high = float(shown.edges[0]), float(shown.edges[-1])
    if quantity.paper is not None:  # its range is on the axis
        low, high = min(low, quantity.paper[0] - 0.5), max(high, quantity.paper[1] + 0.5)
    return _Axis(low, high, quantity.axis == "log" and low > 0.0 and len(shown.edges) > 2)


def _bars(quantity: Quantity, shown: Histogram, axis: _Axis) -> list[str]:
    most, places = int(shown.counts.max()), [axis.place(edge) for edge in shown.edges]
    bars = []
    for number, count in enumerate(shown.counts.tolist()):
        if count:
            left, right = places[number : number + 2]
            gap, height = min(1.0, 0.15 * (right - left)), max(HEIGHT * count / most, 1.0)
            box = f'x="{left + gap:.1f}" y="{HEIGHT - height:.1f}" width="{right - left - 2 * gap:.1f}"'
            title = escape(f"{_bin_text(quantity, shown, number)}: {count:,}")
            bars.append(f'<rect class="bar" {box} height="{height:.1f}"><title>{title}</title></rect>')
    return bars


def _bin_text(quantity: Quantity, shown: Histogram, number: int) -> str:
    low, high = float(shown.edges[number]), float(shown.edges[number + 1])
    if quantity.axis == "whole" and high - low == 1.0:
        return f"{low + 0.5:.0f}"
    return f"{number_text(low)} to {number_text(high)} {quantity.unit}".rstrip()


def _below(quantity: Quantity, shown: Histogram, axis: _Axis) -> list[str]:
    """Return the line below the bars, three ticks with numbers, and the paper's range."""
    parts = [f'<line class="axis" x1="{_MARGIN}" x2="{WIDTH - _MARGIN}" y1="{HEIGHT}" y2="{HEIGHT}"/>']
    whole = quantity.axis == "whole"
    low, high = (axis.low + 0.5, axis.high - 0.5) if whole else (axis.low, axis.high)
    middle = math.sqrt(low * high) if axis.log else 0.5 * (low + high)
    ticks = [low, round(middle) if whole else middle, high] if high - low > (1.0 if whole else 0.0) else [low, high]
    if len(shown.edges) == 2:  # one value
        ticks = [0.5 * (low + high)]
    for tick in dict.fromkeys(ticks):
        text = f'<text x="{axis.place(tick):.1f}" y="{HEIGHT + 14}" text-anchor="middle">{number_text(tick)}</text>'
        parts.append(text)
    if quantity.paper is not None:
        left, right = (axis.place(end) for end in quantity.paper)
        y = HEIGHT + TICKS + 5
        parts.append(f'<line class="paper" x1="{left:.1f}" x2="{right:.1f}" y1="{y}" y2="{y}"/>')
        parts.append(f'<text x="{0.5 * (left + right):.1f}" y="{y + 13}" text-anchor="middle">Syn-TODD</text>')
    return parts


def _median(axis: _Axis, median: float) -> str:
    x = axis.place(median)
    return f'<line class="median" x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{HEIGHT}"><title>median</title></line>'
