"""Protocol buffers in text form: names with numbers, texts or groups, as KeyPose's ``.pbtxt`` files have them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ...core.errors import InputError, cause_of

#: Deepest nesting of groups that is read; KeyPose has three.
_DEEPEST = 20
_TOKEN = re.compile(r'\s+|#[^\n]*|(?P<token>[A-Za-z_]\w*|[-+]?[\d.][\w.+-]*|"(?:[^"\\]|\\.)*"|[{}:,;])')

#: A group: every value that a name has, in order.
Group = dict[str, list[Any]]


def read_text_proto(path: Path) -> Group:
    """Return the content of a file; each name has the list of its values: floats, texts and groups.

    Raises
    ------
    InputError
        Where the file is missing, cut short or no such text.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error
    except UnicodeDecodeError as error:
        raise InputError(path, "a text", "other bytes") from error
    tokens, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise InputError(path, "protocol buffers as text", f"{text[at : at + 20]!r} at character {at}")
        at = match.end()
        if match["token"]:
            tokens.append(match["token"])
    group, end = _group(tokens, 0, path, 0)
    if end != len(tokens):
        raise InputError(path, "protocol buffers as text", f"a {tokens[end]} that closes no group")
    return group


def numbers(group: Group, name: str, count: int, where: object) -> list[float]:
    """Return the numbers that a name has in a group; InputError unless there are as many as expected."""
    values = group.get(name, [])
    if len(values) != count or not all(isinstance(value, float) for value in values):
        raise InputError(f"{where}: {name}", f"{count} number{'s' if count > 1 else ''}", f"{len(values)} values")
    return values


def _group(tokens: list[str], at: int, path: Path, depth: int) -> tuple[Group, int]:
    if depth > _DEEPEST:
        raise InputError(path, f"groups at most {_DEEPEST} deep", "deeper ones")
    found: Group = {}
    while at < len(tokens) and tokens[at] != "}":
        name, at = tokens[at], at + 1
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            raise InputError(path, "a name", name)
        if at < len(tokens) and tokens[at] == ":":
            at += 1
        if at >= len(tokens):
            raise InputError(path, f"a value of {name}", "the end of the file")
        if tokens[at] == "{":
            value, at = _group(tokens, at + 1, path, depth + 1)
            if at >= len(tokens):
                raise InputError(path, f"a closed group {name}", "the end of the file")
            at += 1
        else:
            value, at = _value(tokens[at], path, name), at + 1
        found.setdefault(name, []).append(value)
        while at < len(tokens) and tokens[at] in (",", ";"):
            at += 1
    return found, at


def _value(token: str, path: Path, name: str) -> float | str:
    if token.startswith('"'):
        return token[1:-1]
    if re.fullmatch(r"[A-Za-z_]\w*", token) and token not in ("inf", "nan"):
        return token
    try:
        return float(token)
    except ValueError as error:
        raise InputError(f"{path}: {name}", "a number", token) from error
