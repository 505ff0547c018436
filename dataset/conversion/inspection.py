"""What is in another project's data set: counts, what its views have, what is wrong in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...core.stopping import check_stop
from ...core.user_text import counted
from ..format.conversion import LABEL_KINDS, LabelKind
from ..preview.contact_sheet import chosen_views
from ..readers.layout import Layout
from ..readers.source_view import Collection, Entry, LeftOut, SourceView, kinds_of
from .pairs import pair_agreement

#: Most lines about what is wrong.
MOST_LINES = 40
#: Most names that a line lists.
_MOST_NAMES = 12
#: Passes on the views one by one, and may show how many are done of a total.
Track = Callable[[Iterable[Entry], int], Iterable[Entry]]


@dataclass(frozen=True, eq=False)
class Inspection:
    """What was seen of a data set."""

    read: int  #: views that were read, of all
    has: Counter[LabelKind]  #: views of these that have each kind of label
    sizes: Counter[tuple[int, int]]  #: width and height of these pictures [px]
    categories: Counter[str]  #: objects in these views
    pairs: tuple[tuple[float, float], ...]  #: `pairs.pair_agreement` of the views that are pairs with depth
    damaged: tuple[LeftOut, ...]  #: views that could not be read
    shown: tuple[tuple[str, SourceView], ...]  #: some views, for the contact sheet


def inspect(collection: Collection, most: int, rows: int, track: Track = lambda done, _: done) -> Inspection:
    """Read some views of a data set, evenly spaced over it.

    Parameters
    ----------
    collection : Collection
        Its views.
    most : int
        Most views that are read; 0: all.
    rows : int
        Most views that are kept for a contact sheet.
    track : callable, optional
        (views, their number) -> the same, to show progress.
    """
    entries = collection.entries
    picked = [entries[i] for i in chosen_views(len(entries), most or len(entries))]
    wanted = {picked[i].name for i in chosen_views(len(picked), rows)} if rows else set()
    has: Counter[LabelKind] = Counter()
    sizes: Counter[tuple[int, int]] = Counter()
    categories: Counter[str] = Counter()
    damaged, shown, pairs, read = [], [], [], 0
    for entry in track(picked, len(picked)):
        check_stop()
        try:
            view = entry.read()
        except InputError as error:  # a finding here: what is wrong in the data set is what was asked for
            damaged.append(LeftOut(entry.name, str(error)))
            continue
        read += 1
        has.update(kinds_of(view))
        sizes[(view.picture.shape[1], view.picture.shape[0])] += 1
        categories.update(item.category for item in view.objects or ())
        pairs += filter(None, [pair_agreement(view)])
        if entry.name in wanted:
            shown.append((entry.name, view))
    return Inspection(read, has, sizes, categories, tuple(pairs), tuple(damaged), tuple(shown))


def lines_of(root: Path, layout: Layout, collection: Collection, seen: Inspection) -> list[str]:
    """Return what is known of a data set, as lines of text."""
    entries = collection.entries
    scenes, left_out = len({entry.scene for entry in entries}), collection.left_out
    splits = Counter(entry.split or "no split" for entry in entries)
    lines = [
        f"{root}: {layout.title} (layout {layout.name})",
        f"licence: {layout.licence}",
        f"views: {len(entries)} in {counted(scenes, 'scene')}, {_listed(splits)}",
        f"read: {seen.read} of them; {', '.join(f'{w} x {h} px ({n})' for (w, h), n in seen.sizes.most_common(6))}",
    ]
    for kind in LABEL_KINDS:
        count = seen.has[kind]
        how_many = "none" if not count else "every view" if count == seen.read else f"{count} of {seen.read}"
        lines.append(f"  {kind:13} {how_many}")
    if seen.categories:
        lines.append(f"objects in these views: {_listed(seen.categories)}")
    if seen.pairs:
        by_depth, unmoved = np.median(np.array(seen.pairs), axis=0)
        lines.append(f"pairs: left and right correlate by {by_depth:.2f} through the depth, {unmoved:.2f} without it")
        if by_depth <= unmoved:
            lines.append("  so the right picture, the depth or the baseline is not what it is said to be")
    if collection.classes:
        lines.append(f"classes of pixels: {', '.join(collection.classes)}")
    lines += [f"note: {note}" for note in collection.notes]
    wrong = [*left_out, *seen.damaged]
    if not wrong:
        return [*lines, "left out: nothing"]
    lines.append(
        f"left out: {len(left_out)} incomplete, {len(seen.damaged)} of {seen.read + len(seen.damaged)} damaged"
    )
    lines += [f"  {item.name}: {item.reason}" for item in wrong[:MOST_LINES]]
    if len(wrong) > MOST_LINES:
        lines.append(f"  and {len(wrong) - MOST_LINES} more")
    return lines


def _listed(counts: Counter[str]) -> str:
    names: Sequence[tuple[str, int]] = counts.most_common()
    shown = ", ".join(f"{name} {count}" for name, count in names[:_MOST_NAMES])
    return shown + (f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else "")
