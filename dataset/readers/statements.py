"""What a user states about a data set whose files do not say it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fnmatch import fnmatchcase

from ...core.errors import InputError
from .source_view import Collection, Entry, SourceView

_ALL, _NONE = "all", "none"


def chosen(collection: Collection, patterns: str | None) -> Collection:
    """Return the views of a collection whose names match one of some patterns, such as ``mug_*/*,bottle_0/*``.

    Raises
    ------
    InputError
        Where no name matches.
    """
    if patterns is None:
        return collection
    wanted = [pattern.strip() for pattern in patterns.split(",")]
    entries = tuple(
        entry for entry in collection.entries if any(fnmatchcase(entry.name, pattern) for pattern in wanted)
    )
    if not entries:
        expected = f"patterns of names of views, such as {collection.entries[0].name}"
        raise InputError("--only", expected, f"{patterns}, which none of {len(collection.entries)} matches")
    left_out = tuple(item for item in collection.left_out if any(fnmatchcase(item.name, p) for p in wanted))
    return replace(collection, entries=entries, left_out=left_out, notes=(*collection.notes, f"only {patterns}"))


def stated(collection: Collection, transparent: str | None) -> Collection:
    """Return a collection whose objects are transparent as it was stated, where the data set does not say it.

    Parameters
    ----------
    collection : Collection
        The views.
    transparent : str, optional
        ``all``, ``none``, or the categories of transparent objects with commas between them; None states nothing.
    """
    if transparent is None:
        return collection
    names = {word.strip() for word in transparent.split(",")}
    if "" in names:
        raise InputError("--transparent", "all, none, or categories with commas between them", repr(transparent))
    entries = tuple(replace(entry, read=_reader(entry, names)) for entry in collection.entries)
    return replace(collection, entries=entries)


def _reader(entry: Entry, names: set[str]) -> Callable[[], SourceView]:
    def read() -> SourceView:
        view = entry.read()
        if view.objects is None:
            return view
        objects = tuple(
            item if item.transparent is not None else replace(item, transparent=_is_stated(item.category, names))
            for item in view.objects
        )
        return replace(view, objects=objects)

    return read


def _is_stated(category: str, names: set[str]) -> bool:
    return names == {_ALL} or (names != {_NONE} and category in names)
