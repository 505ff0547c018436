"""Error messages for invalid settings: full name of the setting, expected values, value found."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import get_close_matches
from reprlib import Repr

from pydantic import BaseModel, ValidationError

from .errors import InputError

#: Form of the messages of our own checks; a check of several fields puts the name of the field first.
_OWN = re.compile(r"(?:(?P<field>\w+): )?expected (?P<expected>.*), found (?P<found>.*)", re.DOTALL)
#: Messages of Python for text that is not a number, and what we print as expected.
_NO_NUMBER = (
    (re.compile(r"invalid literal for int\(\) with base 10: (.*)", re.DOTALL), "a whole number"),
    (re.compile(r"could not convert string to float: (.*)", re.DOTALL), "a number"),
    (re.compile(r"Exceeds the limit .*: value has (\d+ digits).*", re.DOTALL), "a whole number of few digits"),
)


def setting_error(where: object, error: ValidationError, model: type[BaseModel] | None = None) -> InputError:
    """Return the first error of a validation as one line.

    Parameters
    ----------
    where : object
        What was validated: a file, a command.
    error : pydantic.ValidationError
        Of `model`, or of one of the models that it holds.
    model : type, optional
        Model of all settings, which gives fields their full names.
    """
    first = error.errors()[0]
    place = [*([] if model is None else _group(model, error.title)), *first["loc"]]
    expected, found = _rule(first["msg"]), shortened(first["input"])
    if first["type"] == "extra_forbidden":
        return InputError(where, f"known settings{_nearest(model, place)}", ".".join(map(str, place)))
    own = _OWN.fullmatch(str(first.get("ctx", {}).get("error", "")))
    if own:
        place += [own["field"]] if own["field"] else []
        expected, found = own["expected"], own["found"]
    return InputError(": ".join([str(where), *([".".join(map(str, place))] if place else [])]), expected, found)


def parser_error(where: str, message: str, options: Sequence[str]) -> InputError:
    """Return an error of the command-line parser as one line of ours.

    Parameters
    ----------
    where : str
        The command.
    message : str
        The parser's message, on one line.
    options : sequence of str
        All options in full, such as ``--cameras.views``.
    """
    named = next((option for option in sorted(options, key=len, reverse=True) if _names(message, option)), None)
    place = where if named is None else f"{where}: {named.removeprefix('--').replace('-', '_')}"
    for words, expected in _NO_NUMBER:
        found = words.search(message)
        if found:
            return InputError(place, expected, re.sub(r" For further.*", "", found.group(1)))
    missing = re.search(r"Missing value for argument \S+ Expected (\S+ values?|\S.*?)\.$", message)
    if missing:
        return InputError(place, missing.group(1), "fewer")
    lacking = re.search(r"Missing from .*?: (.+)$", message)
    if lacking:
        return InputError(where, lacking.group(1).strip(), "nothing")
    choice = re.search(r"invalid choice (.*?) for argument \S+ Expected one of \((.*)\)", message)
    if choice:
        return InputError(place, f"one of {choice.group(2)}", choice.group(1))
    known = re.search(r"Perhaps you meant: (\S+?),? ", message)
    hint = f" (is it {known.group(1)}?)" if known else ""
    found = re.sub(r"^Unrecognized options: ", "", re.sub(r" Perhaps you meant:.*", "", message))
    return InputError(where, "known settings with valid values (see --help)", found + hint)


def shortened(value: object) -> str:
    """Return a value as Python writes it, cut where it is long or deep."""
    short = Repr()
    short.maxstring = short.maxother = short.maxlong = 80
    return short.repr(value)


def _names(message: str, option: str) -> bool:
    return re.search(rf"{re.escape(option)}(?![\w.-]*\w)", message) is not None


def _group(model: type[BaseModel], title: str) -> list[str]:
    """Return the name of the field that holds the model of this title; nothing for the top model itself."""
    groups = ((name, field.annotation) for name, field in model.model_fields.items())
    return [name for name, kind in groups if isinstance(kind, type) and kind.__name__ == title][:1]


def _rule(message: str) -> str:
    return re.sub(r"^(Input should be|Value error,)( expected)? ?", "", message)


def _nearest(model: type[BaseModel] | None, place: Sequence[int | str]) -> str:
    """Return a hint with the known setting closest in spelling to an unknown one, or nothing."""
    for part in place[:-1]:
        inner = None if model is None else model.model_fields[str(part)].annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return ""
        model = inner
    near = [] if model is None else get_close_matches(str(place[-1]), model.model_fields, n=1)
    return f" (is it {'.'.join([*map(str, place[:-1]), near[0]])}?)" if near else ""
