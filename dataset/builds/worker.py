"""A worker process: receives its configuration and scene numbers as lines of JSON, and answers in lines of JSON.

``python -P -m glassware.dataset.builds.worker`` is started by a build (`worker_process.WorkerProcess`), never by hand.

======================  =======================================================================
to the worker           a `WorkerConfig`; then ``{"scene": 7}`` for each scene; ``{"stop": true}``
from the worker         `WorkerMessage`: ``ready`` once; ``view`` for each view that is done; ``attempt``
                        for each scene; ``error`` where an asset is missing or has changed
======================  =======================================================================

A worker never outlives its build: it exits as soon as its input closes, also in the middle of a scene. What it has
written so far is a hidden folder, which the next run removes.
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
from .messages import UNWRITABLE, Attempt, WorkerConfig, WorkerInfo, WorkerMessage

#: The operation "send me a signal when my parent dies" (prctl(2), linux/prctl.h).
_PR_SET_PDEATHSIG = 1
_MEGABYTE, _GIBIBYTE = 1e6, 1 << 30


class WorkerChannel:
    """The messages to the build, on what was the standard output: no library can print into it any more."""

    def __init__(self) -> None:
        self._file: TextIO = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)  # what libraries print goes to stderr

    def send(self, message: WorkerMessage) -> None:
        """Send one message; exit at once where the build is gone."""
        try:
            self._file.write(message.model_dump_json(exclude_none=True) + "\n")
            self._file.flush()
        except OSError:
            os._exit(1)


class WorkerContext:
    """What a worker sets up once and uses for every scene."""

    def __init__(self, config: WorkerConfig) -> None:
        self.config = config
        cv2.setNumThreads(config.threads)
        backend = activate(spectral=config.settings.picture.spectral, threads=config.threads)
        host = socket.gethostname()
        self.info = WorkerInfo(host=host, process=os.getpid(), backend=backend, versions=installed_versions())
        manifest.check_manifest(config.manifest, manifest.scan(config.settings), config.settings)
        self.stamps = manifest.stamps(config.settings)
        self.files = asset_files(config.settings)
        self.served = 0

    def attempt(self, scene_id: int, channel: WorkerChannel) -> Attempt:
        """Render a scene, and return the outcome; no exception leaves this method."""
        self.served += 1
        views, stopwatch = 0, Stopwatch()
        start = perf_counter()

        def on_view(_view: int) -> None:
            nonlocal views
            views += 1
            channel.send(WorkerMessage(view=views))

        try:
            outcome = _outcome_of(self._render(scene_id, stopwatch, on_view))
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
            "host": self.info.host,
            "process": self.info.process,
            "served": self.served,
            "seconds": seconds,
            "total": total,
            "views": views,
            "resident": _resident(),
            "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / _MEGABYTE,
        }
        return Attempt.model_validate(facts | outcome)

    def _render(self, scene_id: int, stopwatch: Stopwatch, on_view: Callable[[int], None]) -> WrittenScene:
        with stopwatch.stage("description"):
            scene = draw_scene(self.config.settings, self.config.seed, scene_id, self.files)
        renderer = Renderer(scene, threads=self.config.threads)
        return write_scene(self.config.root, renderer, stopwatch, on_view, files=self.config.files)


def main() -> int:
    """Serve one build until it asks this process to stop."""
    # The build decides when work stops, and enforces it by killing its workers.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    _die_with_parent()
    channel, messages = WorkerChannel(), _read_messages()
    config = WorkerConfig.model_validate(messages.get())
    try:
        context = WorkerContext(config)
        if config.memory is not None:  # only now, so that a limit that is too low fails scenes and not every worker
            limit = int(config.memory * _GIBIBYTE)
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
        channel.send(WorkerMessage(ready=context.info))
        while "scene" in (message := messages.get()):
            manifest.check_unchanged(context.stamps)
            channel.send(WorkerMessage(attempt=context.attempt(message["scene"], channel)))
    except InputError as error:
        channel.send(WorkerMessage(error=str(error)))
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
    text = " ".join(str(error).split())
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}".rstrip(": ")


def _resident() -> float:
    """Return the resident memory of this process [MB] (proc(5): second number of statm, in pages)."""
    statm = Path("/proc/self/statm")
    if not statm.is_file():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / _MEGABYTE
    return int(statm.read_text().split()[1]) * resource.getpagesize() / _MEGABYTE


def _die_with_parent() -> None:
    """Ask Linux to kill this process when its parent dies: the reader thread may be blocked by a running kernel."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _read_messages() -> queue.SimpleQueue:
    """Return a queue that a thread fills with the messages; the end of the input ends the process at once."""
    messages: queue.SimpleQueue = queue.SimpleQueue()

    def read() -> None:
        for line in sys.stdin:
            messages.put(json.loads(line))
        os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    return messages


if __name__ == "__main__":
    sys.exit(main())
