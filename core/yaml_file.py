"""YAML files of settings: small regular files of plain data, in which no name occurs twice."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter, ValidationError
from yaml.reader import ReaderError

from .errors import InputError
from .folders import regular_content
from .setting_errors import setting_error
from .user_text import UserPath

#: Largest file that is read [bytes]: all settings with their descriptions are below a hundredth of it.
MAX_SIZE = 1_000_000


def yaml_settings(path: str | Path, where: str = "--config") -> dict[str, Any]:
    """Return the mapping in a YAML file; InputError where it cannot be read, by `where` for an impossible path."""
    text = _text(_checked(path, where))
    try:
        _check_names(path, yaml.compose(text, yaml.SafeLoader), set())
        settings = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise InputError(yaml_place(path, error), "valid YAML", yaml_problem(error)) from error
    except InputError:
        raise
    except ValueError as error:  # impossible dates and numbers
        raise InputError(path, "valid YAML values", str(error)) from error
    except RecursionError as error:
        raise InputError(path, "valid YAML", "too deeply nested values") from error
    if not isinstance(settings, dict | None):
        raise InputError(path, "a mapping of settings", type(settings).__name__)
    return settings or {}


def yaml_place(path: str | Path, error: yaml.YAMLError) -> str:
    """Return the file, and where it is known the line and column, both from 1, at which YAML does not go on."""
    mark = error.problem_mark if isinstance(error, yaml.MarkedYAMLError) else None
    return f"{path}, line {mark.line + 1}, column {mark.column + 1}" if mark else str(path)


def _code_point(character: str | int) -> int:
    return character if isinstance(character, int) else ord(character)


def yaml_problem(error: yaml.YAMLError) -> str:
    """Return what is wrong there, on one line."""
    if isinstance(error, ReaderError):
        return f"the character U+{_code_point(error.character):04X} at position {error.position}"
    found = [error.context, error.problem] if isinstance(error, yaml.MarkedYAMLError) else [str(error)]
    return " ".join(" ".join(text.split()) for text in found if text)


def _check_names(path: str | Path, node: yaml.Node | None, seen: set[int]) -> None:
    """Raise InputError where a mapping has a name twice: PyYAML would silently take the last value."""
    if node is None or id(node) in seen:  # an alias of a node that was visited before
        return
    seen.add(id(node))
    if isinstance(node, yaml.MappingNode):
        names = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
        for name, times in names.most_common(1):
            if times > 1:
                raise InputError(path, "each setting once", f"{name} {times} times")
        for _, value in node.value:
            _check_names(path, value, seen)
    elif isinstance(node, yaml.SequenceNode):
        for value in node.value:
            _check_names(path, value, seen)


def _checked(path: str | Path, where: str) -> Path:
    try:
        return TypeAdapter(UserPath).validate_python(path)
    except ValidationError as error:
        raise setting_error(where, error) from error


def _text(path: Path) -> str:
    content = regular_content(path, "with YAML", MAX_SIZE, f"a YAML file of at most {MAX_SIZE} bytes")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(path, "a YAML file in UTF-8", "other bytes") from error
