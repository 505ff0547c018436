from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path
from threading import Event, Thread

import pytest

from glassware.core.silence import quiet

_LIBC = ctypes.CDLL(None)


def test_what_c_prints_is_lost_inside_and_only_inside(capfd):
    sys.stdout.write("before, from Python\n")
    _LIBC.puts(b"before, from C")
    with quiet():
        os.write(1, b"inside\n")
        os.write(2, b"inside\n")
        _LIBC.puts(b"inside, still in C's buffer at the end")
    sys.stdout.write("after, from Python\n")
    _LIBC.puts(b"after, from C")
    _LIBC.fflush(None)
    out, errors = capfd.readouterr()
    # capfd reads Python's and C's buffers as they were flushed.
    assert sorted(out.splitlines()) == ["after, from C", "after, from Python", "before, from C", "before, from Python"]
    assert errors == ""


def test_an_error_inside_leaves_the_descriptors_as_they_were(capfd):
    with pytest.raises(RuntimeError), quiet():
        raise RuntimeError
    os.write(2, b"told\n")
    assert capfd.readouterr().err == "told\n"


def test_stretches_that_overlap_in_threads_end_with_the_descriptors_as_they_were(capfd):
    entered, leave = Event(), Event()

    def other() -> None:
        with quiet():
            entered.set()
            leave.wait(10.0)

    thread = Thread(target=other)
    with quiet():
        thread.start()
        assert entered.wait(10.0)
    os.write(2, b"lost: the other is not done\n")
    leave.set()
    thread.join()
    os.write(2, b"told\n")
    assert capfd.readouterr().err == "told\n"


def _descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def test_no_descriptor_is_left_open():
    before = _descriptors()
    for _ in range(5):
        with quiet(), quiet():
            pass
    assert _descriptors() == before


def test_a_process_with_closed_descriptors_decodes_too():
    code = "from glassware.core.silence import quiet\nwith quiet():\n    pass\n"
    closing = ["sh", "-c", 'exec "$0" -P -c "$1" >&- 2>&-', sys.executable, code]
    assert subprocess.run(closing, check=False, timeout=60).returncode == 0
