"""``build.jsonl``: what happened, a line of JSON each: starts and ends of builds, and every try at a scene."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from ..format.layout import LOG
from .messages import Attempt


class Journal:
    """The log of a data set, open for adding lines. Each line is on the disk before the build goes on."""

    def __init__(self, root: Path) -> None:
        path = root / LOG
        # A line that a killed build had begun must not swallow the next one.
        torn = path.exists() and path.stat().st_size > 0 and not _ends_line(path)
        # Without a buffer: what a full disk refuses is not tried again when the file is closed.
        self._file = path.open("ab", buffering=0)
        if torn:
            self._file.write(b"\n")

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def note(self, event: str, **facts: object) -> None:
        """Add a line: an event and its facts, as JSON data."""
        line = {"event": event, "time": datetime.now(UTC).isoformat(timespec="milliseconds"), **facts}
        self._file.write(json.dumps(line, sort_keys=True, allow_nan=False).encode() + b"\n")
        os.fsync(self._file.fileno())

    def attempt(self, attempt: Attempt, number: int) -> None:
        """Add the outcome of a try at a scene, its first or a later one."""
        self.note("scene", attempt=number, **attempt.model_dump(mode="json"))


def lines(root: Path) -> Iterator[dict]:
    """Go through the whole lines of a data set's log; what a killed build left torn is passed over."""
    path = root / LOG
    if not path.exists():
        return
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            try:
                data = json.loads(line)
            except ValueError:
                continue
            if isinstance(data, dict):
                yield data


def last_attempts(root: Path) -> dict[int, Attempt]:
    """Return the last try at each scene that the log has, by scene."""
    found = {}
    for data in lines(root):
        if data.get("event") == "scene":
            facts = {name: value for name, value in data.items() if name in Attempt.model_fields}
            try:
                attempt = Attempt.model_validate(facts)
            except ValidationError:  # of a version to come: not ours to read
                continue
            found[attempt.scene] = attempt
    return found


def _ends_line(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"
