"""Parts of the page that are tables, and the cards that hold them. All text of files is escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from ...core.html import html_table
from .charts import svg_fraction

#: Most rows of a table [1]; what is beyond them is counted in a last row.
MOST_ROWS = 60


def section(anchor: str, title: str, *parts: str) -> str:
    """Return a section with its heading."""
    return f'<section id="{anchor}"><h2>{escape(title)}</h2>{"".join(parts)}</section>'


def cards(parts: Iterable[str]) -> str:
    """Return cards beside and below each other; nothing where there are none."""
    found = "".join(parts)
    return f'<div class="cards">{found}</div>' if found else ""


def card(anchor: str, title: str, *parts: str, note: str = "", unit: str = "", wide: bool = False) -> str:
    """Return a card: a heading with a unit, a note in small letters, and parts."""
    shown = f' <span class="unit">[{escape(unit)}]</span>' if unit else ""
    below = f'<p class="soft">{escape(note)}</p>' if note else ""
    kind = "card wide" if wide else "card"
    return f'<div class="{kind}" id="{anchor}"><h3>{escape(title)}{shown}</h3>{below}{"".join(parts)}</div>'


def numbers_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table whose columns but the first are numbers."""
    return f'<div class="numbers">{html_table(header, rows)}</div>'


def facts_table(facts: Sequence[tuple[str, object]]) -> str:
    """Return a table of names and what each is, without a heading."""
    rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in facts)
    return f'<div class="numbers"><table>{rows}</table></div>'


def long_table(header: Sequence[str], rows: Sequence[Sequence[object]], place: str) -> str:
    """Return a table of at most `MOST_ROWS` rows; a line says how many more there are, and in which file."""
    more = len(rows) - MOST_ROWS
    rest = f'<p class="soft">and {more:,} more, all in {escape(place)}</p>' if more > 0 else ""
    return html_table(header, rows[:MOST_ROWS]) + rest


def counts_table(counts: Mapping[str, int]) -> str:
    """Return a table of names by how often they were counted, with bars; rare ones may share the last row."""
    total = sum(counts.values())
    rows = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    if len(rows) > MOST_ROWS:
        rest = rows[MOST_ROWS - 1 :]
        rows = [*rows[: MOST_ROWS - 1], (f"{len(rest):,} others", sum(count for _, count in rest))]
    body = "".join(
        f"<tr><td>{escape(name)}</td><td>{count:,}</td><td>{percent_text(count, total)}</td>"
        f"<td>{svg_fraction(count / total)}</td></tr>"
        for name, count in rows
    )
    return f'<div class="numbers"><table>{body}</table></div>'


def percent_text(count: float, total: float) -> str:
    """Return a fraction in percent, such as ``12.5 %``; a dash of nothing."""
    return f"{100.0 * count / total:.1f} %" if total else "-"
