"""``build.jsonl``: the log of a data set, one JSON object a line: starts and ends of builds, and every attempt."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from ..format.layout import LOG
from .messages import Attempt


class BuildLog:
    """The log of a data set, open for appending. Each line is on the disk before the build continues."""

    def __init__(self, root: Path) -> None:
        path = root / LOG
        # The unfinished line of a killed build must not swallow the next one.
        unfinished = path.exists() and path.stat().st_size > 0 and not _ends_with_newline(path)
        # Unbuffered: what a full disk refuses is not tried again when the file is closed.
        self._file = path.open("ab", buffering=0)
        if unfinished:
            self._file.write(b"\n")

    def __enter__(self) -> BuildLog:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, event: str, **facts: object) -> None:
        """Append a line: an event and its facts, as JSON data."""
        line = {"event": event, "time": datetime.now(UTC).isoformat(timespec="milliseconds"), **facts}
        self._file.write(json.dumps(line, sort_keys=True, allow_nan=False).encode() + b"\n")
        os.fsync(self._file.fileno())

    def add_attempt(self, attempt: Attempt, number: int) -> None:
        """Append the outcome of the first or a later attempt at a scene."""
        self.add("scene", attempt=number, **attempt.model_dump(mode="json"))


def read_log(root: Path) -> Iterator[dict]:
    """Yield the lines of a data set's log; a line that a killed build left unfinished is skipped."""
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


def attempts(root: Path) -> Iterator[Attempt]:
    """Yield the attempts at scenes in the log, in its order."""
    for data in read_log(root):
        if data.get("event") == "scene":
            facts = {name: value for name, value in data.items() if name in Attempt.model_fields}
            try:
                yield Attempt.model_validate(facts)
            except ValidationError:  # written by a later version
                continue


def last_attempts(root: Path) -> dict[int, Attempt]:
    """Return the last attempt at each scene in the log, by scene."""
    return {attempt.scene: attempt for attempt in attempts(root)}


def _ends_with_newline(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"
