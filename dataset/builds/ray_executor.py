"""Scenes as tasks on a Ray cluster, on any node that mounts the same folders.

Each task starts a worker process of our own and has it render one scene. So every scene has a new process, a crash ends
that process and not Ray's, and a worker dies with its task. Ray itself runs the tasks of a lost node again elsewhere.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from ...core.errors import InputError
from .local_executor import LocalExecutor, check_same_software
from .messages import Attempt, WorkerConfig, WorkerInfo

#: How often Ray repeats a task whose node or process was lost, before the scene counts as failed.
_MAX_RETRIES = 5
#: Longest wait for tasks before stop signals are handled again [s].
_POLL_INTERVAL = 1.0
#: Longest wait for the cluster to accept a connection [s].
_CONNECT_TIMEOUT = 20.0
_GIBIBYTE = 1 << 30


class RayExecutor:
    """Renders scenes as Ray tasks. Use it as a context manager: leaving it cancels the tasks and disconnects.

    Parameters
    ----------
    config : WorkerConfig
        Given to each worker; its threads and memory are the resources that a task requests.
    address : str, optional
        Address of the cluster; without it one is started on this machine.
    gpus : float
        GPUs that a task requests.
    timeout : float
        Longest time without a message from a busy worker before it is killed [s].
    """

    def __init__(self, config: WorkerConfig, address: str | None, gpus: float, timeout: float) -> None:
        self._config, self._address, self._gpus, self._timeout = config, address, gpus, timeout
        self._ray = _import_ray()
        self._running: dict[Any, int] = {}
        self._info: WorkerInfo | None = None

    def __enter__(self) -> RayExecutor:
        if self._address is not None:
            _check_reachable(self._address)
        try:
            self._ray.init(address=self._address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, ValueError, RuntimeError) as error:
            found = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError("--address", "a running Ray cluster", found) from error
        self._check_nodes()
        options: dict[str, Any] = {
            "num_cpus": self._config.threads,
            "num_gpus": self._gpus,
            "max_retries": _MAX_RETRIES,
        }
        if self._config.memory is not None:
            options["memory"] = int(self._config.memory * _GIBIBYTE)
        self._task = self._ray.remote(**options)(_run_task)
        return self

    def __exit__(self, *_: object) -> None:
        for task in self._running:
            self._ray.cancel(task, force=True)
        self._ray.shutdown()

    def _check_nodes(self) -> None:
        """Raise InputError where no node has the resources that a task requests: it would wait for ever."""
        nodes = [node["Resources"] for node in self._ray.nodes() if node["Alive"]]
        for option, kind, requested in (("--threads", "CPU", self._config.threads), ("--gpus", "GPU", self._gpus)):
            available = max((node.get(kind, 0.0) for node in nodes), default=0.0)
            if requested > available:
                raise InputError(option, f"at most the {available:g} {kind}s of a node", requested)

    def worker_info(self) -> WorkerInfo:
        """Start a worker on some node, and return its host, backend and versions."""
        info, _ = self._result(self._task.remote(self._config.model_dump(mode="json"), None, self._timeout))
        self._info = WorkerInfo.model_validate(info)
        return self._info

    def submit(self, scene: int, fresh: bool = False) -> None:  # every task has a new process
        """Queue a scene."""
        task = self._task.remote(self._config.model_dump(mode="json"), scene, self._timeout)
        self._running[task] = scene

    def events(self) -> Iterator[Attempt | int]:
        """Yield outcomes, each after the number of its scene once for every view, until no task is left."""
        while self._running:
            done, _ = self._ray.wait(list(self._running), timeout=_POLL_INTERVAL)
            for task in done:
                attempt = self._outcome(task, self._running.pop(task))
                yield from [attempt.scene] * attempt.views
                yield attempt

    def _outcome(self, task: Any, scene: int) -> Attempt:
        try:
            info, outcome = self._result(task)
        except self._ray.exceptions.RayTaskError:
            raise
        except self._ray.exceptions.RayError as error:  # the node or the process was lost in every retry
            return Attempt(scene=scene, state="failed", reason=f"Ray: {' '.join(str(error).split())[:500]}")
        if self._info is not None:
            check_same_software(self._info, WorkerInfo.model_validate(info))
        return Attempt.model_validate(outcome)

    def _result(self, task: Any) -> tuple[dict, dict | None]:
        """Return a task's result; raise the InputError that it ended with as such."""
        try:
            return self._ray.get(task)
        except self._ray.exceptions.RayTaskError as error:
            if isinstance(error.cause, InputError):
                raise error.cause from error
            raise


def _run_task(config: dict, scene: int | None, timeout: float) -> tuple[dict, dict | None]:
    """Start a worker and render one scene with it, or none; return its `WorkerInfo` and the `Attempt` as JSON data."""
    with LocalExecutor(
        WorkerConfig.model_validate(config), workers=1, max_tasks_per_child=1, timeout=timeout
    ) as executor:
        info = executor.worker_info().model_dump(mode="json")
        if scene is None:
            return info, None
        executor.submit(scene)
        outcomes = [event for event in executor.events() if isinstance(event, Attempt)]
    return info, outcomes[0].model_dump(mode="json")


def _check_reachable(address: str) -> None:
    """Raise InputError where nothing listens at ``host:port``: Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not (host and port.isdigit()):  # such as "auto", which Ray looks up
        return
    try:
        socket.create_connection((host, int(port)), _CONNECT_TIMEOUT).close()
    except (OSError, OverflowError) as error:
        raise InputError("--address", "a running Ray cluster", f"{address}: {error}") from error


def _import_ray() -> ModuleType:
    # Ray sends no usage statistics to its makers.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
    except ImportError as error:
        raise InputError("--executor ray", "the extra ray installed (pip install '.[ray]')", "no module ray") from error
    return ray
