"""Twins store equal files once: nothing that a reader sees changes, and wrong requests are one line."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from glassware.core.errors import InputError
from glassware.dataset.builds.shared_files import check_original, share_equal_files
from glassware.dataset.commands.build_dataset import main
from glassware.dataset.format.checksums import faults_of, write_checksums


def _scene(root: Path, number: int, **files: bytes) -> Path:
    folder = root / "scenes" / f"{number:06d}"
    (folder / "meshes").mkdir(parents=True)
    for name, content in files.items():
        (folder / "meshes" / f"{name}.ply").write_bytes(content)
    write_checksums(folder)
    return folder


def test_equal_files_become_one_and_all_others_stay(tmp_path):
    original, root = tmp_path / "glass", tmp_path / "painted"
    first = _scene(original, 0, table=b"board", cup=b"glass", left=b"only here")
    twin = _scene(root, 0, table=b"board", cup=b"paint")
    alone = _scene(root, 1, table=b"board")
    assert share_equal_files(root, original) == (1, len(b"board"))
    assert (first / "meshes/table.ply").samefile(twin / "meshes/table.ply")
    assert not (first / "meshes/table.ply").samefile(alone / "meshes/table.ply")
    assert (twin / "meshes/cup.ply").read_bytes() == b"paint"
    assert [fault for folder in (first, twin, alone) for fault in faults_of(folder)] == []
    assert share_equal_files(root, original) == (1, len(b"board"))  # again, where it is one already
    shutil.rmtree(original)
    assert list(faults_of(twin)) == []


def test_a_file_that_was_changed_after_its_checksum_is_not_shared(tmp_path):
    original, root = tmp_path / "glass", tmp_path / "painted"
    damaged = _scene(original, 0, table=b"board")
    twin = _scene(root, 0, table=b"board")
    (damaged / "meshes/table.ply").write_bytes(b"bored")
    assert share_equal_files(root, original) == (0, 0)
    assert (twin / "meshes/table.ply").read_bytes() == b"board"


def test_a_data_set_is_no_twin_of_itself_and_twin_of_needs_a_twin(tmp_path):
    with pytest.raises(InputError, match=r"--twin-of: expected another folder than --out"):
        check_original(tmp_path, tmp_path, 1, "opaque")
    with pytest.raises(InputError, match=r"--twin-of: expected it with --twin"):
        check_original(tmp_path / "a", tmp_path, 1, "none")


def test_a_folder_that_is_no_data_set_is_one_line_and_nothing_is_made(tmp_path, capsys):
    out = tmp_path / "painted"
    given = ["--scenes", "0:1", "--out", str(out), "--twin", "opaque", "--twin-of", str(tmp_path / "nowhere")]
    assert main(given) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "dataset.json" in line
    assert not out.exists()
