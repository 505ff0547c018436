"""Being stopped: Ctrl-C and a scheduler's SIGTERM end the work between two steps, and are never lost."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals that ask a command to stop. One that the parent process ignores stays ignored, as for jobs in a script's
#: background.
_SIGNALS = (signal.SIGINT, signal.SIGTERM)

_received: list[int] = []


@contextmanager
def stoppable() -> Iterator[None]:
    """Turn signals that ask to stop into `KeyboardInterrupt` inside, and remember them."""
    _received.clear()
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    for number in _SIGNALS:
        if before[number] != signal.SIG_IGN:
            signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def check_stop() -> None:
    """Raise `KeyboardInterrupt` if a signal was received; a library may have swallowed the first one."""
    if _received:
        raise KeyboardInterrupt


def was_stopped() -> bool:
    """Return whether a signal to stop was received."""
    return bool(_received)


def exit_code() -> int:
    """Return what a shell reports for a program that the signal ended: 128 and its number (130 for Ctrl-C)."""
    return 128 + (_received[0] if _received else signal.SIGINT)


def _stop(number: int, _frame: FrameType | None) -> None:
    _received.append(number)
    raise KeyboardInterrupt
