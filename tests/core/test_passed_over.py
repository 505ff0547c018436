"""Files that are passed over: counted, listed, remembered, and the end of a strict run."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from glassware.core.errors import InputError
from glassware.core.passed_over import MOST_LINES, Finding, check_strict, checked_files, report
from glassware.core.remembered import Checked


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "meshes"
    folder.mkdir()
    for name in ("a.obj", "b.obj", "c.obj"):
        (folder / name).write_text(name)
    return folder


def _checked(folder: Path, bad: str = "", looked_at: list[str] | None = None) -> tuple:
    def check(path: Path) -> Checked:
        if looked_at is not None:
            looked_at.append(path.name)
        if path.stem in bad:
            raise InputError(path, "a good file", "a bad one")
        return Checked(others=(folder / "shared.mtl",), remarks=("a small thing",) if path.stem == "c" else ())

    files = sorted(folder.glob("*.obj"))
    return checked_files(files, Path, check, folder="mesh_dir", root=folder, content="meshes", version=1)


def test_a_bad_file_is_passed_over_with_its_reason_and_the_rest_is_used(folder: Path) -> None:
    good, findings = _checked(folder, "b")
    assert [path.name for path, _ in good] == ["a.obj", "c.obj"]
    assert [(item.path, item.used) for item in findings] == [("b.obj", False), ("c.obj", True)]
    assert report(findings) == [
        "mesh_dir: 1 file passed over",
        "  b.obj: expected a good file, found a bad one",
        "mesh_dir: 1 file used with a remark",
        "  c.obj: a small thing",
    ]


def test_a_long_list_is_cut_and_says_so() -> None:
    many = [Finding(folder="hdri_dir", path=f"{i}.exr", reason="damaged") for i in range(MOST_LINES + 5)]
    assert len(report(many)) == MOST_LINES + 2
    assert report(many)[-1] == "  and 5 more, all listed in dataset.json"


def test_a_strict_run_ends_with_the_first_bad_file_and_a_remark_ends_none(folder: Path) -> None:
    check_strict(_checked(folder)[1])
    for name in ("a.obj", "b.obj"):
        (folder / name).write_text("changed")
    findings = _checked(folder, "ab")[1]
    with pytest.raises(InputError, match=r"--strict: expected .*a\.obj.*\(and 1 more file\)"):
        check_strict(findings)


def test_an_empty_rest_is_an_error_that_says_why(folder: Path) -> None:
    with pytest.raises(InputError, match=r"expected meshes that can be used, found none in 3 files; mesh_dir: a\.obj"):
        _checked(folder, "abc")


def test_a_file_is_checked_again_only_where_it_or_another_that_matters_has_changed(folder: Path) -> None:
    looked_at: list[str] = []
    first = _checked(folder, "b", looked_at)
    assert _checked(folder, "b", looked_at) == first
    assert looked_at == ["a.obj", "b.obj", "c.obj"]
    os.utime(folder / "a.obj", ns=(1, 1))
    _checked(folder, "b", looked_at)
    assert looked_at[3:] == ["a.obj"]
    (folder / "shared.mtl").write_text("now there is one")
    _checked(folder, "b", looked_at)
    assert looked_at[4:] == ["a.obj", "c.obj"]


def test_a_home_that_cannot_be_written_or_a_damaged_memory_only_costs_time(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = _checked(folder, "b")
    (kept,) = (tmp_path / "cache" / "glassware").iterdir()
    kept.write_bytes(b'{"x": \xff')
    assert _checked(folder, "b") == first
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    assert _checked(folder, "b") == first


def test_paths_in_reasons_begin_at_the_folder_however_it_was_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder.parent)
    near = Path(folder.name)

    def check(path: Path) -> Checked:
        return Checked(remarks=(f"{near / 'tex.png'} and {folder / 'tex.png'}",))

    files = sorted(near.glob("a.obj"))
    _, findings = checked_files(files, Path, check, folder="mesh_dir", root=near, content="meshes", version=3)
    assert [item.reason for item in findings] == ["tex.png and tex.png"]
