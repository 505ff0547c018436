"""How every command ends: 0 done, 1 the work failed, 2 the request was wrong; 130 stopped by Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable

from rich.console import Console

from ...procedural.errors import InputError
from .stopping import exit_code, stoppable


def outcome(command: Callable[[], None]) -> int:
    """Run a command and return its exit code; a wrong request is told in one line, a fault of ours as a traceback."""
    console = Console(stderr=True)
    try:
        with stoppable():
            command()
    except InputError as error:
        console.print(" ".join(str(error).split()), markup=False, highlight=False, soft_wrap=True)
        return 2
    except (KeyboardInterrupt, RuntimeError) as error:
        if not _stopped(error):
            raise
        console.print("stopped; nothing half-written is left", markup=False, highlight=False)
        return exit_code()
    return 0


def _stopped(error: BaseException | None) -> bool:
    """Tell whether Ctrl-C is behind an error: Dr.Jit wraps what is raised while it records a loop."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
