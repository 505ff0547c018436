"""A build's side of one worker process: started, given scenes, listened to, and ended."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from time import monotonic

from .messages import Order

#: Longest that a worker may take to end once it was told to [s]; then it is killed. It has nothing left to do.
_FAREWELL = 10.0
#: End of what a worker printed that goes into the reason of its death [bytes].
_TAIL = 2000
#: Exit codes of native code whose allocation failed: it uses the null pointer, or gives up.
_OUT_OF_MEMORY = (-signal.SIGSEGV, -signal.SIGBUS, -signal.SIGABRT)


class Worker:
    """One worker process. Its death is seen at once: the pipe that it answers through has no other writer."""

    def __init__(self, order: Order, extra: Mapping[str, str]) -> None:
        # A file and not a pipe: nobody has to read it, and it cannot fill up and hold the worker.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # closed in `end`
        self._process = subprocess.Popen(
            # -P keeps the current folder off the module path.
            [sys.executable, "-P", "-m", "glassware.dataset.builds.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={**os.environ, **_threads(order.threads), **extra},
            bufsize=0,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._input, self._output = self._process.stdin, self._process.stdout
        self._unread = b""
        self._memory = order.memory
        self.scene: int | None = None  #: what it works on
        self.served = 0  #: scenes that it was given
        self.ready = False  #: it has said which machine it is
        self.heard = monotonic()  #: when it last said something
        self._say(order.model_dump(mode="json"))

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def fileno(self) -> int:
        """Return the handle to wait on for answers."""
        return self._output.fileno()

    def give(self, scene: int) -> None:
        """Give it a scene to make."""
        self.scene, self.heard = scene, monotonic()
        self.served += 1
        self._say({"scene": scene})

    def answers(self) -> list[dict] | None:
        """Return the messages that have come, waiting for some; None where it is dead and has nothing more to say."""
        data = os.read(self.fileno(), 1 << 16)
        if not data:
            return None
        self.heard = monotonic()
        *lines, self._unread = (self._unread + data).split(b"\n")
        return [json.loads(line) for line in lines]

    def end(self) -> None:
        """Let it end by itself, having no work; kill it where it does not."""
        self._say({"end": True})
        try:
            self._process.wait(_FAREWELL)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._close()

    def kill(self) -> None:
        """End it now, whatever it does."""
        self._process.kill()
        self._close()

    def death(self) -> str:
        """Return in one line how it died, with the end of what it printed."""
        code = self._process.wait()
        self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(0, self._errors.tell() - _TAIL))
        printed = " ".join(self._errors.read().decode("utf-8", "replace").split())
        self._close()
        how = f"ended with code {code}"
        if code < 0:
            how = f"was killed by signal {-code} ({signal.Signals(-code).name})"
        if code == -signal.SIGKILL:
            how += ", as the system does when memory runs out"
        elif code in _OUT_OF_MEMORY and self._memory is not None:
            how += f", as libraries do that may allocate no more memory (--memory {self._memory:g})"
        return f"the worker {how}" + (f": {printed}" if printed else "")

    def _say(self, message: dict) -> None:
        try:
            self._input.write(json.dumps(message).encode() + b"\n")
        except BrokenPipeError:  # it is dead, which its output tells in a moment
            return

    def _close(self) -> None:
        self._process.wait()
        for stream in (self._input, self._output, self._errors):
            stream.close()


def _threads(count: int) -> dict[str, str]:
    """Return the variables that tell the libraries in a worker how many threads they may use."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OIDN_NUM_THREADS")
    # The denoiser would bind its threads to the same first cores in every worker.
    return dict.fromkeys(names, str(count)) | {"OIDN_SET_AFFINITY": "0"}
