"""Paths in a YAML file of settings, which begin at the file's folder."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel

from .options import flat_groups


def beside_file(model: type[BaseModel], settings: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return settings whose relative paths begin at a YAML file's folder, where there is something at that place.

    All other paths stay: they begin at the current folder, as on the command line, and so do those of outputs.

    Parameters
    ----------
    model : type
        The settings.
    settings : dict
        As the file has them, nested.
    folder : Path
        Where the file is.
    """
    fields = dict(model.model_fields)
    for group in flat_groups(model).values():
        fields |= group.model_fields
    result = dict(settings)
    for name, value in settings.items():
        if name not in fields:
            continue  # the validation names it
        kind = fields[name].annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            result[name] = beside_file(kind, value, folder) if isinstance(value, dict) else value
        elif _is_path(kind):
            values = [_beside(one, folder) for one in value] if isinstance(value, list) else _beside(value, folder)
            result[name] = values
    return result


def _is_path(kind: Any) -> bool:
    return kind is Path or any(_is_path(part) for part in get_args(kind))


def _beside(value: Any, folder: Path) -> Any:
    if not isinstance(value, str) or not value or "\0" in value:
        return value
    text = os.path.expandvars(value)
    if text.startswith("~") or Path(text).is_absolute():
        return value
    place = folder / text
    try:
        return str(place) if place.exists() else value
    except OSError:  # a name that is too long: the validation says so
        return value
