"""Tables as data: cells with our figure, its spread, the published one; and how they are written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from .experiments import Column, Experiment, Row
from .runs import PAPER_SAMPLES, Plan, Result

NOT_RUN = "not run"
#: What a row cost, besides its figures, and the digits behind the point.
FACTS = {
    "parameters": ("parameters [M]", 2),
    "gmac": ("GMAC", 2),
    "runs": ("runs", 0),
    "seen": ("samples seen", 0),
    "evaluated": ("pictures or objects tested", 0),
}
_LATEX = str.maketrans({"%": r"\%", "&": r"\&", "_": r"\_", "#": r"\#", "<": "$<$", "±": r"$\pm$"})


@dataclass(frozen=True)
class Cell:
    """A figure of ours beside the published one."""

    ours: str
    paper: str = ""  #: "" where nothing was published

    def text(self) -> str:
        """Return both, as ``12.3 (paper 45.6)``."""
        return f"{self.ours} (paper {self.paper})" if self.paper else self.ours


@dataclass(frozen=True)
class TableData:
    """A table with a title and notes below it."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()


def experiment_table(what: Experiment, plan: Plan, results: Mapping[str, Result]) -> TableData:
    """Return the table of an experiment.

    Each figure is the mean over the runs of its row, with their standard deviation where there are several. A row that
    was not run says so in each cell, and the notes say why.
    """
    heads = ("network", *(column.title for column in what.columns), *(title for title, _ in FACTS.values()))
    rows = tuple(_row(what, row, results.get(row.name, Result((), NOT_RUN))) for row in what.rows)
    rows = (*_floor_rows(what, results), *rows)
    return TableData(what.title, heads, rows, tuple(_notes(what, plan, results)))


def _row(what: Experiment, row: Row, result: Result) -> tuple[Cell, ...]:
    paper = what.paper.get(row.name, {})
    cells = [Cell(row.title)]
    for column in what.columns:
        published = paper.get(column.name)
        shown = "" if published is None else f"{published:.{column.digits}f}"
        cells.append(Cell(_ours(column, result), shown))
    known = {**(result.facts or {}), "runs": float(len(result.reports))}
    for name, (_, digits) in FACTS.items():
        value = known.get(name)
        cells.append(Cell(NOT_RUN if value is None or not result.reports else f"{value:,.{digits}f}"))
    return tuple(cells)


def _floor_rows(what: Experiment, results: Mapping[str, Result]) -> tuple[tuple[Cell, ...], ...]:
    """Return what needs no network, from the first report that has it."""
    reports = [report for result in results.values() for report in result.reports]
    return tuple(
        (Cell(title), *(_floor_cell(column, name, reports) for column in what.columns), *(Cell("-") for _ in FACTS))
        for name, title in what.floors.items()
    )


def _floor_cell(column: Column, name: str, reports: Sequence[Mapping[str, Any]]) -> Cell:
    if column.floor is None:
        return Cell("-")
    known = [value for report in reports if (value := column.floor(report, name)) is not None]
    return Cell(f"{known[0]:.{column.digits}f}" if known else NOT_RUN)


def _ours(column: Column, result: Result) -> str:
    if not result.reports:
        return NOT_RUN
    values = [value for report in result.reports if (value := column.read(report)) is not None]
    if not values:
        return "-"
    mean = f"{np.mean(values):.{column.digits}f}"
    return mean if len(values) < 2 else f"{mean} ± {np.std(values, ddof=1):.{column.digits}f}"


def _amount(plan: Plan, results: Mapping[str, Result]) -> str:
    """Return what the networks saw: of all rows, those of given checkpoints as well."""
    seen = {int(result.facts["seen"]) for result in results.values() if result.facts} or {plan.samples}
    if len(seen) > 1:
        return f"Networks saw {min(seen):,} to {max(seen):,} samples: rows with equal numbers are to be compared."
    (number,) = seen
    if number >= PAPER_SAMPLES:
        return f"Each network saw as many samples as the paper's, {number:,}."
    return (
        f"Each network saw {number:,} samples, {100.0 * number / PAPER_SAMPLES:.3g} % of the paper's "
        f"{PAPER_SAMPLES:,}, so its figures are to be compared with each other, not with the paper's."
    )


def _splits(plan: Plan) -> str:
    train, val = plan.settings.train_split, plan.settings.val_split
    chosen = "the last step is taken" if val == "none" else f"chosen by the split {val}"
    overlap = train in (plan.split, "all") or plan.split == "all"
    warning = " TRAINED ON SCENES THAT ARE TESTED." if overlap else ""
    return f"Trained on the split {train}, {chosen}, tested on {plan.split}; seeds: {plan.seeds}.{warning}"


def _notes(what: Experiment, plan: Plan, results: Mapping[str, Result]) -> list[str]:
    notes = [_amount(plan, results)]
    if plan.budget is not None:
        notes.append(f"Budget: {plan.budget:g} minutes for all runs together, spread so that each sees equally many.")
    notes += [
        _splits(plan),
        f"Machine: {plan.machine}. Data set: {plan.data[:12]}.",
        'Means over runs ± their standard deviation. "-": the network does not give this. Published figures: '
        "MVTrans, ICRA 2023, tables I and II; other data, so no figure of ours can be expected to equal them.",
    ]
    if what.name == "keypose":
        notes.append(
            "KeyPose and DenseFusion are given the place of the object: the true one for AUC, <2 cm and MAE, then one "
            "that is off by 20 px, and that of a detector. The others find it, and an object that is not found has no "
            "keypoint within any distance. MAE is over the objects that are found. All are compared on the middle of "
            "the top and of the bottom of each object."
        )
        notes += _dropped(results)
    titles = {row.name: row.title for row in what.rows}
    notes += [f"{titles[name]}: {result.reason}" for name, result in results.items() if result.reason]
    return notes


def _dropped(results: Mapping[str, Result]) -> list[str]:
    notes = []
    for name, result in results.items():
        for report in result.reports[:1]:
            for location, values in report.get("locations", {}).items():
                counts = {kind: values[kind] for kind in ("dropped", "missed", "lost", "unknown") if values[kind]}
                if counts:
                    shown = ", ".join(f"{count} {kind}" for kind, count in counts.items())
                    kept = values["kept"]["auc"]
                    without = "" if kept is None else f"; without them AUC {100.0 * kept:.1f} %"
                    notes.append(f"{name}, {location}: {shown} of {values['keypoints']['objects']} objects{without}.")
    return notes


def markdown(table: TableData) -> str:
    """Return a table in Markdown."""
    lines = [f"## {table.title}", "", _line(table.heads), _line(["---"] * len(table.heads))]
    lines += [_line([cell.text() for cell in row]) for row in table.rows]
    return "\n".join([*lines, "", *(f"- {note}" for note in table.notes), ""])


def latex(table: TableData) -> str:
    """Return a table in LaTeX, for the package booktabs."""
    columns = "l" + "r" * (len(table.heads) - 1)
    lines = [r"\begin{table}", rf"\caption{{{_tex(table.title)}}}", rf"\begin{{tabular}}{{{columns}}}", r"\toprule"]
    lines += [" & ".join(map(_tex, table.heads)) + r" \\", r"\midrule"]
    lines += [" & ".join(_tex(cell.text()) for cell in row) + r" \\" for row in table.rows]
    lines += [r"\bottomrule", r"\end{tabular}", *(rf"\par {_tex(note)}" for note in table.notes), r"\end{table}", ""]
    return "\n".join(lines)


def html_table(table: TableData) -> str:
    """Return a table as a part of a page."""
    head = "".join(f"<th>{escape(text)}</th>" for text in table.heads)
    body = "".join("<tr>" + "".join(map(_td, row)) + "</tr>" for row in table.rows)
    notes = "".join(f"<li>{escape(note)}</li>" for note in table.notes)
    return f"<h2>{escape(table.title)}</h2><table><tr>{head}</tr>{body}</table><ul>{notes}</ul>"


def _td(cell: Cell) -> str:
    paper = f'<br><span class="paper">paper {escape(cell.paper)}</span>' if cell.paper else ""
    missing = ' class="missing"' if cell.ours == NOT_RUN else ""
    return f"<td{missing}>{escape(cell.ours)}{paper}</td>"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _tex(text: str) -> str:
    return text.translate(_LATEX)


def known_mean(values: Sequence[float | None]) -> float | None:
    """Return the mean of the numbers that are known; None without any."""
    known = [value for value in values if value is not None and math.isfinite(value)]
    return float(np.mean(known)) if known else None
