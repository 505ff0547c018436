"""The main loop of a build: submit scenes, collect their outcomes, try each failed scene once more in a new process."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from .build_log import BuildLog
from .messages import Attempt
from .plan import first_fault

#: Attempts at a scene before it is listed as failed.
MAX_ATTEMPTS = 2


class Executor(Protocol):
    """Renders scenes: in processes on this machine, or as tasks on a cluster."""

    def submit(self, scene: int, fresh: bool = False) -> None:
        """Queue a scene; `fresh` requires a process that has rendered no scene before."""
        ...

    def events(self) -> Iterator[Attempt | int]:
        """Yield outcomes, and the number of a scene each time one of its views is done, until the queue is empty."""
        ...


class Progress(Protocol):
    """Displays how far a build has got."""

    def view_done(self) -> None:
        """Count a rendered view."""
        ...

    def attempt_done(self, attempt: Attempt, final: bool) -> None:
        """Count the outcome of an attempt; `final` means that the scene is not tried again."""
        ...


@dataclass(frozen=True)
class Result:
    """Outcome of a build."""

    made: tuple[int, ...]
    failed: dict[int, str]  #: reason by scene


def run(root: Path, scenes: Iterable[int], executor: Executor, log: BuildLog, progress: Progress) -> Result:
    """Render scenes; each failed scene is tried once more in a new process.

    Raises
    ------
    OSError
        Where the output accepts no more files: the build ends at once.
    """
    attempts: dict[int, int] = {}
    made, failed = [], {}
    for scene in scenes:
        executor.submit(scene)
    for event in executor.events():
        if not isinstance(event, Attempt):
            progress.view_done()
            continue
        number = attempts[event.scene] = attempts.get(event.scene, 0) + 1
        attempt = _checked_on_disk(root, event)
        log.add_attempt(attempt, number)
        if attempt.state == "unwritable":
            raise OSError(attempt.errno, attempt.reason.partition("] ")[2] or attempt.reason)
        retry = attempt.state == "failed" and number < MAX_ATTEMPTS
        progress.attempt_done(attempt, final=not retry)
        if retry:
            executor.submit(attempt.scene, fresh=True)
        elif attempt.state == "failed":
            failed[attempt.scene] = attempt.reason
        else:
            made.append(attempt.scene)
    return Result(tuple(made), failed)


def _checked_on_disk(root: Path, attempt: Attempt) -> Attempt:
    """Return the outcome, corrected by the files: a worker may die after its scene is complete but before reporting."""
    worker_died = attempt.state == "failed" and attempt.reason.startswith("the worker")
    if worker_died and first_fault(root, attempt.scene, contents=True) is None:
        return attempt.model_copy(update={"state": "made"})
    return attempt
