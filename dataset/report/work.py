"""Cards of what it cost: time by stage, size by kind of file, failures, and what was drawn again."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.user_text import counted, sized
from ..format import layout
from .build_record import BuildRecord
from .histograms import number_text
from .summary import Summary
from .tables import card, facts_table, long_table, numbers_table, percent_text

#: Bytes of a megabyte.
_MEGABYTE = 1e6


def work(summary: Summary) -> Iterator[str]:
    """Yield cards about time, size and failures."""
    if summary.record is not None:
        yield _stages(summary.record)
        yield _failures(summary.record)
    else:
        yield card("stages", "Time by stage", note=f"No attempt is in a {layout.LOG}: builds write it.")
    if summary.sizes:
        yield _sizes(summary)


def _stages(record: BuildRecord) -> str:
    total = sum(record.stages.values())
    rows = [
        (stage, number_text(seconds / record.made), number_text(seconds), percent_text(seconds, total))
        for stage, seconds in sorted(record.stages.items(), key=lambda item: -item[1])
    ]
    if rows:
        rows.append(("all", number_text(total / record.made), number_text(total), percent_text(total, total)))
    note = f"of {counted(record.made, 'scene')}, as the last attempt at each took; {counted(record.hosts, 'machine')}"
    return card("stages", "Time by stage", numbers_table(("stage", "s a scene", "s in all", "of all"), rows), note=note)


def _failures(record: BuildRecord) -> str:
    facts = [
        ("attempts", f"{record.attempts:,}"),
        ("scenes made", f"{record.made:,}"),
        ("of these after a failure", f"{record.again:,}"),
        ("scenes failed", f"{len(record.failed):,}"),
        ("highest memory of a process [MB]", number_text(record.peak)),
    ]
    listed = long_table(("scene", "why"), list(record.failed.items()), layout.LOG) if record.failed else ""
    return card("failures", "Attempts and failures", facts_table(facts), listed, wide=bool(record.failed))


def _sizes(summary: Summary) -> str:
    total = sum(summary.sizes.values())
    rows = [
        (kind, number_text(size / _MEGABYTE), number_text(size / _MEGABYTE / summary.scenes), percent_text(size, total))
        for kind, size in sorted(summary.sizes.items(), key=lambda item: (-item[1], item[0]))
    ]
    table = numbers_table(("files", "MB", "MB a scene", "of all"), rows)
    return card("sizes", "Size by kind of file", table, note=f"{sized(total)} by {layout.CHECKSUMS} of the scenes")


def drawn_again(summary: Summary) -> Iterator[str]:
    """Yield a card about what did not fit or rest, and was drawn again."""
    piles = summary.piles
    facts = [
        ("scenes with a pile", f"{piles.scenes:,} of {summary.scenes:,}"),
        ("piles that did not come to rest", f"{piles.drawn_again:,}"),
        ("scenes that stand apart, as no pile came to rest", f"{piles.given_up:,}"),
        ("falls that were drawn again", f"{piles.fell_again:,}"),
        ("contents that did not fit their vessel", f"{summary.redrawn:,}"),
        ("places of all objects, as they did not fit on the table", f"{summary.placed_again:,}"),
    ]
    yield card("piles", "What was drawn again", facts_table(facts))
