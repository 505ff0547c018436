from __future__ import annotations

import os
import subprocess
import sys

import pytest

from glassware.core.atomic_io import atomic_file, atomic_folder, remove_folder, remove_leftovers, write_atomically


def _names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_a_folder_appears_only_when_it_is_whole(tmp_path):
    with atomic_folder(tmp_path / "a") as partial:
        (partial / "file").write_text("x")
        assert not (tmp_path / "a").exists()
    assert (tmp_path / "a" / "file").read_text() == "x"
    assert _names(tmp_path) == ["a"]


def _fail(folder, error):
    (folder / "file").write_text("x")
    raise error


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_what_goes_wrong_leaves_the_old_folder_and_nothing_else(tmp_path, error):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "old").write_text("x")
    with pytest.raises(error), atomic_folder(tmp_path / "a") as partial:
        _fail(partial, error)
    assert _names(tmp_path) == ["a"]
    assert _names(tmp_path / "a") == ["old"]


def test_a_folder_replaces_the_one_before_it(tmp_path):
    for name in ("first", "second"):
        with atomic_folder(tmp_path / "a") as partial:
            (partial / name).write_text("x")
    assert _names(tmp_path) == ["a"]
    assert _names(tmp_path / "a") == ["second"]


def test_leftovers_of_dead_processes_are_removed_and_those_of_live_ones_stay(tmp_path):
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    alive = os.getppid()
    for name in (f".a.partial-{done.pid}", f".b.partial-{alive}", f".c.partial-{os.getpid()}", ".mine", "d"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").write_text("x")
    (tmp_path / f".e.json.partial-{done.pid}").write_text("x")
    remove_leftovers(tmp_path)
    assert _names(tmp_path) == sorted([f".b.partial-{alive}", ".mine", "d"])


def test_a_folder_moved_aside_by_a_killed_process_is_put_back(tmp_path):
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    (tmp_path / f".000007.old-{done.pid}").mkdir()
    (tmp_path / f".000008.old-{done.pid}").mkdir()
    (tmp_path / "000008").mkdir()
    remove_leftovers(tmp_path)
    assert _names(tmp_path) == ["000007", "000008"]


def test_a_file_is_replaced_whole(tmp_path):
    write_atomically(tmp_path / "a", b"first")
    write_atomically(tmp_path / "a", b"second")
    assert (tmp_path / "a").read_bytes() == b"second"
    assert _names(tmp_path) == ["a"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_file_that_goes_wrong_leaves_the_one_before(tmp_path, error):
    (tmp_path / "a").write_text("first")

    def failing():
        with atomic_file(tmp_path / "a") as partial:
            partial.write_text("sec")
            raise error

    with pytest.raises(error):
        failing()
    assert (tmp_path / "a").read_text() == "first"
    assert _names(tmp_path) == ["a"]


def test_a_discarded_folder_is_gone_with_all_in_it(tmp_path):
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "b" / "file").write_text("x")
    remove_folder(tmp_path / "a")
    assert _names(tmp_path) == []
