"""Checks of an output folder, made before anything is rendered or written into it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from ..core.atomic_io import is_leftover, is_written_by_another
from ..core.errors import InputError
from ..core.model import differences
from ..core.setting_errors import shortened
from .format import layout
from .format.dataset_file import DatasetFile, read_head

#: What a user can do about scenes that were made from something else.
_REMEDY = "the requested one, or --overwrite of all its scenes, or another --out"
#: Most differences that one error line lists.
_MAX_LISTED = 6


def check_folder(root: Path) -> None:
    """Raise InputError where a folder holds anything but a data set that this version reads."""
    if not root.is_dir():
        raise InputError(root, "a folder to write to", "a file")
    names = {entry.name for entry in root.iterdir() if entry.name != layout.LOCK and not is_leftover(entry.name)}
    if names and layout.DATASET not in names:
        raise InputError(root, "an empty folder or a glassware data set", f"something else ({min(names)}, ...)")
    if names:
        read_head(root)


def check_output(root: Path, head: DatasetFile, scenes: Collection[int]) -> None:
    """Raise InputError where scenes cannot be written into a folder; nothing is changed.

    Parameters
    ----------
    root : Path
        The output folder.
    head : DatasetFile
        The head that its data set is to have.
    scenes : collection of int
        The scenes to be written. Scenes that stay must have the same seed and settings.
    """
    if root.exists():
        check_folder(root)
    path = root / layout.DATASET
    others = set(layout.scene_ids(root)) - set(scenes) or is_written_by_another(root / layout.SCENES)
    if not (path.exists() and others):
        return
    found, where = read_head(root), f"{path}: a scene that this run does not replace was made with another"
    if found.seed != head.seed:
        raise InputError(f"{where} seed", str(head.seed), found.seed)
    for name, expected, value in differences(head.config, found.config):
        raise InputError(f"{where} setting {name}", _set_to(expected), _set_to(value))
    if found.files != head.files:
        raise InputError(f"{where} --write", ",".join(head.files) or "none", ",".join(found.files) or "none")


def check_request(root: Path, seed: int, config: dict) -> None:
    """Raise InputError where a folder's data set has another seed or other settings; no worker is needed for this."""
    path = root / layout.DATASET
    if path.exists():
        found = read_head(root)
        check_same_head(path, found, found.model_copy(update={"seed": seed, "config": config}))


def check_same_head(
    where: Path, found: DatasetFile, head: DatasetFile, expected: str = _REMEDY, other: str = "requested"
) -> None:
    """Raise InputError that lists how the head of a data set differs from another, which the line calls `other`."""
    listed = [f"{name} {_set_to(value)} ({other}: {_set_to(wanted)})" for name, wanted, value in _changes(found, head)]
    if listed:
        rest = f" and {len(listed) - _MAX_LISTED} more" if len(listed) > _MAX_LISTED else ""
        raise InputError(where, expected, ", ".join(listed[:_MAX_LISTED]) + rest)


def _set_to(value: object) -> str:
    """Return the value of a setting in words; None follows from others, or an earlier version lacks it."""
    return "not set" if value is None else shortened(value)


def _changes(found: DatasetFile, head: DatasetFile) -> Iterator[tuple[str, object, object]]:
    for field in ("name", "seed", "config", "backend", "versions"):
        yield from differences(getattr(head, field), getattr(found, field), "" if field == "config" else field)
    if found.files != head.files:
        yield "write", ",".join(head.files) or "none", ",".join(found.files) or "none"
    wanted, there = (record.developed and record.developed.model_dump(mode="json") for record in (head, found))
    yield from differences(wanted, there, "developed")
    if "assets" in found.hashes and found.hashes.get("assets") != head.hashes.get("assets"):
        yield "hash of the assets", head.hashes.get("assets"), found.hashes["assets"]
