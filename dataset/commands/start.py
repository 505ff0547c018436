"""Entry points of the commands: they handle stop signals before any library is imported.

The imports take up to a second. A Ctrl-C during that time would end in a traceback from inside a library. Nothing has
been written by then, so the process can exit at once.
"""

from __future__ import annotations

import os
import signal
import sys
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
        if signal.getsignal(number) != signal.SIG_IGN:  # ignored for background jobs of a script
            signal.signal(number, _exit)
    if "--version" in sys.argv[1:]:
        from importlib.metadata import version  # here, as it loads so much that a signal may come before the handlers

        sys.stdout.write(f"glassware {version('glassware')}\n")
        return 0
    return import_module(f"{__package__}.{name}").main()


def _exit(number: int, _frame: FrameType | None) -> None:
    os.write(2, b"stopped; no incomplete files are left\n")
    os._exit(128 + number)
