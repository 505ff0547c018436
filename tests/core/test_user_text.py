"""Paths in settings."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import TypeAdapter, ValidationError

from glassware.core.user_text import UserPath

PATHS = TypeAdapter(UserPath)


def test_a_path_of_a_yaml_file_is_expanded_as_a_shell_would(monkeypatch) -> None:
    monkeypatch.setenv("HOME", "/home/ada")
    monkeypatch.setenv("DATA", "/data")
    assert PATHS.validate_python("$HOME/hdri") == Path("/home/ada/hdri")
    assert PATHS.validate_python("~/hdri") == Path("/home/ada/hdri")
    assert PATHS.validate_python("${DATA}/maps") == Path("/data/maps")
    assert PATHS.validate_python(Path("~/hdri")) == Path("/home/ada/hdri")


def test_what_cannot_be_expanded_stays_as_it_is(monkeypatch) -> None:
    monkeypatch.delenv("NOT_SET", raising=False)
    for text in ("$NOT_SET/hdri", "a~b", "~nobody-of-this-name/x", "plain/folder"):
        assert PATHS.validate_python(text) == Path(text)
    with pytest.raises(ValidationError, match="expected a path, found ''"):
        PATHS.validate_python("")
