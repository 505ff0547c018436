"""Progress of a scene and of a build: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from ...core.stopping import check_stop
from ...core.stopwatch import Stopwatch
from ...render.frame import LightCheck
from ..builds.messages import Attempt

#: Time between lines about the check of a folder's files [s]: a quick check says nothing.
_CHECK_INTERVAL = 3.0


class Stages:
    """The progress of one scene: a bar or a line per view, and at the end a table of the time of each stage."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self.stopwatch = Stopwatch()  #: seconds by stage
        self._start = perf_counter()
        self._bar: Progress | None = None
        self._done, self._total = 0, 0
        self._shown_at = self._start

    def say(self, line: str) -> None:
        """Print a line."""
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def say_all(self, lines: Iterable[str]) -> None:
        """Print lines."""
        for line in lines:
            self.say(line)

    def checking(self, content: str, done: int, total: int) -> None:
        """Say how many files of a folder have been checked, about every `_CHECK_INTERVAL` seconds."""
        check_stop()
        now = perf_counter()
        if now - self._shown_at > _CHECK_INTERVAL:
            self._shown_at = now
            self.say(f"checking {content}: {done} of {total}")

    @contextmanager
    def progress(self, total: int) -> Iterator[None]:
        """Show the progress of `total` views inside the block."""
        self._done, self._total = 0, total
        if not self._console.is_terminal:
            yield
            return
        columns = (TextColumn("views"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=self._console, transient=True) as bar:
            self._bar = bar
            bar.add_task("views", total=total)
            yield
        self._bar = None

    def advance(self, _view: int) -> None:
        """Count one view as done; raise `KeyboardInterrupt` if a stop signal was received."""
        check_stop()
        self._done += 1
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=self._done)
        else:
            seconds = perf_counter() - self._start
            self._console.print(f"view {self._done}/{self._total} after {seconds:.1f} s", highlight=False)

    def report(self, title: str, views: int) -> None:
        """Print the seconds of each stage, in total and per view."""
        total = perf_counter() - self._start
        table = Table(title=title)
        for column in ("stage", "seconds", "per view", "fraction"):
            table.add_column(column, justify="left" if column == "stage" else "right")
        measured = self.stopwatch.seconds
        known = sum(measured.values())
        for stage, seconds in (*measured.items(), ("other", total - known), ("total", total)):
            table.add_row(stage, f"{seconds:.2f}", f"{seconds / views:.3f}", f"{seconds / total:.1%}")
        self._console.print(table)


def light_line(check: LightCheck) -> str:
    """Return lines about the irradiance cache of a scene and its check against path tracing."""
    largest = max((abs(region.difference) for region in check.regions), default=0.0)
    lines = [
        f"irradiance cache filled at {check.nodes} points; pictures from it differ from path-traced ones by "
        f"{check.difference:+.2%} in the mean of {len(check.regions)} regions, at most {largest:.1%}"
    ]
    for region in check.failed:
        where = f"object {region.id}" + ("" if region.part == "all" else f", {region.part} part")
        if check.mode == "path":
            done = "the whole scene is path traced"
        else:
            done = "its light is path traced" if region.id in check.traced else "within the bound once props are traced"
        lines.append(
            f"{where}: {region.difference:+.1%} (standard error {region.standard_error:.1%}), more than "
            f"{check.bound:.0%}: {done}"
        )
    return "\n".join(lines)


class BuildProgress:
    """The progress of a build: scenes done, views per second, failures and remaining time."""

    def __init__(self, console: Console, total: int) -> None:
        self._console, self._total = console, total
        self._start = perf_counter()
        self._views = self._scenes = self._failures = 0
        self._bar: Progress | None = None

    @contextmanager
    def display(self) -> Iterator[None]:
        """Show a bar inside the block, on a terminal."""
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
            TextColumn("remaining"),
            TimeRemainingColumn(),
        )
        # Scenes differ, so the estimate of the remaining time averages over many.
        with Progress(*columns, console=self._console, speed_estimate_period=3600.0) as self._bar:
            self._bar.add_task("scenes", total=self._total, rate="", failures=0)
            yield
        self._bar = None

    def view_done(self) -> None:
        """Count a rendered view."""
        check_stop()
        self._views += 1
        self._update()

    def attempt_done(self, attempt: Attempt, final: bool) -> None:
        """Count the outcome of an attempt; `final` means that the scene is not tried again."""
        check_stop()
        self._scenes += final
        self._failures += final and attempt.state != "made"
        self._update()
        if attempt.state != "made":
            self._say(f"scene {attempt.scene} failed{'' if final else ', trying again'}: {attempt.reason}")
        elif self._bar is None:
            self._say(f"scene {attempt.scene} in {attempt.total:.1f} s: {self._scenes}/{self._total}, {self._state()}")

    def _state(self) -> str:
        seconds = perf_counter() - self._start
        remaining = seconds / max(1, self._scenes) * (self._total - self._scenes)
        return f"{self._rate()}, failed {self._failures}, remaining {_clock(remaining)}"

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
