"""Stop signals: Ctrl-C and a cluster scheduler's SIGTERM end the work between two steps, and are never lost."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals that stop a command. One that the parent process ignores stays ignored, as for background jobs of a script.
_SIGNALS = (signal.SIGINT, signal.SIGTERM)

_received: list[int] = []


@contextmanager
def handle_stop_signals() -> Iterator[None]:
    """Record stop signals inside the block, and raise `KeyboardInterrupt` for them."""
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
    """Raise `KeyboardInterrupt` if a stop signal was received; a library may have swallowed the first exception."""
    if _received:
        raise KeyboardInterrupt


def was_stopped() -> bool:
    """Return whether a stop signal was received."""
    return bool(_received)


def exit_code() -> int:
    """Return the exit code that shells report for the signal: 128 plus its number (130 for Ctrl-C)."""
    return 128 + (_received[0] if _received else signal.SIGINT)


def _stop(number: int, _frame: FrameType | None) -> None:
    _received.append(number)
    raise KeyboardInterrupt
