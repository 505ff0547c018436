"""The build's side of one worker process: start it, assign scenes, receive its messages, stop it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from time import monotonic

from .messages import WorkerConfig, WorkerMessage

#: Longest time that an idle worker may take to exit after it is asked to [s]; then it is killed.
_SHUTDOWN_TIMEOUT = 10.0
#: Length of the end of a dead worker's stderr that becomes part of the reason [bytes].
_STDERR_TAIL = 2000
#: Exit codes of native code whose allocation failed: it dereferences the null pointer, or aborts.
_OUT_OF_MEMORY = (-signal.SIGSEGV, -signal.SIGBUS, -signal.SIGABRT)


class WorkerProcess:
    """One worker process. Its death is noticed at once: nobody else holds the write end of its output pipe.

    Parameters
    ----------
    config : WorkerConfig
        Sent to the worker first.
    environment : mapping of str to str
        Environment variables on top of the build's own.
    """

    def __init__(self, config: WorkerConfig, environment: Mapping[str, str]) -> None:
        # A file and not a pipe: it needs no reader, and cannot fill up and block the worker.
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115  # closed in `_close`
        self._process = subprocess.Popen(
            # -P keeps the current folder off the module path.
            [sys.executable, "-P", "-m", "glassware.dataset.builds.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            env={**os.environ, **_thread_limits(config.threads), **environment},
            bufsize=0,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout
        self._buffer = b""
        self._memory = config.memory
        self.scene: int | None = None  #: the scene that it renders now
        self.served = 0  #: scenes assigned so far
        self.ready = False  #: it has sent its `WorkerInfo`
        self.last_message = monotonic()  #: time of its last message [s]
        self._send(config.model_dump(mode="json"))

    @property
    def pid(self) -> int:
        """Process number."""
        return self._process.pid

    def fileno(self) -> int:
        """Return the file descriptor to wait on for messages."""
        return self._stdout.fileno()

    def assign(self, scene: int) -> None:
        """Send it a scene to render."""
        self.scene, self.last_message = scene, monotonic()
        self.served += 1
        self._send({"scene": scene})

    def receive(self) -> list[WorkerMessage] | None:
        """Wait for messages and return them; None where the process is dead and has sent everything."""
        data = os.read(self.fileno(), 1 << 16)
        if not data:
            return None
        self.last_message = monotonic()
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        return [WorkerMessage.model_validate_json(line) for line in lines]

    def stop(self) -> None:
        """Ask the idle worker to exit; kill it where it does not."""
        self._send({"stop": True})
        try:
            self._process.wait(_SHUTDOWN_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._close()

    def kill(self) -> None:
        """Kill it at once, whatever it is doing."""
        self._process.kill()
        self._close()

    def cause_of_death(self) -> str:
        """Return in one line how it died, with the end of its stderr."""
        code = self._process.wait()
        self._stderr.seek(0, os.SEEK_END)
        self._stderr.seek(max(0, self._stderr.tell() - _STDERR_TAIL))
        printed = " ".join(self._stderr.read().decode("utf-8", "replace").split())
        self._close()
        how = f"exited with code {code}"
        if code < 0:
            how = f"was killed by signal {-code} ({signal.Signals(-code).name})"
        if code == -signal.SIGKILL:
            how += ", as the system does when memory runs out"
        elif code in _OUT_OF_MEMORY and self._memory is not None:
            how += f", as libraries do when they may allocate no more memory (--memory {self._memory:g})"
        return f"the worker {how}" + (f": {printed}" if printed else "")

    def _send(self, message: dict) -> None:
        try:
            self._stdin.write(json.dumps(message).encode() + b"\n")
        except BrokenPipeError:  # it is dead: `receive` returns None next
            return

    def _close(self) -> None:
        self._process.wait()
        for stream in (self._stdin, self._stdout, self._stderr):
            stream.close()


def _thread_limits(count: int) -> dict[str, str]:
    """Return the environment variables that limit the threads of the libraries in a worker."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OIDN_NUM_THREADS")
    # Otherwise the denoiser pins its threads to the same first cores in every worker.
    return dict.fromkeys(names, str(count)) | {"OIDN_SET_AFFINITY": "0"}
