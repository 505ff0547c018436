"""Which data set a folder holds."""

from __future__ import annotations

from pathlib import Path

from ...core.errors import InputError
from ..format import layout as ours
from . import bop, bop_shards, cleargrasp, clearpose, dreds, keypose, syn_todd, todd, trans10k, transcg, ttd
from .layout import Layout, folders_with_names
from .source_view import Collection

LAYOUTS: dict[str, Layout] = {
    module.LAYOUT.name: module.LAYOUT
    for module in (
        keypose,
        cleargrasp,
        todd,
        clearpose,
        syn_todd,
        trans10k,
        transcg,
        ttd,
        dreds,
        bop,
        bop_shards,
    )
}


def open_source(root: Path) -> tuple[Layout, Collection]:
    """Return the layout of a folder, and its views, found by the names of its files.

    Raises
    ------
    InputError
        Where it holds no data set that is known, more than one, one of ours, or nothing that can be read.
    """
    found = _units(root)
    if not found:
        known = ", ".join(layout.title for layout in LAYOUTS.values())
        raise InputError(root, f"a data set of one of {known}", "none of them")
    if len(found) > 1:
        places = " and ".join(f"{LAYOUTS[name].title} ({units[0]})" for name, units in found.items())
        raise InputError(root, "one data set, such as one of its folders", f"{len(found)}: {places}")
    ((name, units),) = found.items()
    layout = LAYOUTS[name]
    collection = layout.open(root, units)
    if not collection.entries:
        raise InputError(root, f"views of {layout.title}: {layout.expected}", _nothing(collection))
    return layout, collection


def _nothing(collection: Collection) -> str:
    if not collection.left_out:
        return "none"
    first = collection.left_out[0]
    return f"none complete of {len(collection.left_out)}; the first, {first.name}: {first.reason}"


def _units(root: Path) -> dict[str, list[Path]]:
    """Return the folders with views by the names of their layouts."""
    if not root.is_dir():
        raise InputError(root, "the folder of a data set", "a file" if root.is_file() else "none")
    if (root / ours.DATASET).is_file():
        raise InputError(root, "another project's data set", "one of glassware, which needs no conversion")
    found: dict[str, list[Path]] = {}
    walk = folders_with_names(root)
    item = next(walk, None)
    while item is not None:
        folder, names = item
        kinds = [layout.name for layout in LAYOUTS.values() if layout.is_unit(names)]
        for kind in kinds:
            found.setdefault(kind, []).append(folder)
        try:
            item = walk.send(bool(kinds))
        except StopIteration:
            item = None
    return found
