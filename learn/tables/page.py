"""The files of a report: Markdown, HTML, LaTeX, JSON and plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from ...core.atomic_io import write_atomically
from ...core.json_file import json_text
from .cells import TableData, html_table, latex, markdown
from .runs import Plan, Result

_STYLE = (
    "body{font-family:sans-serif;margin:2em;max-width:90em}table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.3em .6em;text-align:right}td:first-child{text-align:left}"
    ".paper{color:#777;font-size:85%}.missing{color:#999}ul{font-size:90%;color:#444}svg{width:40em;max-width:100%}"
)


def write_report(
    out: Path, tables: Sequence[TableData], plots: Mapping[str, str], plan: Plan, results: Mapping[str, Result]
) -> None:
    """Write ``tables.md``, ``tables.html``, ``tables.tex``, ``results.json`` and each plot as an SVG file."""
    parts = [*(f"![{name}]({name}.svg)\n" for name in plots)]
    write_atomically(out / "tables.md", "\n".join([*map(markdown, tables), *parts]).encode())
    write_atomically(out / "tables.tex", "\n".join(map(latex, tables)).encode())
    body = "".join(map(html_table, tables)) + "".join(plots.values())
    title = escape(tables[0].title)
    page = f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    write_atomically(out / "tables.html", f"{page}<style>{_STYLE}</style></head><body>{body}</body></html>".encode())
    for name, picture in plots.items():
        write_atomically(out / f"{name}.svg", picture.encode())
    found = {
        "plan": plan.model_dump(mode="json"),
        "rows": {
            name: {"reason": result.reason, "facts": result.facts, "reports": list(result.reports)}
            for name, result in results.items()
        },
    }
    write_atomically(out / "results.json", json_text(found).encode())
