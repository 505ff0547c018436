"""Suppress the terminal output of C libraries.

OpenEXR, libpng, libtiff and OpenCV print errors to the process's stderr or stdout from C, where
`contextlib.redirect_stderr` has no effect. For a damaged file, the log should hold our one line only.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from threading import Lock

_STDOUT, _STDERR = 1, 2
_lock = Lock()
#: Number of active `quiet` blocks in all threads, and duplicates of the original descriptors.
_depth = 0
_kept: dict[int, int] = {}


@contextmanager
def quiet() -> Iterator[None]:
    """Redirect the process's file descriptors 1 and 2 to /dev/null inside the block.

    This affects all threads, so a block should hold one library call and nothing else. Blocks may be nested and may
    overlap in threads; the last one to end restores the descriptors.
    """
    global _depth
    with _lock:
        if _depth == 0:
            _redirect()
        _depth += 1
    try:
        yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                _restore()


@cache
def _c_library() -> ctypes.CDLL:
    """Return the functions of C; `ctypes` would make a class each time, which takes as long as the redirection."""
    return ctypes.CDLL(None)


def _redirect() -> None:
    _flush()
    for descriptor in (_STDOUT, _STDERR):
        # A background process may have closed them; they stay closed then.
        with suppress(OSError):
            _kept[descriptor] = os.dup(descriptor)
    nothing = os.open(os.devnull, os.O_WRONLY)
    for descriptor in _kept:
        os.dup2(nothing, descriptor)
    os.close(nothing)


def _restore() -> None:
    # Discard what the library left in C's buffer.
    _c_library().fflush(None)
    for descriptor, kept in _kept.items():
        os.dup2(kept, descriptor)
        os.close(kept)
    _kept.clear()


def _flush() -> None:
    """Flush what was printed before, in Python and in C."""
    for stream in (sys.stdout, sys.stderr):
        # None without a terminal. The next print reports a closed stream or a broken pipe.
        if stream is not None:
            with suppress(OSError, ValueError):
                stream.flush()
    _c_library().fflush(None)
