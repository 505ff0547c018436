"""JSON files: written with sorted keys, read strictly, validated as models."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from .errors import InputError, cause_of
from .model import Model
from .setting_errors import setting_error

M = TypeVar("M", bound=Model)


def json_text(data: object) -> str:
    """Return JSON with sorted keys and floats that read back exactly; NaN and infinity are refused."""
    return json.dumps(data, sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_json(path: Path) -> Any:
    """Read a JSON file; InputError where it is missing or damaged, repeats a key, or has infinite numbers."""
    try:
        return json.loads(
            path.read_text(encoding="utf-8"),
            object_pairs_hook=_once,
            parse_constant=_no_constant,
            parse_float=_finite,
        )
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error
    except ValueError as error:
        raise InputError(path, "a JSON file", f"{error}") from error
    except RecursionError as error:
        raise InputError(path, "a JSON file", "lists or objects nested too deep") from error


def check_schema(path: Path, data: object, schema: str) -> None:
    """Refuse data whose ``schema_version`` is not the one that this version reads."""
    found = data.get("schema_version", "none") if isinstance(data, dict) else f"a {type(data).__name__}"
    if found != schema:
        raise InputError(f"{path}: schema_version", schema, found)


def parsed(model: type[M], data: object, path: Path, context: dict[str, Any] | None = None) -> M:
    """Validate JSON data as a model; the first error becomes an InputError with file and field."""
    try:
        return model.model_validate(data, strict=False, context=context)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        cause = first.get("ctx", {}).get("error")
        if isinstance(cause, InputError):
            raise cause from None
        raise setting_error(path, error, model, noun="fields") from None


def read_record(model: type[M], path: Path, schema: str) -> M:
    """Read a JSON file of a known ``schema_version`` as a model; InputError with file and field where it is no such."""
    data = read_json(path)
    check_schema(path, data, schema)
    return parsed(model, data, path)


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


def _finite(text: str) -> float:
    # 1e999 is JSON, and Python reads it as infinity.
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is too large for a number")
    return number


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    # JSON readers differ in which of two values they keep.
    data = dict(pairs)
    if len(data) != len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"the key {twice!r} twice in one object")
    return data
