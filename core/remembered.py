"""What checks of files found, kept between runs by path, size and modification time.

A file in the user's cache folder holds it. Where no such folder can be read or written, as with a read-only home, the
checks are made again in each run, and nothing else changes.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from .cache_folder import cache_folder
from .model import Model

#: Size [bytes] and modification time [ns] of an unchanged file; None where there is none.
Stamp = tuple[int, int] | None


class Checked(Model):
    """The outcome of the check of one file."""

    refused: str | None = Field(default=None, description="Why the file cannot be used; None where it can")
    remarks: tuple[str, ...] = Field(default=(), description="What of the file is lost or changed")
    others: tuple[Path, ...] = Field(default=(), description="Further files that the outcome depends on")
    facts: dict[str, Any] = Field(default={}, description="JSON data about the file")


class _Entry(Model):
    stamps: dict[str, Stamp]
    outcome: Checked


class Remembered:
    """Outcomes of one kind of check, by file; `save` keeps them for the next run."""

    def __init__(self, name: str) -> None:
        self._name, self._changed = name, False
        self._known: dict[str, Any] = {}
        try:
            content = json.loads(_memory_file(name).read_text("utf-8"))
            self._known = content if isinstance(content, dict) else {}
        except (OSError, ValueError, RecursionError, RuntimeError):  # missing, damaged, or no home: checked again
            pass

    def outcome(self, path: Path, check: Callable[[], Checked]) -> Checked:
        """Return the outcome for a file: the remembered one while no file that it depends on has changed."""
        key = str(path.absolute())
        try:
            entry = _Entry.model_validate(self._known.get(key))
            if all(_stamp(Path(name)) == stamp for name, stamp in entry.stamps.items()):
                return entry.outcome
        except ValidationError:  # nothing known, or damaged
            pass
        # The state before the check: a file that changes meanwhile is checked again next time.
        before = _stamp(path)
        outcome = check()
        stamps = {key: before} | {str(other.absolute()): _stamp(other) for other in outcome.others}
        self._known[key] = _Entry(stamps=stamps, outcome=outcome).model_dump(mode="json")
        self._changed = True
        return outcome

    def save(self) -> None:
        """Write what is known, where it has changed and the folder can be written."""
        if not self._changed:
            return
        try:
            path = _memory_file(self._name)
            known = {name: entry for name, entry in self._known.items() if _stamp(Path(name)) is not None}
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
                json.dump(known, file, sort_keys=True)
            Path(file.name).replace(path)
        except (OSError, RuntimeError):
            return
        self._changed = False


def _memory_file(name: str) -> Path:
    return cache_folder() / f"checked-{name}.json"


def _stamp(path: Path) -> Stamp:
    try:
        status = path.stat()
    except (OSError, ValueError):
        return None
    return status.st_size, status.st_mtime_ns
