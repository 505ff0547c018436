"""The lock of an output folder, between processes."""

from __future__ import annotations

import subprocess
import sys

import pytest

from glassware.core.errors import InputError
from glassware.core.folder_lock import LOCK, locked_folder

#: A process that works in a folder until its input ends.
WORK = """
import sys
from pathlib import Path
from glassware.core.folder_lock import locked_folder
with locked_folder(Path(sys.argv[1]), "build", print):
    print("at work", flush=True)
    sys.stdin.read()
"""


def test_a_folder_is_taken_by_one_process_at_a_time_and_freed_when_it_dies(tmp_path):
    root, command = tmp_path / "out", [sys.executable, "-P", "-c", WORK]
    with subprocess.Popen([*command, str(root)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "at work\n"
        with pytest.raises(InputError, match="out: expected a folder that no other build works in, found another"):
            locked_folder(root, "build", print).__enter__()
        other.kill()
        other.wait()
    assert [path.name for path in root.iterdir()] == [LOCK]  # left behind, unlocked
    with locked_folder(root, "build", print):
        (root / "kept").write_text("x")
    assert [path.name for path in root.iterdir()] == ["kept"]


def test_a_new_folder_in_which_nothing_was_begun_is_removed(tmp_path):
    with locked_folder(tmp_path / "out", "build", print):
        assert (tmp_path / "out").is_dir()
    assert not (tmp_path / "out").exists()
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="file: expected a folder that can be created and written to"):
        locked_folder(tmp_path / "file", "build", print).__enter__()
