"""Where commands begin: signals that ask to stop count from the first line on, while libraries still load.

Loading takes a second or two. A Ctrl-C that meets it would end in a traceback out of some library, and may leave the
library half loaded. Nothing is written by then, so the process can end at once.
"""

from __future__ import annotations

import os
import signal
from importlib import import_module
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def build_dataset() -> int:
    """Run ``build-dataset``."""
    return _run("build_dataset")


def glassware() -> int:
    """Run ``glassware``."""
    return _run("glassware")


def render_scene() -> int:
    """Run ``render-scene``."""
    return _run("render_scene")


def _run(name: str) -> int:
    for number in _SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:  # as for jobs in a script's background
            signal.signal(number, _end)
    return import_module(f"{__package__}.{name}").main()


def _end(number: int, _frame: FrameType | None) -> None:
    os.write(2, b"stopped; nothing half-written is left\n")
    os._exit(128 + number)
