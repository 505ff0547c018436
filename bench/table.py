"""The table that every command here prints, and the same figures as JSON for other programs."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console
from rich.table import Table

#: Version of the JSON files; it changes when an old reader would be misled.
BENCH_SCHEMA = "glassware/bench/1"
#: Significant digits of printed numbers; the JSON has all of them.
_DIGITS = 4


@dataclass(frozen=True)
class Row:
    """One figure. What does not apply stays None, and a column in which nothing applies is not printed."""

    name: str
    measured: float | None
    unit: str = ""
    expected: float | None = None  #: closed form
    error: float | None = None  #: distance of `measured` from `expected`, in the unit of `bound`
    bound: float | None = None  #: what `error`, or `measured` where nothing is expected, must keep to
    peer: float | None = None  #: the same figure of somebody else's program
    ratio: float | None = None  #: how many times better than the peer, or the share of the bound that is used
    ok: bool | None = None  #: whether the bound is kept; None where there is none
    note: str = ""


def report(title: str, rows: Sequence[Row], json_file: Path | None = None, **facts: object) -> int:
    """Print the rows, write them where asked, and return the exit code: 1 if any row is not ok.

    Parameters
    ----------
    title : str
        What was measured.
    rows : sequence of Row
        The figures.
    json_file : Path, optional
        Where to write the same as JSON, with the machine, the command and the time.
    **facts
        What else a reader must know to repeat it, such as sizes and versions.
    """
    console = Console()
    if not console.is_terminal:
        # A file has no width: notes stay on their lines.
        console = Console(width=200)
    console.print(_printed(title, rows))
    for name, value in facts.items():
        console.print(f"{name}: {value}", markup=False, highlight=False)
    console.print(machine(), markup=False, highlight=False)
    if json_file is not None:
        _write(title, rows, json_file, facts)
    return int(any(row.ok is False for row in rows))


def machine() -> str:
    """Return processor, usable cores, system and Python in one line."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        models = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model n")]
        cpu = models[0] if models else cpu
    return f"{cpu}, {cores()} cores, {platform.system()}, Python {platform.python_version()}"


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _printed(title: str, rows: Sequence[Row]) -> Table:
    table = Table(title=title, title_justify="left")
    # `name` and `measured` always; others where a row has them.
    names = [f.name for f in fields(Row) if f.name in ("name", "measured") or any(_has(row, f.name) for row in rows)]
    for name in names:
        table.add_column(name, justify="left" if name in ("name", "unit", "note") else "right")
    for row in rows:
        style = "red" if row.ok is False else None
        table.add_row(*(_text(getattr(row, name)) for name in names), style=style)
    return table


def _has(row: Row, name: str) -> bool:
    return getattr(row, name) not in (None, "")


def _text(value: object) -> str:
    match value:
        case None:
            return ""
        case bool():
            return "yes" if value else "NO"
        case float():
            return f"{value:.{_DIGITS}g}"
    return str(value)


def _write(title: str, rows: Sequence[Row], path: Path, facts: dict[str, object]) -> None:
    content = {
        "schema": BENCH_SCHEMA,
        "title": title,
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "machine": machine(),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "facts": facts,
        "rows": [asdict(row) for row in rows],
    }
    text = json.dumps(content, indent=2, sort_keys=True, default=str, allow_nan=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "\n", "utf-8")
