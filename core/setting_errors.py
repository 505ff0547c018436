"""One error line for a setting with an invalid value: its full name, what was expected, what was found."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from reprlib import Repr

from pydantic import BaseModel, ValidationError

from .errors import InputError


def setting_error(
    where: object, error: ValidationError, model: type[BaseModel] | None = None, group: Sequence[str] = ()
) -> InputError:
    """Return the first fault of a validation as one line.

    Parameters
    ----------
    where : object
        What was validated: a file, a command.
    error : pydantic.ValidationError
        The validation error.
    model : type, optional
        The validated model, to suggest the correct spelling of an unknown setting.
    group : sequence of str
        Names of the fields that hold the validated model, outermost first.
    """
    first = error.errors(include_url=False)[0]
    place = [*group, *map(str, first["loc"])]
    if first["type"] == "extra_forbidden":
        return InputError(where, f"known settings{_suggestion(model, place)}", ".".join(place))
    expected, found = first["msg"].removeprefix("Input should be "), shortened(first["input"])
    ours = str(first.get("ctx", {}).get("error", ""))
    if ours:  # "expected ..., found ...", raised by one of our validators; one over several fields names a field first
        field, _, text = ours.rpartition("expected ")
        place += [field.removesuffix(": ")] if field else []
        expected, _, found = text.rpartition(", found ")
    return InputError(": ".join([str(where), *([".".join(place)] if place else [])]), expected, found)


def suggest(name: str, known: Sequence[str]) -> str:
    """Return a hint at the known name that is spelt most like an unknown one, such as `` (is it views?)``, or ''."""
    close = get_close_matches(name, known, n=1)
    return f" (is it {close[0]}?)" if close else ""


def shortened(value: object) -> str:
    """Return the representation of a value, cut where it is long or deep."""
    short = Repr()
    short.maxstring = short.maxother = short.maxlong = 80
    return short.repr(value)


def _suggestion(model: type[BaseModel] | None, place: Sequence[str]) -> str:
    for part in place[:-1]:
        inner = None if model is None else model.model_fields[part].annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return ""
        model = inner
    known = [] if model is None else [".".join([*place[:-1], name]) for name in model.model_fields]
    return suggest(".".join(place), known)
