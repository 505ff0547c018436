"""Cards of where things come from: asset files, their use and licences, files passed over, splits, software."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import get_args

from ...core.passed_over import Finding
from ...procedural.scene.splits import Split
from ..format import layout
from ..format.split_file import SplitsFile
from .summary import Summary
from .tables import card, counts_table, facts_table, long_table, percent_text


def sources(summary: Summary) -> Iterator[str]:
    """Yield the cards."""
    yield from _assets(summary)
    yield from _findings(summary)
    if summary.splits is not None:
        yield _splits(summary.splits)
    yield card("software", "Software", facts_table(sorted(summary.head.versions.items())), note=summary.head.backend)


def _assets(summary: Summary) -> Iterator[str]:
    """Yield cards of the files that scenes use, those of most use first, and of licences."""
    if summary.assets:
        rows = [(item.source, item.licence, f"{count:,}") for item, count in summary.assets.items()]
        table = long_table(("file", "licence", "scenes"), rows, layout.DATASET)
        yield card("assets", "Asset files", table, note="pictures, maps and meshes by the scenes that use them")
    if summary.head.meshes:
        known = {record.file: record for record in summary.head.meshes}
        ordered = sorted(known, key=lambda file: (-summary.meshes[file], file))
        rows = [(file, known[file].category, known[file].licence, f"{summary.meshes[file]:,}") for file in ordered]
        table = long_table(("file", "category", "licence", "objects"), rows, layout.DATASET)
        unused = sum(not summary.meshes[file] for file in known)
        yield card("meshes", "Mesh files", table, note=f"{len(known):,} to draw from, {unused:,} of them unused")
    licences = _licences(summary)
    if licences:
        yield card("licences", "Licences", counts_table(licences), note="files that scenes use, and meshes in them")


def _licences(summary: Summary) -> Counter[str]:
    """Return how many files of each licence are used."""
    used = [record.licence for record in summary.head.meshes if summary.meshes[record.file]]
    return Counter([item.licence for item in summary.assets] + used)


def _findings(summary: Summary) -> Iterator[str]:
    for anchor, title, used in (("passed-over", "Files passed over", False), ("remarks", "Used with a remark", True)):
        some: list[Finding] = [item for item in summary.head.findings if item.used == used]
        if some:
            rows = [(item.folder, item.path, item.reason) for item in some]
            table = long_table(("folder", "file", "why"), rows, layout.DATASET)
            yield card(anchor, title, table, note=f"{len({(item.folder, item.path) for item in some}):,} files")


def _splits(splits: SplitsFile) -> str:
    counts = {name: len(getattr(splits, name)) for name in get_args(Split)}
    total = sum(counts.values())
    facts = [(name, f"{count:,} ({percent_text(count, total)})") for name, count in counts.items()]
    unseen = [
        *splits.unseen_families,
        *(f"{folder}: {file}" for folder in splits.unseen_assets for file in splits.unseen_assets[folder]),
    ]
    listed = long_table(("only in test scenes",), [(name,) for name in unseen], layout.SPLITS) if unseen else ""
    return card("splits", "Splits", facts_table(facts), listed, note="scenes that the data set is meant to hold")
