"""Validation of a changed copy: `model_copy(update=...)` checks nothing, so every field is checked again."""

from __future__ import annotations

import numpy as np
from pydantic import ValidationError

from ...core.arguments import described
from ...core.errors import InputError
from ...core.model import Model
from ...core.setting_errors import fault, suggest

#: Fields whose own fields have the names of settings, such as ``picture.spp``.
_GROUPS = ("picture", "environment")
#: What is expected of a value of another type, by pydantic's types of errors.
_KINDS = {
    "model_type": "a description of type {}",
    "model_attributes_type": "a description of the right type",
    "tuple_type": "a tuple",
}


def check_fields(model: Model, where: str = "", seen: set[int] | None = None) -> None:
    """Refuse a description in which a field is unknown, or has another type or value than it may have.

    Each model is validated by itself, with the models in it as they are. Meshes are not looked into. What two objects
    share, such as a glass and its interfaces, is checked once.

    Parameters
    ----------
    model : Model
        A description, such as a scene.
    where : str
        What it is, for the error line.
    seen : set of int, optional
        Identities of the models that were checked before.

    Raises
    ------
    InputError
        Naming the field, what was expected and what was found.
    """
    seen = set() if seen is None else seen
    if id(model) in seen:
        return
    seen.add(id(model))
    given, known = dict(model.__dict__), type(model).model_fields
    for name in given.keys() - known.keys():
        raise InputError(_at(where, name), f"a known field of {type(model).__name__}{suggest(name, list(known))}", name)
    for name, value in given.items():
        _check_raw(_at(where, name), value)
        # Before the model itself, whose error line would not name the field inside.
        for number, item in enumerate(value if isinstance(value, tuple) else (value,)):
            if isinstance(item, Model):
                check_fields(item, _name(where, name, item, number if isinstance(value, tuple) else None), seen)
    try:
        made = type(model).model_validate(given, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        inner, expected, found = fault(first)
        if first["type"] in _KINDS:
            kind = first.get("ctx", {}).get("class_name", "description")
            expected, found = _KINDS[first["type"]].format(kind), described(first["input"])
        name = str(first["loc"][0]) if first["loc"] else inner
        raise InputError(_at(_at(where, name), inner if first["loc"] else ""), expected, found) from None
    for name, value in given.items():
        if isinstance(getattr(made, name), np.ndarray) and not isinstance(value, np.ndarray):
            raise InputError(_at(where, name), "a NumPy array", described(value))


def _check_raw(where: str, value: object) -> None:
    """Refuse data that only a file may hold in place of a model."""
    for item in value if isinstance(value, tuple) else (value,):
        if isinstance(item, dict):
            raise InputError(where, "a description, not a dict of its fields", described(item))


def _name(where: str, field: str, item: Model, number: int | None) -> str:
    """Return what a model inside another one is called: objects by their names, interfaces by their parts."""
    if number is None:
        return _at(where, field)
    own = getattr(item, "name", None) if not where else getattr(item, "part", None)
    single = field.removesuffix("s")
    return _at(where, str(own) if own is not None else f"{single} {number}")


def _at(where: str, part: str) -> str:
    """Return the place of a part, as error lines name it."""
    kind, _, rest = part.partition(" ")
    if rest and where.rpartition(", ")[2] == kind:  # "liquid, medium" and "medium water"
        return f"{where} {rest}"
    separator = "." if where.split(".")[0] in _GROUPS else ", "
    return separator.join(text for text in (where, part) if text)
