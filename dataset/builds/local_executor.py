"""Worker processes on this machine: each renders one scene at a time.

The executor restarts dead workers, kills hung ones, and replaces each after a number of scenes.
"""

from __future__ import annotations

import selectors
from collections import deque
from collections.abc import Iterator, Sequence
from time import monotonic

from .messages import Attempt, WorkerConfig, WorkerInfo, WorkerInputError
from .worker_process import WorkerProcess

#: Workers that may die in a row before one is ready; after that the installation is at fault.
_MAX_FAILED_LAUNCHES = 5
#: Interval at which silent workers are looked for while no message arrives [s].
_POLL_INTERVAL = 5.0


class LocalExecutor:
    """Renders scenes in a pool of worker processes, and restarts dead workers.

    Use it as a context manager: leaving it kills the workers.

    Parameters
    ----------
    config : WorkerConfig
        Given to each worker.
    workers : int
        Number of processes.
    max_tasks_per_child : int
        Scenes after which a worker is replaced.
    timeout : float
        Longest time without a message from a busy worker before it is killed [s].
    devices : sequence of str
        CUDA devices, assigned to the workers in turn.
    """

    def __init__(
        self,
        config: WorkerConfig,
        workers: int,
        max_tasks_per_child: int,
        timeout: float,
        devices: Sequence[str] = (),
    ) -> None:
        self._config, self._max_workers = config, workers
        self._max_tasks_per_child, self._timeout = max_tasks_per_child, timeout
        self._devices = devices
        self._queue: deque[tuple[int, bool]] = deque()  # scenes, and whether each requires a new process
        self._workers: dict[int, WorkerProcess] = {}  # by slot, which decides the device
        self._selector = selectors.DefaultSelector()
        self._failed_launches = 0
        self._info: WorkerInfo | None = None

    def __enter__(self) -> LocalExecutor:
        return self

    def __exit__(self, *_: object) -> None:
        for slot in list(self._workers):
            self._detach(slot).kill()
        self._selector.close()

    def worker_info(self) -> WorkerInfo:
        """Start the first worker, wait until it is ready, and return its host, backend and versions."""
        self._start(0)
        while self._info is None:
            for _ in self._poll():
                pass
            if not self._workers:
                self._start(0)
        return self._info

    def submit(self, scene: int, fresh: bool = False) -> None:
        """Queue a scene; `fresh` requires a process that has rendered no scene before."""
        self._queue.append((scene, fresh))

    def events(self) -> Iterator[Attempt | int]:
        """Yield outcomes, and the number of a scene each time one of its views is done, until the queue is empty.

        Scenes may be submitted while this runs.

        Raises
        ------
        WorkerInputError
            Where a worker found an asset missing or changed.
        RuntimeError
            Where workers die before they are ready, or differ from the first one in backend or versions.
        """
        while self._queue or any(worker.scene is not None for worker in self._workers.values()):
            self._start_workers()
            self._assign_scenes()
            yield from self._poll()
        for slot in list(self._workers):
            self._detach(slot).stop()

    def _start_workers(self) -> None:
        busy = sum(worker.scene is not None for worker in self._workers.values())
        for slot in range(self._max_workers):
            if slot not in self._workers and len(self._workers) < busy + len(self._queue):
                self._start(slot)

    def _start(self, slot: int) -> None:
        device = {"CUDA_VISIBLE_DEVICES": self._devices[slot % len(self._devices)]} if self._devices else {}
        worker = WorkerProcess(self._config, device)
        self._workers[slot] = worker
        self._selector.register(worker, selectors.EVENT_READ, slot)

    def _detach(self, slot: int) -> WorkerProcess:
        """Remove a worker from the pool and return it."""
        worker = self._workers.pop(slot)
        self._selector.unregister(worker)
        return worker

    def _assign_scenes(self) -> None:
        for slot, worker in list(self._workers.items()):
            if worker.ready and worker.scene is None and self._queue:
                task = self._next_task(worker)
                if task is None or worker.served >= self._max_tasks_per_child:
                    self._detach(slot).stop()
                    self._start(slot)
                else:
                    self._queue.remove(task)
                    worker.assign(task[0])

    def _next_task(self, worker: WorkerProcess) -> tuple[int, bool] | None:
        """Return the first queued task that a worker may run."""
        return next((task for task in self._queue if not task[1] or not worker.served), None)

    def _poll(self) -> Iterator[Attempt | int]:
        """Handle the messages that have arrived, and kill workers that have been silent for too long."""
        for key, _ in self._selector.select(_POLL_INTERVAL):
            if key.data in self._workers and self._workers[key.data] is key.fileobj:
                yield from self._receive(key.data)
        for slot, worker in list(self._workers.items()):
            if (worker.scene is not None or not worker.ready) and monotonic() - worker.last_message > self._timeout:
                self._detach(slot).kill()
                yield from self._worker_died(worker, f"the worker sent no message for {self._timeout:g} s")

    def _receive(self, slot: int) -> Iterator[Attempt | int]:
        worker = self._workers[slot]
        messages = worker.receive()
        if messages is None:
            yield from self._worker_died(self._detach(slot), worker.cause_of_death())
        for message in messages or ():
            if message.error is not None:
                raise WorkerInputError(message.error)
            if message.ready is not None:
                self._mark_ready(worker, message.ready)
            elif message.view is not None and worker.scene is not None:
                yield worker.scene
            elif message.attempt is not None:
                yield self._finish(slot, message.attempt)

    def _finish(self, slot: int, attempt: Attempt) -> Attempt:
        self._workers[slot].scene = None
        if attempt.state == "failed":  # the failure may have left the process in a bad state
            self._detach(slot).stop()
        return attempt

    def _worker_died(self, worker: WorkerProcess, reason: str) -> Iterator[Attempt]:
        """Yield the failed attempt of a dead worker's scene; `_start_workers` restarts the worker."""
        if worker.scene is not None:
            yield Attempt(scene=worker.scene, state="failed", reason=reason, process=worker.pid, served=worker.served)
        elif not worker.ready:
            self._failed_launches += 1
            if self._failed_launches >= _MAX_FAILED_LAUNCHES:
                raise RuntimeError(f"{_MAX_FAILED_LAUNCHES} workers in a row died before they were ready; {reason}")

    def _mark_ready(self, worker: WorkerProcess, info: WorkerInfo) -> None:
        worker.ready, self._failed_launches = True, 0
        self._info = self._info or info
        check_same_software(self._info, info)


def check_same_software(first: WorkerInfo, other: WorkerInfo) -> None:
    """Raise RuntimeError where two workers have different backends or versions: their pictures would differ."""
    if (first.backend, first.versions) != (other.backend, other.versions):
        found = [f"{info.host}: {info.backend} {info.versions}" for info in (first, other)]
        raise RuntimeError(f"workers have different software, so their pictures would differ: {found[0]}; {found[1]}")
