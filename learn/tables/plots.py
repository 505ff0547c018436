"""Plots of a table as SVG pictures: accuracy over thresholds, error over the number of views, error by category."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from ..evaluation.report import CURVE
from .cells import known_mean
from .experiments import Experiment
from .runs import Result

#: Size of a plot and its margins [px].
_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 576, 300, 72, 190, 28, 40
#: Colours of the lines: those of Okabe & Ito ("Color Universal Design", 2008), which everyone can tell apart.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999")

_Line = Sequence[tuple[float, float]]


def experiment_plots(what: Experiment, results: Mapping[str, Result]) -> dict[str, str]:
    """Return the plots of an experiment, SVG by name; those without a figure are left out."""
    done = {
        row.name: (row, results[row.name]) for row in what.rows if row.name in results and results[row.name].reports
    }
    curves = {row.title: line for row, result in done.values() if (line := _accuracy(result))}
    found = {}
    if curves:
        found["accuracy"] = line_plot("Keypoints within a distance", "distance [mm]", "fraction [%]", curves)
    column = next(column for column in what.columns if column.name == "mae")
    views = [
        (float(row.views), value)
        for row, result in done.values()
        if row.views is not None
        and (value := known_mean([column.read(report) for report in result.reports])) is not None
    ]
    if len(views) > 1:
        found["views"] = line_plot("Error over the number of views", "views", column.title, {"MVTrans": sorted(views)})
    bars = {row.title: by_kind for row, result in done.values() if (by_kind := _by_category(result))}
    if bars:
        found["categories"] = bar_plot("Error of keypoints by category", "MAE [mm]", bars)
    return found


def line_plot(title: str, across: str, up: str, lines: Mapping[str, _Line]) -> str:
    """Return a plot of lines with a legend."""
    points = [point for line in lines.values() for point in line]
    low, high = min(x for x, _ in points), max(x for x, _ in points)
    top = max(max(y for _, y in points), 1e-9)
    wide, tall = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    parts = _frame(title, across, up, top)
    for step in range(5):
        value = low + (high - low) * step / 4.0
        parts.append(_text(_LEFT + wide * step / 4.0, _HEIGHT - _BOTTOM + 16, f"{value:.4g}", "middle"))
    for number, (name, line) in enumerate(lines.items()):
        colour = _COLOURS[number % len(_COLOURS)]
        dash = ' stroke-dasharray="5 3"' if number >= len(_COLOURS) else ""
        places = " ".join(
            f"{_LEFT + wide * (x - low) / ((high - low) or 1.0):.1f},{_TOP + tall * (1.0 - y / top):.1f}"
            for x, y in line
        )
        parts.append(f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
        parts += _legend(number, name, colour)
    return _picture(title, parts)


def bar_plot(title: str, up: str, groups: Mapping[str, Mapping[str, float]]) -> str:
    """Return a plot of bars: one for each category of each network."""
    kinds = sorted({kind for values in groups.values() for kind in values})
    top = max(max(value for values in groups.values() for value in values.values()), 1e-9)
    wide, tall = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    each = wide / len(kinds)
    bar = each * 0.8 / len(groups)
    parts = _frame(title, "", up, top)
    for place, kind in enumerate(kinds):
        parts.append(_text(_LEFT + each * (place + 0.5), _HEIGHT - _BOTTOM + 16, kind, "middle"))
    for number, (name, values) in enumerate(groups.items()):
        colour = _COLOURS[number % len(_COLOURS)]
        for place, kind in enumerate(kinds):
            height = tall * values.get(kind, 0.0) / top
            x = _LEFT + each * (place + 0.1) + bar * number
            parts.append(
                f'<rect x="{x:.1f}" y="{_TOP + tall - height:.1f}" width="{bar:.1f}" height="{height:.1f}" '
                f'fill="{colour}"/>'
            )
        parts += _legend(number, name, colour)
    return _picture(title, parts)


def _accuracy(result: Result) -> _Line:
    curves = []
    for report in result.reports:
        of = report["locations"]["truth"] if "locations" in report else report
        curves.append(of["keypoints"]["accuracy"])
    means = [known_mean(values) for values in zip(*curves, strict=True)]
    return [(1e3 * limit, 100.0 * value) for limit, value in zip(CURVE, means, strict=True) if value is not None]


def _by_category(result: Result) -> dict[str, float]:
    found: dict[str, list[float | None]] = {}
    for report in result.reports:
        of = report["locations"]["truth"] if "locations" in report else report
        for kind, values in of["by_category"].items():
            found.setdefault(kind, []).append(values["axis_mae"])
    means = {kind: known_mean(values) for kind, values in found.items()}
    return {kind: 1e3 * value for kind, value in means.items() if value is not None}


def _frame(title: str, across: str, up: str, top: float) -> list[str]:
    tall, right = _HEIGHT - _TOP - _BOTTOM, _WIDTH - _RIGHT
    parts = [
        _text(_LEFT, 16, title, "start", bold=True),
        _text((_LEFT + right) / 2.0, _HEIGHT - 6, across, "middle"),
        f'<text transform="translate(12 {_TOP + tall / 2.0}) rotate(-90)" text-anchor="middle">{escape(up)}</text>',
        f'<path d="M{_LEFT} {_TOP}V{_TOP + tall}H{right}" fill="none" stroke="#444"/>',
    ]
    for step in range(5):
        y = _TOP + tall * (1.0 - step / 4.0)
        parts.append(_text(_LEFT - 6, y + 4, f"{top * step / 4.0:.4g}", "end"))
        parts.append(f'<path d="M{_LEFT} {y:.1f}H{right}" stroke="#ddd"/>')
    return parts


def _legend(number: int, name: str, colour: str) -> list[str]:
    y = _TOP + 8 + 18 * number
    x = _WIDTH - _RIGHT + 12
    return [f'<rect x="{x}" y="{y - 9}" width="12" height="12" fill="{colour}"/>', _text(x + 18, y + 1, name, "start")]


def _text(x: float, y: float, text: str, anchor: str, *, bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{weight}>{escape(text)}</text>'


def _picture(title: str, parts: Sequence[str]) -> str:
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="{escape(title)}" font-family="sans-serif" font-size="11">'
    )
    return head + f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#fff"/>' + "".join(parts) + "</svg>"
