"""How every command ends: 0 done, 1 the work failed, 2 the request was wrong; 130 stopped by Ctrl-C, 143 by SIGTERM."""

from __future__ import annotations

import errno
from collections.abc import Callable

from rich.console import Console

from .errors import InputError
from .stopping import exit_code, stoppable, was_stopped

#: Errors of a disk, a quota or a limit on file sizes: the work failed; neither request nor program is wrong.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
#: Errors of a disk that became read-only, or of permissions that were taken away, while the work went on.
_REFUSED = (errno.EROFS, errno.EACCES, errno.EPERM)


class WorkFailed(Exception):
    """Work that could not be done for a reason that is told already: one line, exit code 1, no traceback."""


def outcome(command: Callable[[], None]) -> int:
    """Run a command and return its exit code; a wrong request is told in one line, a fault of ours as a traceback."""
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
        # Dr.Jit and the import system wrap what a signal raises inside them.
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
    """Tell whether a signal to stop is behind an error."""
    if was_stopped():
        return True
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
