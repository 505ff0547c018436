"""A worker process: takes an order and scene numbers as lines of JSON, and answers in lines of JSON.

``python -P -m glassware.dataset.builds.worker`` is started by a build (`process.Worker`), never by hand.

======================  =======================================================================
to the worker           an `Order`; then ``{"scene": 7}`` again and again; ``{"end": true}``
from the worker         ``{"machine": Machine}`` once; ``{"view": 3}`` for each view that is done;
                        ``{"attempt": Attempt}`` for each scene; ``{"wrong": line}`` where an asset
                        is missing or has changed
======================  =======================================================================

A worker never outlives its build: it ends as soon as its input closes, in the middle of a scene as well. What it has
half-made is then a hidden folder, which the next run removes.
"""

from __future__ import annotations

import ctypes
import json
import os
import queue
import resource
import signal
import socket
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import TextIO

import cv2

from ...core.errors import InputError
from ...core.stopwatch import Stopwatch
from ...procedural.scene.asset_files import asset_files
from ...procedural.scene.draw import draw_scene
from ...render.backend.variant import activate
from ...render.renderer import Renderer
from ..format.dataset_file import installed_versions
from ..pipeline import WrittenScene, write_scene
from . import manifest
from .messages import UNWRITABLE, Attempt, Machine, Order

#: Number of the operation "signal me when my parent dies" (prctl(2), linux/prctl.h).
_PR_SET_PDEATHSIG = 1
_MEGABYTE, _GIBIBYTE = 1e6, 1 << 30


class Answers:
    """The way back to the build: the standard output, which no library can write into any more."""

    def __init__(self) -> None:
        self._file: TextIO = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)  # what libraries print goes where errors go

    def send(self, **message: object) -> None:
        """Send one message; a build that is gone ends this process."""
        try:
            self._file.write(json.dumps(message, sort_keys=True, allow_nan=False) + "\n")
            self._file.flush()
        except OSError:
            os._exit(1)


class Bench:
    """What a worker has set up once and uses for each scene."""

    def __init__(self, order: Order) -> None:
        self.order = order
        cv2.setNumThreads(order.threads)
        backend = activate(spectral=order.settings.picture.spectral, threads=order.threads)
        host = socket.gethostname()
        self.machine = Machine(host=host, process=os.getpid(), backend=backend, versions=installed_versions())
        manifest.check_same(order.manifest, manifest.scan(order.settings), order.settings)
        self.stamps = manifest.stamps(order.settings)
        self.files = asset_files(order.settings)
        self.served = 0

    def attempt(self, scene_id: int, answers: Answers) -> Attempt:
        """Make a scene, and return how that went."""
        self.served += 1
        self._views, stopwatch = 0, Stopwatch()
        start = perf_counter()

        def on_view(_view: int) -> None:
            self._views += 1
            answers.send(view=self._views)

        try:
            outcome = _outcome_of(self._made(scene_id, stopwatch, on_view))
        except OSError as error:
            state = "unwritable" if error.errno in UNWRITABLE else "failed"
            trace = traceback.format_exc()
            outcome = {"state": state, "reason": _line(error), "errno": error.errno or 0, "trace": trace}
        except Exception as error:
            trace = "" if isinstance(error, InputError) else traceback.format_exc()
            outcome = {"state": "failed", "reason": _line(error), "trace": trace}
        total = perf_counter() - start
        seconds = {**stopwatch.seconds, "other": total - sum(stopwatch.seconds.values())}
        facts = {
            "scene": scene_id,
            "host": self.machine.host,
            "process": self.machine.process,
            "served": self.served,
            "seconds": seconds,
            "total": total,
            "views": self._views,
            "resident": _resident(),
            "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / _MEGABYTE,
        }
        return Attempt.model_validate(facts | outcome)

    def _made(self, scene_id: int, stopwatch: Stopwatch, on_view: Callable[[int], None]) -> WrittenScene:
        with stopwatch.stage("description"):
            scene = draw_scene(self.order.settings, self.order.seed, scene_id, self.files)
        renderer = Renderer(scene, threads=self.order.threads)
        return write_scene(self.order.root, renderer, stopwatch, on_view)


def main() -> int:
    """Serve one build until it has no more scenes for this process."""
    # The build decides when work stops, and says so by killing its workers.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    _die_with_parent()
    answers, jobs = Answers(), _inbox()
    order = Order.model_validate(jobs.get())
    try:
        bench = Bench(order)
        if order.memory is not None:  # only now, so that a limit that is too low fails scenes and not all workers
            most = int(order.memory * _GIBIBYTE)
            resource.setrlimit(resource.RLIMIT_DATA, (most, most))
        answers.send(machine=bench.machine.model_dump(mode="json"))
        while "scene" in (job := jobs.get()):
            manifest.check_unchanged(bench.stamps)
            attempt = bench.attempt(job["scene"], answers)
            answers.send(attempt=attempt.model_dump(mode="json"))
    except InputError as error:
        answers.send(wrong=str(error))
    return 0


def _outcome_of(made: WrittenScene) -> dict:
    pictures = [(row.spp_left, row.noise_left) for row in made.rows]
    pictures += [(row.spp_right, row.noise_right) for row in made.rows]
    samples = [spp for spp, _ in pictures if spp is not None]
    noise = [value for _, value in pictures if value is not None]
    return {
        "state": "made",
        "spp": sum(samples) / len(samples) if samples else None,
        "noise_mean": sum(noise) / len(noise) if noise else None,
        "noise_worst": max(noise, default=None),
        "light": made.check,
    }


def _line(error: BaseException) -> str:
    said = " ".join(str(error).split())
    return said if isinstance(error, InputError) else f"{type(error).__name__}: {said}".rstrip(": ")


def _resident() -> float:
    """Return the memory that this process holds now [MB] (proc(5): second number of statm, in pages)."""
    statm = Path("/proc/self/statm")
    if not statm.is_file():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / _MEGABYTE
    return int(statm.read_text().split()[1]) * resource.getpagesize() / _MEGABYTE


def _die_with_parent() -> None:
    """Ask Linux to kill this process when its parent dies: the thread below may wait for a kernel that computes."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _inbox() -> queue.SimpleQueue:
    """Return the messages as they come; the end of the input ends the process, whatever it does."""
    messages: queue.SimpleQueue = queue.SimpleQueue()

    def read() -> None:
        for line in sys.stdin:
            messages.put(json.loads(line))
        os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    return messages


if __name__ == "__main__":
    sys.exit(main())
