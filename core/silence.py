"""Decoders that print: a stretch of time in which nothing reaches the terminal.

OpenEXR, libpng, libtiff and OpenCV say what is wrong with a file on the process's own stderr or stdout, from C, where
`contextlib.redirect_stderr` does not reach. A damaged file would then leave lines of theirs beside our one line that
names it, in a log that is read line by line.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Lock

_STDOUT, _STDERR = 1, 2
_lock = Lock()
#: How many stretches are going on, in all threads, and the files that the descriptors stood for before the first.
_depth = 0
_kept: dict[int, int] = {}


@contextmanager
def quiet() -> Iterator[None]:
    """Send the process's file descriptors 1 and 2 to /dev/null, and put them back however the block ends.

    They belong to the whole process: what other threads print meanwhile is lost too, so the block holds one call of a
    foreign decoder and no more. Blocks may be nested and may overlap in threads; the last to end puts them back.
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


def _redirect() -> None:
    _flush()
    for descriptor in (_STDOUT, _STDERR):
        # A process in the background may have closed them: then there is nothing to put back.
        with suppress(OSError):
            _kept[descriptor] = os.dup(descriptor)
    nothing = os.open(os.devnull, os.O_WRONLY)
    for descriptor in _kept:
        os.dup2(nothing, descriptor)
    os.close(nothing)


def _restore() -> None:
    # What the decoder left in C's buffer must go where it was meant to go: nowhere.
    ctypes.CDLL(None).fflush(None)
    for descriptor, kept in _kept.items():
        os.dup2(kept, descriptor)
        os.close(kept)
    _kept.clear()


def _flush() -> None:
    """Write out what was printed before, in Python and in C."""
    for stream in (sys.stdout, sys.stderr):
        # None without a terminal; a closed stream or a pipe nobody reads is found by whoever prints next.
        if stream is not None:
            with suppress(OSError, ValueError):
                stream.flush()
    ctypes.CDLL(None).fflush(None)
