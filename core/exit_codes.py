"""Exit codes of commands: 0 success, 1 the work failed, 2 invalid request, 130 stopped by Ctrl-C, 143 by SIGTERM."""

from __future__ import annotations

import errno
from collections.abc import Callable

from rich.console import Console

from .errors import InputError
from .stopping import exit_code, handle_stop_signals, was_stopped

#: Errors of a full disk, a quota or a limit on file sizes.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
#: Errors of a disk that became read-only, or of permissions that were revoked, during the work.
_REFUSED = (errno.EROFS, errno.EACCES, errno.EPERM)


class WorkFailed(Exception):
    """The work failed for a known reason: commands print one line, without a traceback, and exit with code 1."""


def run_command(command: Callable[[], None]) -> int:
    """Run a command and return its exit code; print an invalid request as one line. Bugs stay tracebacks."""
    console = Console(stderr=True)
    try:
        with handle_stop_signals():
            command()
    except InputError as error:
        console.print(" ".join(str(error).split()), markup=False, highlight=False, soft_wrap=True)
        return 2
    except WorkFailed as error:
        console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 1
    except BaseException as error:
        # Dr.Jit and the import system wrap exceptions that a signal handler raises inside them.
        if _is_stop(error):
            console.print("stopped; no incomplete files are left", markup=False, highlight=False)
            return exit_code()
        if isinstance(error, OSError) and error.errno in _FULL:
            console.print(f"no room to write: {error}", markup=False, highlight=False, soft_wrap=True)
            return 1
        if isinstance(error, OSError) and error.errno in _REFUSED:
            console.print(f"writing is no longer permitted: {error}", markup=False, highlight=False, soft_wrap=True)
            return 1
        raise
    return 0


def _is_stop(error: BaseException | None) -> bool:
    """Return whether a stop signal caused an error."""
    if was_stopped():
        return True
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
