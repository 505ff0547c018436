"""The loop of a build: scenes go out, outcomes come back, each failure is tried once more in a fresh process."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from .journal import Journal
from .messages import Attempt
from .plan import first_fault

#: How often a scene is tried before it is listed as failed.
TRIES = 2


class Makers(Protocol):
    """Whoever makes scenes: processes of this machine, or a cluster."""

    def submit(self, scene: int, fresh: bool = False) -> None:
        """Add a scene; `fresh` wants a process that has made none before."""
        ...

    def events(self) -> Iterator[Attempt | int]:
        """Go through outcomes, and scenes of which a view is done, till nothing is left."""
        ...


class Show(Protocol):
    """Who shows how a build goes."""

    def view(self) -> None:
        """Take note of a view that is done."""
        ...

    def scene(self, attempt: Attempt, last: bool) -> None:
        """Take note of the outcome of a try; `last` says that no other follows."""
        ...


@dataclass(frozen=True)
class Result:
    """How a build went."""

    made: tuple[int, ...]
    failed: dict[int, str]  #: reason by scene


def run(root: Path, scenes: Iterable[int], makers: Makers, journal: Journal, show: Show) -> Result:
    """Make scenes; each failed one is tried once more in a fresh process.

    Raises
    ------
    OSError
        Where the output takes no more files: the build ends at once.
    """
    tries: dict[int, int] = {}
    made, failed = [], {}
    for scene in scenes:
        makers.submit(scene)
    for event in makers.events():
        if not isinstance(event, Attempt):
            show.view()
            continue
        number = tries[event.scene] = tries.get(event.scene, 0) + 1
        attempt = _settled(root, event)
        journal.attempt(attempt, number)
        if attempt.state == "unwritable":
            raise OSError(attempt.errno, attempt.reason.partition("] ")[2] or attempt.reason)
        again = attempt.state == "failed" and number < TRIES
        show.scene(attempt, last=not again)
        if again:
            makers.submit(attempt.scene, fresh=True)
        elif attempt.state == "failed":
            failed[attempt.scene] = attempt.reason
        else:
            made.append(attempt.scene)
    return Result(tuple(made), failed)


def _settled(root: Path, attempt: Attempt) -> Attempt:
    """Return the outcome with what the disk says: a worker may die after its scene was whole and before it said so."""
    lost = attempt.state == "failed" and attempt.reason.startswith("the worker")
    if lost and first_fault(root, attempt.scene, contents=True) is None:
        return attempt.model_copy(update={"state": "made"})
    return attempt
