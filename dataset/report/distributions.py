"""Cards of what was drawn: distributions of numbers, and counts of names."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.html import html_table
from ...core.user_text import counted
from .charts import svg_histogram
from .histograms import statistics
from .quantities import QUANTITIES, TOPICS, Quantity
from .summary import Summary
from .tables import card, counts_table, percent_text


def distributions(summary: Summary, section: str) -> Iterator[str]:
    """Yield a card for each quantity of a section that has values."""
    for key, quantity in QUANTITIES.items():
        values = summary.numbers.get(key)
        if quantity.section == section and values is not None and values.size:
            yield _distribution(key, quantity, values.astype(np.float64) * quantity.scale)


def counts(summary: Summary, section: str) -> Iterator[str]:
    """Yield a card for each topic of a section that something was counted in."""
    for key, (where, title, noun, more) in TOPICS.items():
        names = summary.names.get(key)
        if where == section and names:
            note = f"{counted(names.total(), noun)}{more}" if noun else more
            yield card(key, title, counts_table(names), _turbid(summary) if key == "liquids" else "", note=note)


def _turbid(summary: Summary) -> str:
    return f'<p class="soft">{summary.layered} with several liquids, {summary.turbid} with a turbid one</p>'


def _distribution(key: str, quantity: Quantity, values: np.ndarray) -> str:
    """Return the card of a quantity: histogram, numbers, and the paper's range."""
    names, texts = zip(*statistics(values), strict=True)
    parts = [svg_histogram(quantity, values), f'<div class="statistics">{html_table(names, [texts])}</div>']
    if quantity.paper is not None:
        low, high = quantity.paper
        inside = percent_text(float(np.mean((values >= low) & (values <= high))), 1.0)
        limits = f"{low} to {high}" if low else f"up to {high}"
        parts.append(f'<p class="soft">Syn-TODD: {limits}; here {inside} of the scenes</p>')
    return card(key, quantity.title, *parts, note=quantity.note, unit=quantity.unit)
