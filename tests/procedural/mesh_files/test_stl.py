"""STL files: text in capitals, several solids, binary files that begin as text does, and files that are cut short."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.core.errors import InputError


def _text(makers: ModuleType, name: str = "a") -> str:
    rows = [f"solid {name}"]
    for corners in makers.POSITIONS[makers.TRIANGLES]:
        rows += ["facet normal 0 0 0", "outer loop", *("vertex {:e} {:e} {:e}".format(*corner) for corner in corners)]
        rows += ["endloop", "endfacet"]
    return "\n".join([*rows, f"endsolid {name}", ""])


def _binary(makers: ModuleType, head: bytes) -> bytes:
    corners = makers.POSITIONS[makers.TRIANGLES]
    records = [struct.pack("<12fH", 0, 0, 0, *one.ravel(), 0) for one in corners]
    return head.ljust(80) + struct.pack("<I", len(corners)) + b"".join(records)


def test_text_of_any_case_and_binary_files_that_begin_as_text_are_read(makers: ModuleType, tmp_path: Path) -> None:
    files = {
        "text.stl": _text(makers),
        "capitals.stl": _text(makers).upper(),
        "long.stl": _text(makers, "a name" * 300),
        "binary.stl": _binary(makers, b"solid made of one facet"),
        "trailing.stl": _binary(makers, b"solid") + b"rest",
    }
    makers.written(tmp_path, files)
    for name in files:
        (part,), _ = makers.parts_of(tmp_path / name)
        assert np.allclose(part.vertices[part.faces], makers.POSITIONS[makers.TRIANGLES])


def test_several_solids_in_a_file_are_all_read(makers: ModuleType, tmp_path: Path) -> None:
    (part,), _ = makers.parts_of(makers.written(tmp_path, {"a.stl": _text(makers) + _text(makers)}) / "a.stl")
    assert len(part.faces) == 8


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (lambda makers: _text(makers)[:-120], "10 corners, as of a file that is cut short"),
        (lambda makers: _binary(makers, b"solid")[:-20], "too short for 4"),
    ],
)
def test_a_file_that_is_cut_short_is_refused_and_not_read_in_part(
    makers: ModuleType, tmp_path: Path, content: Callable[[ModuleType], str | bytes], found: str
) -> None:
    with pytest.raises(InputError, match=found):
        makers.parts_of(makers.written(tmp_path, {"a.stl": content(makers)}) / "a.stl")
