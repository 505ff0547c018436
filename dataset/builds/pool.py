"""Worker processes of this machine: each makes a scene at a time, and is replaced after some."""

from __future__ import annotations

import selectors
from collections import deque
from collections.abc import Iterator, Sequence
from time import monotonic

from .messages import Attempt, Machine, Order, Refusal
from .worker_process import Worker

#: Workers that may die in a row before one is ready; then the installation is at fault, not chance.
_FALSE_STARTS = 5
#: How often stalled workers are looked for while nothing happens [s].
_PULSE = 5.0


class Pool:
    """Makes scenes in processes of its own. Use it as a context: leaving it kills whoever is left."""

    def __init__(self, order: Order, workers: int, recycle: int, patience: float, devices: Sequence[str] = ()) -> None:
        self._order, self._most, self._recycle, self._patience = order, workers, recycle, patience
        self._devices = devices
        self._waiting: deque[tuple[int, bool]] = deque()  # scenes, and whether each wants a fresh process
        self._staff: dict[int, Worker] = {}  # by place, which decides the device
        self._selector = selectors.DefaultSelector()
        self._false_starts = 0
        self._machine: Machine | None = None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        for place in list(self._staff):
            self._dismissed(place).kill()
        self._selector.close()

    def machine(self) -> Machine:
        """Return what the first worker says of itself."""
        self._hire(0)
        while self._machine is None:
            for _ in self._events():
                pass
            if not self._staff:
                self._hire(0)
        return self._machine

    def submit(self, scene: int, fresh: bool = False) -> None:
        """Add a scene; `fresh` wants a process that has made none before."""
        self._waiting.append((scene, fresh))

    def events(self) -> Iterator[Attempt | int]:
        """Go through outcomes of scenes and, as numbers of their scenes, views that are done; till nothing is left.

        Scenes may be added meanwhile.

        Raises
        ------
        Refusal
            Where a worker found an asset missing or changed.
        RuntimeError
            Where workers die before they can work, or are not like the first one.
        """
        while self._waiting or any(worker.scene is not None for worker in self._staff.values()):
            self._hire_all()
            self._hand_out()
            yield from self._events()
        for place in list(self._staff):
            self._dismissed(place).end()

    def _hire_all(self) -> None:
        busy = sum(worker.scene is not None for worker in self._staff.values())
        for place in range(self._most):
            if place not in self._staff and len(self._staff) < busy + len(self._waiting):
                self._hire(place)

    def _hire(self, place: int) -> None:
        device = {"CUDA_VISIBLE_DEVICES": self._devices[place % len(self._devices)]} if self._devices else {}
        worker = Worker(self._order, device)
        self._staff[place] = worker
        self._selector.register(worker, selectors.EVENT_READ, place)

    def _dismissed(self, place: int) -> Worker:
        worker = self._staff.pop(place)
        self._selector.unregister(worker)
        return worker

    def _hand_out(self) -> None:
        for place, worker in list(self._staff.items()):
            if worker.ready and worker.scene is None and self._waiting:
                scene = self._next(worker)
                if scene is None or worker.served >= self._recycle:
                    self._dismissed(place).end()
                    self._hire(place)
                else:
                    self._waiting.remove(scene)
                    worker.give(scene[0])

    def _next(self, worker: Worker) -> tuple[int, bool] | None:
        """Return the first waiting scene that a worker may take."""
        return next((job for job in self._waiting if not job[1] or not worker.served), None)

    def _events(self) -> Iterator[Attempt | int]:
        for key, _ in self._selector.select(_PULSE):
            if key.data in self._staff and self._staff[key.data] is key.fileobj:
                yield from self._heard(key.data)
        for place, worker in list(self._staff.items()):
            if (worker.scene is not None or not worker.ready) and monotonic() - worker.heard > self._patience:
                self._dismissed(place).kill()
                yield from self._lost(worker, f"the worker gave no sign of life for {self._patience:g} s")

    def _heard(self, place: int) -> Iterator[Attempt | int]:
        worker = self._staff[place]
        messages = worker.answers()
        if messages is None:
            yield from self._lost(self._dismissed(place), worker.death())
        for message in messages or ():
            if "wrong" in message:
                raise Refusal(message["wrong"])
            if "machine" in message:
                self._meet(worker, Machine.model_validate(message["machine"]))
            elif "view" in message and worker.scene is not None:
                yield worker.scene
            elif "attempt" in message:
                yield self._done(place, Attempt.model_validate(message["attempt"]))

    def _done(self, place: int, attempt: Attempt) -> Attempt:
        self._staff[place].scene = None
        if attempt.state == "failed":  # whatever went wrong may have left something behind in it
            self._dismissed(place).end()
        return attempt

    def _lost(self, worker: Worker, reason: str) -> Iterator[Attempt]:
        if worker.scene is not None:
            yield Attempt(scene=worker.scene, state="failed", reason=reason, process=worker.pid, served=worker.served)
        elif not worker.ready:
            self._false_starts += 1
            if self._false_starts >= _FALSE_STARTS:
                raise RuntimeError(f"{_FALSE_STARTS} workers in a row died before they were ready; {reason}")

    def _meet(self, worker: Worker, machine: Machine) -> None:
        worker.ready, self._false_starts = True, 0
        self._machine = self._machine or machine
        check_alike(self._machine, machine)


def check_alike(first: Machine, other: Machine) -> None:
    """Raise RuntimeError where two machines could make other pictures: another backend or another version."""
    if (first.backend, first.versions) != (other.backend, other.versions):
        told = [f"{machine.host}: {machine.backend} {machine.versions}" for machine in (first, other)]
        raise RuntimeError(f"workers differ, and their pictures would: {told[0]}; {told[1]}")
