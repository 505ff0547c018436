"""Histograms as inline SVG. Colours are the page's: shapes have classes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

import numpy as np

from .histograms import Histogram, histogram, number_text
from .quantities import Quantity

#: Width of a histogram, height of its bars, and of the ticks and the paper's range below them [px].
WIDTH, HEIGHT, TICKS, RANGE = 320, 96, 18, 23
#: Margins beside the bars: on the left the largest count fits, on the right half of a tick's number [px].
_LEFT, _RIGHT = 40, 24


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
        return _LEFT + (WIDTH - _LEFT - _RIGHT) * (value - low) / (high - low)


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
    return _Axis(low, high, quantity.axis == "log" and low > 0.0)


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
    """Return the lines around the bars, the largest count, ticks with numbers, and the paper's range."""
    base = f'<line class="axis" x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{HEIGHT}" y2="{HEIGHT}"/>'
    parts = [base, _text(_LEFT - 5, 10, f"{shown.counts.max():,}", "end")]
    parts += [_text(axis.place(tick), HEIGHT + 14, number_text(tick, 3)) for tick in _ticks(quantity, axis)]
    if quantity.paper is not None:
        left, right = (axis.place(end) for end in quantity.paper)
        y = HEIGHT + TICKS + 5
        parts.append(f'<line class="paper" x1="{left:.1f}" x2="{right:.1f}" y1="{y}" y2="{y}"/>')
        parts.append(_text(0.5 * (left + right), y + 13, "Syn-TODD"))
    return parts


def _ticks(quantity: Quantity, axis: _Axis) -> list[float]:
    """Return the numbers at the ends and in the middle of the axis."""
    if quantity.axis == "whole":
        low, high = axis.low + 0.5, axis.high - 0.5
        return sorted({low, round(0.5 * (low + high)), high})
    return [axis.low, math.sqrt(axis.low * axis.high) if axis.log else 0.5 * (axis.low + axis.high), axis.high]


def _text(x: float, y: float, text: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y}" text-anchor="{anchor}">{escape(text)}</text>'


def _median(axis: _Axis, median: float) -> str:
    x = axis.place(median)
    return f'<line class="median" x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{HEIGHT}"><title>median</title></line>'
