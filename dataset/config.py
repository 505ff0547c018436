"""Settings from a preset, a YAML file and the command line, one on top of the other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import redirect_stderr
from difflib import get_close_matches
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any, TypeVar

import tyro
import yaml
from pydantic import BaseModel, ValidationError

from ..procedural.errors import InputError

T = TypeVar("T", bound=BaseModel)

#: Short names on the command line.
_SHORT = {
    "--views": "--cameras.views",
    "--width": "--cameras.width",
    "--height": "--cameras.height",
    "--spp": "--picture.spp",
    "--noise": "--picture.noise",
    "--hdri-dir": "--environment.hdri-dir",
}

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
    except OSError as error:
        raise InputError(path, "a readable YAML file", error.strerror) from error
    except UnicodeDecodeError as error:
        raise InputError(path, "a YAML file in UTF-8", "other bytes") from error
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
        if first["type"] == "extra_forbidden":
            raise InputError(where, f"known settings{_nearest(model, first['loc'])}", field) from error
        raise InputError(f"{where}: {field}", _expected(first["msg"]), repr(first["input"])) from error


def _nearest(model: type[BaseModel], place: Sequence[int | str]) -> str:
    """Return a hint at the known setting that is spelt most like an unknown one, or nothing."""
    for part in place[:-1]:
        inner = model.model_fields[str(part)].annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return ""
        model = inner
    near = get_close_matches(str(place[-1]), model.model_fields, n=1)
    return f" (is it {'.'.join([*map(str, place[:-1]), near[0]])}?)" if near else ""


def layered(model: type[T], arguments: Sequence[str]) -> T:
    """Return the settings under the command line: the preset that it names, and on top of it the YAML file.

    The model has the fields ``preset`` and ``config``, which are taken from the command line first.
    """
    name, path = _value(arguments, "--preset"), _value(arguments, "--config")
    settings, where = preset(name or model.model_fields["preset"].default), "preset"
    if path is not None:
        settings, where = merged(settings, yaml_settings(Path(path))), path
    return validated(model, settings, where)


def _value(arguments: Sequence[str], option: str) -> str | None:
    """Return the value of an option in either spelling, ``--option value`` or ``--option=value``; the last one wins."""
    found = None
    for position, argument in enumerate(arguments):
        if argument == option and position + 1 < len(arguments):
            found = arguments[position + 1]
        elif argument.startswith(option + "="):
            found = argument.removeprefix(option + "=")
    return found


def parsed(model: type[T], default: T, arguments: Sequence[str], prog: str, description: str) -> T:
    """Return `default` with the command line's overrides; InputError in one line for a wrong one."""
    told = StringIO()
    arguments = [_full(argument) for argument in arguments]
    try:
        with redirect_stderr(told):
            return tyro.cli(model, default=default, args=arguments, prog=prog, description=description)
    except SystemExit as stop:
        if stop.code in (0, None):  # --help was asked for and printed
            raise
        raise InputError(prog, *_complaint(told.getvalue())) from stop


def _full(argument: str) -> str:
    name, equals, value = argument.partition("=")
    return _SHORT.get(name, name) + equals + value


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
    found = re.sub(r"^Unrecognized options: ", "", re.sub(r" Perhaps you meant:.*", "", text))
    return "known settings with valid values (see --help)", found + hint


def _full_name(group: str, field: str) -> str:
    return field if group in ("", "None") else f"{group}.{field}"


def _expected(rule: str) -> str:
    return re.sub(r"^(Input should be|Value error,( expected)?) ?", "", rule)
