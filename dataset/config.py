"""Settings from a preset, a YAML file and the command line, one on top of the other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import redirect_stderr
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any, TypeVar

import tyro
import yaml
from pydantic import BaseModel, ValidationError

from ..procedural.errors import InputError

T = TypeVar("T", bound=BaseModel)

#: Presets lie in the package as YAML files.
_PRESETS = files("glassware.dataset").joinpath("presets")


def preset_names() -> list[str]:
    """Return the names of the presets, sorted."""
    return sorted(Path(item.name).stem for item in _PRESETS.iterdir() if item.name.endswith(".yaml"))


def preset(name: str) -> dict[str, Any]:
    """Return a preset's settings; InputError where there is none of that name."""
    if name not in preset_names():
        raise InputError("--preset", f"one of {', '.join(preset_names())}", name)
    return yaml.safe_load(_PRESETS.joinpath(f"{name}.yaml").read_text("utf-8")) or {}


def yaml_settings(path: Path) -> dict[str, Any]:
    """Return the settings of a YAML file; InputError where it is not one."""
    try:
        settings = yaml.safe_load(path.read_text("utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, "a readable YAML file", error) from error
    except yaml.YAMLError as error:
        raise InputError(path, "valid YAML", " ".join(str(error).split())) from error
    if not isinstance(settings, dict | None):
        raise InputError(path, "a mapping of settings", type(settings).__name__)
    return settings or {}


def merged(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return both settings as one, `above` winning field by field."""
    result = dict(below)
    for name, value in above.items():
        deeper = isinstance(value, dict) and isinstance(result.get(name), dict)
        result[name] = merged(result[name], value) if deeper else value
    return result


def validated(model: type[T], settings: dict[str, Any], where: str) -> T:
    """Return the settings as a model; InputError that names the first wrong field and what is allowed."""
    try:
        return model.model_validate(settings)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{where}: {field}", _expected(first["msg"]), repr(first["input"])) from error


def parsed(model: type[T], default: T, arguments: Sequence[str], prog: str, description: str) -> T:
    """Return `default` with the command line's overrides; InputError in one line for a wrong one."""
    told = StringIO()
    try:
        with redirect_stderr(told):
            return tyro.cli(model, default=default, args=list(arguments), prog=prog, description=description)
    except SystemExit as stop:
        if stop.code in (0, None):  # --help was asked for and printed
            raise
        raise InputError(prog, *_complaint(told.getvalue())) from stop


def _complaint(box: str) -> tuple[str, str]:
    """Return what was expected and what was found from the parser's framed message."""
    lines = [line.strip("│╭╮╰╯─ \n") for line in box.splitlines()]
    rules = [i for i, line in enumerate(box.splitlines()) if "─────" in line]
    text = " ".join(line for line in lines[rules[0] + 1 : rules[1]] if line) if len(rules) > 1 else " ".join(lines)
    wrong = re.search(
        r"Error parsing (\S+): \d+ validation errors? for \w+ (\S+) (.*?) \[type=.*?input_value=(.*?), input_type", text
    )
    if wrong:
        group, field, rule, value = wrong.groups()
        return f"{_full_name(group, field)} {_expected(rule)}", value
    known = re.search(r"Perhaps you meant: (\S+?),? ", text)
    hint = f" (is it {known.group(1)}?)" if known else ""
    return "known settings with valid values (see --help)", re.sub(r" Perhaps you meant:.*", "", text) + hint


def _full_name(group: str, field: str) -> str:
    return field if group in ("", "None") else f"{group}.{field}"


def _expected(rule: str) -> str:
    return re.sub(r"^(Input should be|Value error,( expected)?) ?", "", rule)
