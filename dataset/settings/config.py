"""Settings from a preset, a YAML file and the command line, one on top of the other."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any, TypeVar, get_args

import tyro
import yaml
from pydantic import BaseModel, ValidationError

from ...core.errors import InputError
from ...core.setting_errors import parser_error, setting_error, shortened
from .settings_file import yaml_settings

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
        raise InputError("--preset", f"one of {', '.join(preset_names())}", shortened(name))
    return yaml.safe_load(_PRESETS.joinpath(f"{name}.yaml").read_text("utf-8")) or {}


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
        raise setting_error(where, error, model) from error


def layered(model: type[T], arguments: Sequence[str]) -> T:
    """Return the settings under the command line: the preset that it names, and on top of it the YAML file.

    The model has the field ``config``, and ``preset`` where it has presets; both are taken from the command line first.
    """
    _check_not_empty(arguments)
    name, path = _value(arguments, "--preset"), _value(arguments, "--config")
    settings, where = {}, "preset"
    if "preset" in model.model_fields:
        settings = preset(name or model.model_fields["preset"].default)
    if path is not None:
        asked = yaml_settings(path)
        for name in ("preset", "config"):
            if name in asked:
                raise InputError(f"{path}: {name}", f"--{name} on the command line alone", shortened(asked[name]))
        check_switches(model, asked, path)
        settings, where = merged(settings, asked), path
    return validated(model, settings, where)


def check_switches(model: type[BaseModel], settings: dict[str, Any], where: str, group: str = "") -> None:
    """Raise InputError where a setting that is no switch is yes or no: as a number that would be 1 or 0."""
    for name, value in settings.items():
        field = model.model_fields.get(name)
        if field is None:  # told when the settings are validated
            continue
        kind, place = field.annotation, f"{group}{name}"
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            if isinstance(value, dict):
                check_switches(kind, value, where, f"{place}.")
        elif not _is_switch(kind) and any(
            isinstance(one, bool) for one in (value if isinstance(value, list) else [value])
        ):
            raise InputError(f"{where}: {place}", "a number or a text, which no switch is", shortened(value))


def _is_switch(kind: Any) -> bool:
    return kind is bool or any(_is_switch(part) for part in get_args(kind))


def _value(arguments: Sequence[str], option: str) -> str | None:
    """Return the value of an option in either spelling, ``--option value`` or ``--option=value``; the last one wins."""
    found = None
    for position, argument in enumerate(arguments):
        if argument == option and position + 1 < len(arguments):
            found = arguments[position + 1]
        elif argument.startswith(option + "="):
            found = argument.removeprefix(option + "=")
    return found


def _check_not_empty(arguments: Sequence[str]) -> None:
    """Raise InputError where an option's value is empty: a path or a name that is left out, as by an unset variable."""
    for position, argument in enumerate(arguments):
        option, equals, value = argument.partition("=")
        if not argument or (option.startswith("--") and equals and not value):
            name = option or (arguments[position - 1] if position else "the request")
            raise InputError(name, "a value", "''")


def parsed(model: type[T], default: T | None, arguments: Sequence[str], prog: str, description: str) -> T:
    """Return `default` (None: the model's own) with the command line's overrides; InputError in one line otherwise."""
    _check_not_empty(arguments)
    told = StringIO()
    arguments = [_full(argument) for argument in arguments]
    try:
        with redirect_stderr(told):
            known: dict[str, Any] = {} if default is None else {"default": default}
            return tyro.cli(model, **known, args=arguments, prog=prog, description=description)
    except SystemExit as stop:
        if stop.code in (0, None):  # --help was asked for and printed
            raise
        wrong = _validation_behind(stop)
        if wrong is not None:
            raise setting_error(prog, wrong, model) from stop
        raise parser_error(prog, _unframed(told.getvalue()), list(_options(model))) from stop


def _validation_behind(error: BaseException | None) -> ValidationError | None:
    """Return the validation that made the parser stop, if one did."""
    while error is not None and not isinstance(error, ValidationError):
        error = error.__cause__ or error.__context__
    return error


def _options(model: type[BaseModel], prefix: str = "--") -> Iterator[str]:
    """Go through the options of all settings."""
    for name, field in model.model_fields.items():
        kind, option = field.annotation, prefix + name.replace("_", "-")
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _options(kind, f"{option}.")
        else:
            yield option


def _full(argument: str) -> str:
    name, equals, value = argument.partition("=")
    return _SHORT.get(name, name) + equals + value


def _unframed(box: str) -> str:
    """Return the first paragraph of the parser's message on one line; its frame is Unicode, ASCII or left out."""
    text = " ".join(line.strip("│|╭╮╰╯+ ") for line in box.splitlines())
    # The first is the frame's title.
    paragraphs = [part.strip() for part in re.split(r"[─-]{5,}", text) if part.strip()]
    return paragraphs[1] if len(paragraphs) > 1 else text
