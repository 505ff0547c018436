"""A Ray cluster that makes scenes: one task each, on any node that sees the same folders.

A task starts a worker process of our own and asks it for one scene. So a scene has a fresh process, a crash ends that
process and not Ray's, and a worker dies with its task. Ray itself runs tasks of a lost node again elsewhere.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from ...core.errors import InputError
from .messages import Attempt, Machine, Order
from .pool import Pool, check_alike

#: How often Ray runs a task again whose node or process was lost, before the scene counts as failed.
_RERUNS = 5
#: How often signals to stop are looked for while tasks run [s].
_PULSE = 1.0
#: Longest that a cluster may take to answer a first knock [s].
_CONNECT = 20.0
_GIBIBYTE = 1 << 30


class Cluster:
    """Makes scenes as Ray tasks. Use it as a context: leaving it gives the cluster up."""

    def __init__(self, order: Order, address: str | None, gpus: float, patience: float) -> None:
        self._order, self._address, self._gpus, self._patience = order, address, gpus, patience
        self._ray = _ray()
        self._running: dict[Any, int] = {}
        self._machine: Machine | None = None

    def __enter__(self) -> Cluster:
        if self._address is not None:
            _check_answers(self._address)
        try:
            self._ray.init(address=self._address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, ValueError, RuntimeError) as error:
            found = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError("--address", "a Ray cluster that runs", found) from error
        self._check_nodes()
        options: dict[str, Any] = {"num_cpus": self._order.threads, "num_gpus": self._gpus, "max_retries": _RERUNS}
        if self._order.memory is not None:
            options["memory"] = int(self._order.memory * _GIBIBYTE)
        self._task = self._ray.remote(**options)(_alone)
        return self

    def __exit__(self, *_: object) -> None:
        for task in self._running:
            self._ray.cancel(task, force=True)
        self._ray.shutdown()

    def _check_nodes(self) -> None:
        """Raise InputError where no node has what a task asks for: it would wait for ever."""
        nodes = [node["Resources"] for node in self._ray.nodes() if node["Alive"]]
        for option, kind, asked in (("--threads", "CPU", self._order.threads), ("--gpus", "GPU", self._gpus)):
            most = max((node.get(kind, 0.0) for node in nodes), default=0.0)
            if asked > most:
                raise InputError(option, f"at most the {most:g} {kind}s of a node", asked)

    def machine(self) -> Machine:
        """Return what a worker somewhere in the cluster says of itself."""
        machine, _ = self._got(self._task.remote(self._order.model_dump(mode="json"), None, self._patience))
        self._machine = Machine.model_validate(machine)
        return self._machine

    def submit(self, scene: int, fresh: bool = False) -> None:  # every process here is fresh
        """Add a scene."""
        task = self._task.remote(self._order.model_dump(mode="json"), scene, self._patience)
        self._running[task] = scene

    def events(self) -> Iterator[Attempt | int]:
        """Go through outcomes of scenes, each after as many views; till nothing is left."""
        while self._running:
            done, _ = self._ray.wait(list(self._running), timeout=_PULSE)
            for task in done:
                attempt = self._outcome(task, self._running.pop(task))
                yield from [attempt.scene] * attempt.views
                yield attempt

    def _outcome(self, task: Any, scene: int) -> Attempt:
        try:
            machine, outcome = self._got(task)
        except self._ray.exceptions.RayTaskError:
            raise
        except self._ray.exceptions.RayError as error:  # the node or the process was lost, again and again
            return Attempt(scene=scene, state="failed", reason=f"Ray: {' '.join(str(error).split())[:500]}")
        if self._machine is not None:
            check_alike(self._machine, Machine.model_validate(machine))
        return Attempt.model_validate(outcome)

    def _got(self, task: Any) -> tuple[dict, dict | None]:
        """Return a task's result; a wrong request that it found is raised as such."""
        try:
            return self._ray.get(task)
        except self._ray.exceptions.RayTaskError as error:
            if isinstance(error.cause, InputError):
                raise error.cause from error
            raise


def _alone(order: dict, scene: int | None, patience: float) -> tuple[dict, dict | None]:
    """Make one scene, or none, in a process of its own; return its machine and the outcome."""
    with Pool(Order.model_validate(order), workers=1, recycle=1, patience=patience) as pool:
        machine = pool.machine().model_dump(mode="json")
        if scene is None:
            return machine, None
        pool.submit(scene)
        outcomes = [event for event in pool.events() if isinstance(event, Attempt)]
    return machine, outcomes[0].model_dump(mode="json")


def _check_answers(address: str) -> None:
    """Raise InputError where nothing listens at ``host:port``: Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not (host and port.isdigit()):  # such as "auto", which Ray looks up
        return
    try:
        socket.create_connection((host, int(port)), _CONNECT).close()
    except (OSError, OverflowError) as error:
        raise InputError("--address", "a Ray cluster that runs", f"{address}: {error}") from error


def _ray() -> ModuleType:
    # Nothing is sent anywhere but to the cluster.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
    except ImportError as error:
        raise InputError("--executor ray", "the extra ray installed (pip install '.[ray]')", "no module ray") from error
    return ray
