from __future__ import annotations

import hashlib
import json

import pytest

from glassware.dataset.format.checksums import faults_of, write_checksums


@pytest.fixture
def folder(tmp_path):
    """A folder of two files, with its checksums."""
    (tmp_path / "000").mkdir()
    (tmp_path / "000" / "left.png").write_bytes(b"picture")
    (tmp_path / "scene.json").write_bytes(b"{}")
    write_checksums(tmp_path)
    return tmp_path


def test_the_record_has_size_and_digest_of_each_file(folder):
    record = json.loads((folder / "checksums.json").read_text())
    assert record["files"] == {
        "000/left.png": {"size": 7, "sha256": hashlib.sha256(b"picture").hexdigest()},
        "scene.json": {"size": 2, "sha256": hashlib.sha256(b"{}").hexdigest()},
    }
    assert list(faults_of(folder)) == []


def test_what_is_missing_new_longer_or_changed_is_named(folder):
    (folder / "scene.json").write_bytes(b"[]")
    (folder / "new").write_bytes(b"")
    assert [fault.split(": ")[0] for fault in faults_of(folder)] == [str(folder / "new"), str(folder / "scene.json")]
    (folder / "scene.json").write_bytes(b"{ }")
    (folder / "000" / "left.png").unlink()
    told = list(faults_of(folder, contents=False))
    assert told[0] == f"{folder / '000/left.png'}: expected a file, found none"
    assert told[2] == f"{folder / 'scene.json'}: expected 2 bytes, found 3"


def test_sizes_alone_do_not_see_a_changed_byte(folder):
    (folder / "scene.json").write_bytes(b"[]")
    assert list(faults_of(folder, contents=False)) == []


@pytest.mark.parametrize("text", [None, "", "{}", '{"schema_version": "glassware/checksums/9", "files": {}}'])
def test_a_record_that_is_missing_or_damaged_is_a_fault(folder, text):
    path = folder / "checksums.json"
    path.unlink() if text is None else path.write_text(text)
    (fault,) = faults_of(folder)
    assert str(path) in fault
