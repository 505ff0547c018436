"""Exit codes of the commands: 0 success, 1 failure, 2 invalid input, 130 stopped by Ctrl-C, 143 by SIGTERM."""

from __future__ import annotations

import errno
from collections.abc import Callable

from rich.console import Console

from .errors import InputError
from .stopping import exit_code, stoppable, was_stopped

#: A full disk, an exceeded quota or file size limit: a failure, but neither invalid input nor a bug.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
#: A disk that became read-only, or permissions that were removed, while the command ran.
_REFUSED = (errno.EROFS, errno.EACCES, errno.EPERM)


class WorkFailed(Exception):
    """A failure with a known reason: printed as one line without a traceback, exit code 1."""


def outcome(command: Callable[[], None]) -> int:
    """Run a command and return its exit code. Invalid input prints one line; a bug of ours shows a traceback."""
    console = Console(stderr=True)
    try:
        with stoppable():
            command()
    except InputError as error:
        console.print(" ".join(str(error).split()), markup=False, highlight=False, soft_wrap=True)
        return 2
    except WorkFailed as error:
        console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 1
    except BaseException as error:
        # Dr.Jit and the import system wrap an exception that a signal handler raises inside them.
        if _stopped(error):
            console.print("stopped; nothing half-written is left", markup=False, highlight=False)
            return exit_code()
        if isinstance(error, OSError) and error.errno in _FULL:
            console.print(f"no room to write: {error}", markup=False, highlight=False, soft_wrap=True)
            return 1
        if isinstance(error, OSError) and error.errno in _REFUSED:
            console.print(f"cannot be written any more: {error}", markup=False, highlight=False, soft_wrap=True)
            return 1
        raise
    return 0


def _stopped(error: BaseException | None) -> bool:
    """Return whether a stop signal caused an error."""
    if was_stopped():
        return True
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
