"""``checksums.json``: the size and the SHA-256 of every file in a scene's folder, written with the scene."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Literal

from pydantic import Field

from ...core.errors import InputError
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from . import layout

CHECKSUMS_SCHEMA = "glassware/checksums/1"

Sha256 = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class FileSum(Model):
    """Expected size and digest of a file."""

    size: int = Field(ge=0, description="[bytes]")
    sha256: Sha256


class Checksums(Model):
    """All other files of a scene's folder, by their relative paths."""

    schema_version: Literal["glassware/checksums/1"] = CHECKSUMS_SCHEMA
    files: dict[str, FileSum]


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's content, read in blocks."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_checksums(folder: Path, known: Mapping[str, FileSum] = MappingProxyType({})) -> None:
    """Write ``checksums.json`` for all files in a scene's folder; those that are known already are not read."""
    files = {name: known.get(name) or _file_sum(path) for name, path in _files(folder)}
    text = json_text(Checksums(files=files).model_dump(mode="json"))
    (folder / layout.CHECKSUMS).write_text(text, encoding="utf-8")


def _file_sum(path: Path) -> FileSum:
    return FileSum(size=path.stat().st_size, sha256=file_digest(path))


def read_checksums(folder: Path) -> Checksums:
    """Read a scene's record; InputError where it is missing or damaged."""
    path = folder / layout.CHECKSUMS
    data = read_json(path)
    check_schema(path, data, CHECKSUMS_SCHEMA)
    return parsed(Checksums, data, path)


def faults_of(folder: Path, contents: bool = True) -> Iterator[str]:
    """Yield the faults of the files in a scene's folder, one line each.

    Parameters
    ----------
    folder : Path
        The scene's folder.
    contents : bool
        Whether files are read and hashed; names and sizes are compared in any case.
    """
    try:
        expected = read_checksums(folder).files
    except InputError as error:
        yield str(error)
        return
    existing = dict(_files(folder))
    for name in sorted(expected.keys() | existing.keys()):
        if name not in existing:
            yield f"{folder / name}: expected a file, found none"
        elif name not in expected:
            yield f"{existing[name]}: expected only files that {layout.CHECKSUMS} names, found this one"
        else:
            yield from _file_fault(existing[name], expected[name], contents)


def _file_fault(path: Path, expected: FileSum, contents: bool) -> Iterator[str]:
    size = path.stat().st_size
    if size != expected.size:
        yield f"{path}: expected {expected.size} bytes, found {size}"
    elif contents and (found := file_digest(path)) != expected.sha256:
        yield f"{path}: expected SHA-256 {expected.sha256[:12]}..., found {found[:12]}..."


def _files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield relative path and path of each file of a scene except its checksums, in order."""
    for parent, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            path = Path(parent, name)
            relative = path.relative_to(folder).as_posix()
            if relative != layout.CHECKSUMS:
                yield relative, path
