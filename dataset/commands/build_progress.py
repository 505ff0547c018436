"""How a build goes: a bar on a terminal, a line a scene elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ...core.stopping import check_stop
from ..builds.messages import Attempt


class BuildProgress:
    """Scenes, views a second, time left and failures."""

    def __init__(self, console: Console, total: int) -> None:
        self._console, self._total = console, total
        self._start = perf_counter()
        self._views = self._scenes = self._failures = 0
        self._bar: Progress | None = None

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Show the bar inside, on a terminal."""
        if not self._console.is_terminal:
            yield
            return
        columns = (
            TextColumn("scenes"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("failed {task.fields[failures]}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        # The estimate of the time left looks back over many scenes: they differ.
        with Progress(*columns, console=self._console, speed_estimate_period=3600.0) as self._bar:
            self._bar.add_task("scenes", total=self._total, rate="", failures=0)
            yield
        self._bar = None

    def view(self) -> None:
        """Take note of a view."""
        check_stop()
        self._views += 1
        self._update()

    def scene(self, attempt: Attempt, last: bool) -> None:
        """Take note of the outcome of a try."""
        check_stop()
        self._scenes += last
        self._failures += last and attempt.state != "made"
        self._update()
        if attempt.state != "made":
            self._say(f"scene {attempt.scene} failed{'' if last else ', is tried again'}: {attempt.reason}")
        elif self._bar is None:
            self._say(f"scene {attempt.scene} in {attempt.total:.1f} s: {self._scenes}/{self._total}, {self._state()}")

    def _state(self) -> str:
        seconds = perf_counter() - self._start
        left = seconds / max(1, self._scenes) * (self._total - self._scenes)
        return f"{self._rate()}, failed {self._failures}, left {_clock(left)}"

    def _rate(self) -> str:
        return f"{self._views / max(1e-3, perf_counter() - self._start):.2f} views/s"

    def _update(self) -> None:
        if self._bar is not None:
            task = self._bar.task_ids[0]
            self._bar.update(task, completed=self._scenes, rate=self._rate(), failures=self._failures)

    def _say(self, line: str) -> None:
        (self._bar.console if self._bar is not None else self._console).print(
            line, markup=False, highlight=False, soft_wrap=True
        )


def _clock(seconds: float) -> str:
    minutes, whole = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{whole:02d}"
