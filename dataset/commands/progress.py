"""Where the time goes: a bar while views are rendered, a table at the end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ...core.stopping import check_stop
from ...core.stopwatch import Stopwatch
from ...render.frame import LightCheck


class Stages:
    """Seconds by stage, and the progress of the views. On a terminal a bar with an ETA, elsewhere a line a view."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self.stopwatch = Stopwatch()  #: seconds by stage
        self._start = perf_counter()
        self._bar: Progress | None = None
        self._done, self._total = 0, 0

    def say(self, line: str) -> None:
        """Print a line about what comes next."""
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    @contextmanager
    def progress(self, total: int) -> Iterator[None]:
        """Show the progress of `total` views inside."""
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
        """Count one view as done; raise KeyboardInterrupt if a signal to stop was received."""
        check_stop()
        self._done += 1
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=self._done)
        else:
            seconds = perf_counter() - self._start
            self._console.print(f"view {self._done}/{self._total} after {seconds:.1f} s", highlight=False)

    def report(self, title: str, views: int) -> None:
        """Print the seconds of each stage, in all and a view."""
        total = perf_counter() - self._start
        table = Table(title=title)
        for column in ("stage", "seconds", "a view", "share"):
            table.add_column(column, justify="left" if column == "stage" else "right")
        seconds_of = self.stopwatch.seconds
        known = sum(seconds_of.values())
        for stage, seconds in (*seconds_of.items(), ("other", total - known), ("all", total)):
            table.add_row(stage, f"{seconds:.2f}", f"{seconds / views:.3f}", f"{seconds / total:.1%}")
        self._console.print(table)


def told_of_light(check: LightCheck) -> str:
    """Return a line about the irradiance cache of a scene and its check against path tracing."""
    line = (
        f"light of the scene stored at {check.nodes} points; pictures from it differ from path-traced ones by "
        f"{check.difference:+.2%} in the mean (standard error {check.standard_error:.2%})"
    )
    return line if check.mode == "shared" else f"{line}, more than {check.bound:.0%}: paths are traced instead"
