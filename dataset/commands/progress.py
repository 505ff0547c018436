"""Progress of a scene and of a build: a live line on a terminal, lines elsewhere; estimates are measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, track
from rich.table import Table

from ...core.stopping import check_stop
from ...core.stopwatch import Stopwatch
from ...procedural.description.scene import TABLE_ID

if TYPE_CHECKING:  # the first line is printed before the renderer's types are loaded
    from ...render.frame import LightCheck, Remedy
    from ..builds.messages import Attempt

T = TypeVar("T")
#: Steps of a renderer (`Renderer.on_stage`) in words.
STEPS = {
    "loading": "compiling and loading the scene",
    "light": "light: filling the irradiance cache and checking it",
}

#: Time between lines about the check of a folder's files [s]: a quick check says nothing.
_CHECK_INTERVAL = 3.0


def _one_line(console: Console) -> Progress:
    """Return a bar that is one changing line: what is done, how far it is, the time that is left and that passed."""
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TextColumn("{task.fields[left]}"),
        TimeElapsedColumn(),
    )
    return Progress(*columns, console=console, transient=True)


class SceneProgress:
    """The progress of one scene: each step, then the views with the time that is left."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self.stopwatch = Stopwatch()  #: seconds by stage
        self._start = perf_counter()
        self._bar: Progress | None = None
        self._total = 0
        self._ends: list[float] = []  #: of the views, and of what was before the first [s]
        self._shown_at = self._start

    def say(self, line: str) -> None:
        """Print a line that stays."""
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

    @property
    def seconds(self) -> float:
        """Time since the start [s]."""
        return perf_counter() - self._start

    @contextmanager
    def display(self) -> Iterator[None]:
        """Show the current step inside the block, on a terminal as one line that changes."""
        if not self._console.is_terminal:
            yield
            return
        with _one_line(self._console) as self._bar:
            self._bar.add_task("starting", total=None, left="")
            yield
        self._bar = None

    def step(self, text: str) -> None:
        """Begin a step; raise `KeyboardInterrupt` if a stop signal was received."""
        check_stop()
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], description=text, total=None)
            self._bar.refresh()  # at once: the step may keep the interpreter busy
        else:
            self.say(f"{self.seconds:6.1f} s  {text}")

    def on_stage(self, stage: str) -> None:
        """Begin a step of the renderer."""
        self.step(STEPS.get(stage, stage))

    def begin_views(self, total: int) -> None:
        """Begin with the views."""
        self._total, self._ends = total, [self.seconds]
        if self._bar is None:
            self.step(f"rendering {total} views" if total > 1 else "rendering the view")
        else:
            self._bar.update(self._bar.task_ids[0], description=f"view 1/{total}", total=total, completed=0)

    def advance(self, _view: int) -> None:
        """Count one view as done; raise `KeyboardInterrupt` if a stop signal was received."""
        check_stop()
        self._ends.append(self.seconds)
        done = len(self._ends) - 1
        left = remaining(self._ends, self._total)
        if self._bar is not None:
            text = f"view {min(done + 1, self._total)}/{self._total}"
            self._bar.update(self._bar.task_ids[0], description=text, completed=done, left=left)
        else:
            self.say(f"view {done}/{self._total} after {self.seconds:.1f} s{left and ', '}{left}")

    def table(self, title: str, views: int) -> None:
        """Print the seconds of each stage, in total and per view."""
        total = self.seconds
        table = Table(title=title)
        for column in ("stage", "seconds", "per view", "fraction"):
            table.add_column(column, justify="left" if column == "stage" else "right")
        measured = self.stopwatch.seconds
        known = sum(measured.values())
        for stage, seconds in (*measured.items(), ("other", total - known), ("total", total)):
            table.add_row(stage, f"{seconds:.2f}", f"{seconds / views:.3f}", f"{seconds / total:.1%}")
        self._console.print(table)


def tracked(items: Iterable[T], what: str, total: int, console: Console) -> Iterator[T]:
    """Return items one by one; on a terminal a line shows how many there were."""
    if not console.is_terminal:
        return iter(items)
    return iter(track(items, what, total, console=console, transient=True))


def remaining(ends: list[float], total: int) -> str:
    """Return the time that is left in words, from the times at which views ended; "" where there are none to come.

    The first view compiles kernels, so it alone gives an upper bound; from the second on, the others' mean counts.

    Parameters
    ----------
    ends : list of float
        When the first view began, and when each one ended [s].
    total : int
        Number of views.
    """
    done = len(ends) - 1
    if done == 0 or done >= total:
        return ""
    if done == 1:
        return f"at most {clock((ends[1] - ends[0]) * (total - 1))} left"
    return f"about {clock((ends[-1] - ends[1]) / (done - 1) * (total - done))} left"


def clock(seconds: float) -> str:
    """Return a time in words: ``24 s``, ``3:05 min`` or ``2:30 h``."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    return f"{whole // 60}:{whole % 60:02d} min" if whole < 6000 else f"{whole // 3600}:{whole % 3600 // 60:02d} h"


def light_line(check: LightCheck) -> str:
    """Return a line about the irradiance cache of a scene and its check against path tracing."""
    largest = max((abs(region.difference) for region in check.regions), default=0.0)
    return (
        f"irradiance cache filled at {check.nodes} points; pictures from it differ from path-traced ones by "
        f"{check.difference:+.2%} in the mean of {len(check.regions)} regions, at most {largest:.1%}"
    )


#: What was done about regions beyond the bound, in words.
_REMEDIES: dict[Remedy | None, str] = {
    "scene path traced": "the whole scene is path traced instead",
    "object path traced": "they are path traced instead",
    "other objects path traced": "they are within it once the objects above are path traced",
    None: "nothing was done about it",
}


def failed_lines(check: LightCheck) -> list[str]:
    """Return a line for each remedy of regions where the irradiance cache differs too much, with these regions."""
    remedies: dict[Remedy | None, list[str]] = {}
    for region in check.failed:
        name = "the table" if region.id == TABLE_ID else f"object {region.id}"
        place = name + ("" if region.part == "all" else f" ({region.part} part)")
        places = remedies.setdefault(region.remedy, [])
        places.append(f"{place} {region.difference:+.1%} +- {region.standard_error:.1%}")
    return [
        f"checked: the irradiance cache is off by more than {check.bound:.0%} at {', '.join(places)}; "
        f"{_REMEDIES[remedy]}"
        for remedy, places in remedies.items()
    ]


class BuildProgress:
    """The progress of a build: scenes and views done, failures, and the time that is left."""

    def __init__(
        self, console: Console, total: int, views: int, on_first: Callable[[Attempt], None] | None = None
    ) -> None:
        self._console, self._total, self._all_views = console, total, total * views
        self._on_first = on_first  #: called with the first attempt that made a scene
        self._start = perf_counter()
        self._views = self._scenes = self._failures = 0
        self._bar: Progress | None = None

    @contextmanager
    def display(self) -> Iterator[None]:
        """Show a bar inside the block, on a terminal."""
        if not self._console.is_terminal:
            yield
            return
        with _one_line(self._console) as self._bar:
            self._bar.add_task(self._text(), total=self._all_views, left="")
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
            self.say(f"scene {attempt.scene} failed{'' if final else ', trying again'}: {attempt.reason}")
        elif self._bar is None:
            self.say(f"scene {attempt.scene} in {attempt.total:.1f} s: {self._text()}, {self._left() or 'done'}")
        if attempt.state == "made" and self._on_first is not None and self._total > 1:
            call, self._on_first = self._on_first, None
            call(attempt)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Leave the terminal alone inside the block, so that a question can be asked."""
        if self._bar is None:
            yield
            return
        self._bar.stop()
        yield
        self._bar.start()

    def say(self, line: str) -> None:
        """Print a line that stays."""
        (self._bar.console if self._bar is not None else self._console).print(
            line, markup=False, highlight=False, soft_wrap=True
        )

    def _text(self) -> str:
        failed = f", {self._failures} failed" if self._failures else ""
        return f"scenes {self._scenes}/{self._total}, views {self._views}/{self._all_views}{failed}"

    def _left(self) -> str:
        """Return the time that is left by the views so far; the start of the workers counts, as it comes again."""
        left = self._all_views - self._views
        if not self._views or left <= 0 or self._scenes >= self._total:
            return ""
        return f"about {clock((perf_counter() - self._start) / self._views * left)} left"

    def _update(self) -> None:
        if self._bar is not None:
            task = self._bar.task_ids[0]
            self._bar.update(task, completed=self._views, description=self._text(), left=self._left())
