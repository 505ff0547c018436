"""What a user states about a data set whose files do not say it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...core.errors import InputError
from .source_view import Collection, Entry, SourceView

_ALL, _NONE = "all", "none"


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
