"""One error line for a setting with an invalid value: its full name, what was expected, what was found."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from reprlib import Repr
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from .errors import InputError
from .model import Ordered
from .units import decimal_hint

#: A name among those that pydantic expects of a literal.
_QUOTED = re.compile(r"'([^']*)'")
#: What pydantic expects, in plain words, by its types of errors.
_PLAIN = {
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "bool_type": "yes or no (True or False)",
    "bool_parsing": "yes or no (True or False)",
    "string_type": "a text",
    "path_type": "a path",
    "tuple_type": "several values (a tuple or a list)",
    "list_type": "several values (a list)",
    "dict_type": "settings by name (a dict)",
    "string_pattern_mismatch": "a text of the right form",
}


def setting_error(
    where: object,
    error: ValidationError,
    model: type[BaseModel] | None = None,
    group: Sequence[str] = (),
    noun: str = "settings",
) -> InputError:
    """Return the first fault of a validation as one line, or all of them where names are not known.

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
    noun : str
        What the fields are.
    """
    faults = error.errors(include_url=False)
    first = faults[0]
    loc = _place(first)
    unknown = [[*group, *_place(one)] for one in faults if one["type"] == "extra_forbidden"]
    if first["type"] == "extra_forbidden" and len(unknown) == 1:
        return InputError(where, f"known {noun}{_suggestion(model, unknown[0])}", ".".join(unknown[0]))
    if first["type"] == "extra_forbidden":
        return InputError(where, f"known {noun}", ", ".join(".".join(p) + _suggestion(model, p) for p in unknown))
    inner, expected, found = fault(first)
    if first["type"] in ("tuple_type", "list_type", "missing", "too_long") and _is_pair(model, loc):
        expected, found, loc = "a pair (smallest, largest)", shortened(first["input"]), loc[: _depth(model, loc)]
    of_file = [inner] if inner and _begins_with_file(first, inner) else []
    name = ".".join([*group, *loc, *([inner] if inner and not of_file else [])])
    found += "".join(f"; {line}" for line in _more_unknown(faults[1:], group))
    return InputError(": ".join([str(where), *([name] if name else []), *of_file]), expected, found)


def _begins_with_file(first: Any, inner: str) -> bool:
    """Return whether a fault begins with the file that it is in, which is no part of a dotted name."""
    return isinstance(first.get("ctx", {}).get("error"), InputError) or "/" in inner or ": " in inner


def _place(one: Any) -> list[str]:
    """Return the names of the fields that lead to a fault, without those that pydantic gives to parts of types."""
    return [str(part) for part in one["loc"] if not str(part).startswith(("function-", "literal["))]


def _more_unknown(faults: Sequence[Any], group: Sequence[str]) -> Iterator[str]:
    """Yield a line for each further fault that is an unknown name, so that all of them are said at once."""
    for one in faults:
        inner, expected, found = fault(one)
        place = ".".join([*group, *_place(one), *([inner] if inner else [])])
        if one["type"] == "extra_forbidden":
            yield f"{place}: expected a known name, found it"
        elif one["type"] == "literal_error" or expected.startswith("one of "):
            yield f"{place}: expected {expected}, found {found}"


def fault(first: Any) -> tuple[str, str, str]:
    """Return the part of a field that a fault of pydantic is about ('' for all of it), what was expected, and found.

    Parameters
    ----------
    first : dict
        One item of `pydantic.ValidationError.errors`.
    """
    kind, context = first["type"], first.get("ctx", {})
    ours = str(context.get("error", ""))
    if ours:  # "expected ..., found ...", raised by one of our validators; one over several fields names a field first
        field, _, text = ours.rpartition("expected ")
        expected, _, found = text.rpartition(", found ")
        given = first["input"]
        texts = isinstance(given, list | tuple) and given and all(isinstance(one, str) for one in given)
        if texts and not all(one in found for one in given):
            found += f" ({' '.join(given)})"  # with the units that the user wrote
        return field.removesuffix(": "), expected, found
    found = shortened(first["input"])
    if kind == "literal_error":
        found += suggest(str(first["input"]), _QUOTED.findall(context.get("expected", "")))
    if kind == "float_parsing":
        found += decimal_hint(first["input"])
    if kind == "missing":
        return "", "a value", "none"
    if kind in ("too_short", "too_long"):
        limit = context["min_length"] if kind == "too_short" else context["max_length"]
        expected = f"at {'least' if kind == 'too_short' else 'most'} {limit} item{'' if limit == 1 else 's'}"
        return "", expected, str(context["actual_length"])
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return "", f"one of {context.get('expected_tags', 'the known kinds')}", found
    if kind in ("model_type", "model_attributes_type") and not isinstance(first["input"], BaseModel):
        return "", "named values (a dict)", found
    if kind in ("model_type", "model_attributes_type", "dataclass_type", "is_instance_of"):
        name = context.get("class_name") or context.get("class") or "dict"
        return "", f"{'an' if name[0] in 'AEIOU' else 'a'} {name}", found
    return "", _PLAIN.get(kind) or first["msg"].removeprefix("Input should be "), found


def suggest(name: str, known: Sequence[str]) -> str:
    """Return a hint at the known name that is spelt most like an unknown one, such as `` (is it views?)``, or ''."""
    close = get_close_matches(name, known, n=1)
    return f" (is it {close[0]}?)" if close else ""


def shortened(value: object) -> str:
    """Return the representation of a value, cut where it is long or deep."""
    short = Repr()
    short.maxstring = short.maxother = short.maxlong = 80
    return short.repr(value)


def setting_names(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    """Yield the dotted names of all settings of a model."""
    for name, field in model.model_fields.items():
        inner = _model_of(field)
        if inner is None:
            yield prefix + name
        else:
            yield from setting_names(inner, f"{prefix}{name}.")


def suggest_setting(name: str, known: Sequence[str]) -> str:
    """Return a hint at the dotted name that is spelt most like an unknown one; its last part may be enough."""
    by_last = {full.rpartition(".")[2]: full for full in reversed(known)}
    last = get_close_matches(name.rpartition(".")[2], by_last, n=1, cutoff=0.75)
    return f" (is it {by_last[last[0]]}?)" if last else ""


def _suggestion(model: type[BaseModel] | None, place: Sequence[str]) -> str:
    if model is None:
        return ""
    inner: type[BaseModel] | None = model
    for part in place[:-1]:
        inner = None if inner is None or part not in inner.model_fields else _model_of(inner.model_fields[part])
    known, last = list(setting_names(model)), place[-1]
    close = [] if inner is None else get_close_matches(last, inner.model_fields, n=1)
    if close and not any(name.rpartition(".")[2] == last for name in known):
        return f" (is it {'.'.join([*place[:-1], close[0]])}?)"
    return suggest_setting(".".join(place), known)


def _is_pair(model: type[BaseModel] | None, place: Sequence[str]) -> bool:
    """Tell whether a setting is a range from a smallest to a largest number."""
    if model is None or not place:
        return False
    field = model.model_fields.get(place[0])
    if field is None:
        return False
    inner = _model_of(field)
    if inner:
        return _is_pair(inner, place[1:])
    return any(Ordered in kind for kind in (field.metadata, *_metadata_of_choices(field)))


def _metadata_of_choices(field: Any) -> list[tuple[Any, ...]]:
    """Return the metadata of each type of a union, such as ``Annotated[..., Ordered] | None``."""
    return [getattr(kind, "__metadata__", ()) for kind in get_args(field.annotation)]


def _depth(model: type[BaseModel] | None, place: Sequence[str]) -> int:
    """Return how many names of a place lead to its setting; the others count inside its value."""
    inner = _model_of(model.model_fields[place[0]]) if model and place and place[0] in model.model_fields else None
    return 1 + (_depth(inner, place[1:]) if inner else 0)


def _model_of(field: Any) -> type[BaseModel] | None:
    kind = field.annotation
    return kind if isinstance(kind, type) and issubclass(kind, BaseModel) else None
