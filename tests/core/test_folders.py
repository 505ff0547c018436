"""Files in a user's folder."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from glassware.core.errors import InputError
from glassware.core.folders import files_in


def names(folder: Path, below: bool = True) -> list[str]:
    return [path.relative_to(folder).as_posix() for path in files_in(folder, "pictures", (".png",), below)]


def touch(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"")
    return path


def test_hidden_files_and_folders_are_left_out(tmp_path) -> None:
    for name in ("a.png", "._a.png", ".cache/b.png", "sub/c.PNG", "sub/.~lock.c.png#", "d.txt"):
        touch(tmp_path / name)
    assert names(tmp_path) == ["a.png", "sub/c.PNG"]
    assert names(tmp_path, below=False) == ["a.png"]


def test_links_to_folders_are_followed_once(tmp_path) -> None:
    touch(tmp_path / "elsewhere" / "a.png")
    folder = tmp_path / "mine"
    touch(folder / "b.png")
    (folder / "linked").symlink_to(tmp_path / "elsewhere")
    (folder / "linked" / "back").symlink_to(folder)  # a circle
    (folder / "again").symlink_to(folder / "linked")
    assert names(folder) == ["again/a.png", "b.png"]


def test_a_link_to_nothing_counts_as_a_file(tmp_path) -> None:
    (tmp_path / "a.png").symlink_to(tmp_path / "nowhere.png")
    assert names(tmp_path) == ["a.png"]


def test_a_missing_folder_a_file_and_an_empty_folder_are_refused(tmp_path) -> None:
    for path, found in (
        (tmp_path / "none", "no such folder"),
        (touch(tmp_path / "a.txt"), "a file of another format"),
        (touch(tmp_path / "a.png"), "a file$"),
        (touch(tmp_path / "sub" / "b.fbx").parent, r"none in 1 file \(1 .fbx\)"),
        (touch(tmp_path / "hidden" / ".b.png").parent, "none$"),
    ):
        with pytest.raises(InputError, match=f"found {found}"):
            names(path)


def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.obj")
    (tmp_path / "b.obj").touch()
    assert files_in(tmp_path, "meshes", (".obj",), below=False) == (tmp_path / "b.obj",)
