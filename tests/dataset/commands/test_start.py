"""A signal that meets a command while its libraries load ends it at once, in one line."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest


@pytest.mark.parametrize("command", ["build-dataset", "render-scene", "glassware"])
def test_every_command_begins_where_signals_already_count(command):
    script = (Path(sys.executable).parent / command).read_text()
    assert "glassware.dataset.commands.start" in script


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("wait", [0.15, 0.4])
def test_a_signal_while_libraries_load_ends_a_command_in_one_line(tmp_path, number, code, wait):
    # A parent in a script's background ignores SIGINT, and its children would inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    # The first line of the child's program says that it runs; what follows is what the installed script does.
    program = (
        "import sys; print('on', flush=True); from glassware.dataset.commands.start import build_dataset; "
        "sys.exit(build_dataset())"
    )
    arguments = ["--scenes", "0:1", "--out", str(tmp_path / "data")]
    try:
        child = subprocess.Popen(
            [sys.executable, "-P", "-c", program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert child.stdout is not None
    assert child.stdout.readline() == "on\n"
    time.sleep(wait)  # loading takes longer, whatever the machine
    child.send_signal(number)
    _, said = child.communicate(timeout=60)
    assert child.returncode == code, said
    assert said == "stopped; no incomplete files are left\n"
    assert not (tmp_path / "data").exists()
