"""Settings from a preset, a YAML file and the command line, each on top of the one before."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar, get_args

import tyro
import yaml
from pydantic import BaseModel, ValidationError

# Private, so pyproject.toml has the exact version of tyro: its public errors are a drawn box of prose.
from tyro import _errors as tyro_errors

from ...core.errors import InputError
from ...core.setting_errors import setting_error, shortened, suggest, suggest_setting
from ...core.units import decimal_hint
from ...core.yaml_file import yaml_settings
from .camera_layer import with_cameras
from .file_paths import beside_file
from .help_page import asks_for_help, print_help
from .option_units import without_units
from .options import FLAT as FLAT
from .options import LISTS, SHORT, flat_groups, option_names, sections, switch_names

T = TypeVar("T", bound=BaseModel)

#: Presets are YAML files in the package.
_PRESETS = files("glassware.dataset").joinpath("presets")


def preset_names() -> list[str]:
    """Return the names of the presets, sorted."""
    return sorted(Path(item.name).stem for item in _PRESETS.iterdir() if item.name.endswith(".yaml"))


def preset(name: str, where: str = "--preset") -> dict[str, Any]:
    """Return a preset's settings; InputError where no preset has this name."""
    if name not in preset_names():
        known = preset_names()
        raise InputError(where, f"one of {', '.join(known)}", shortened(name) + suggest(str(name), known))
    return yaml.safe_load(_PRESETS.joinpath(f"{name}.yaml").read_text("utf-8")) or {}


def merged(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return two nested settings as one; the values of `above` take precedence."""
    result = dict(below)
    for name, value in above.items():
        deeper = isinstance(value, dict) and isinstance(result.get(name), dict)
        result[name] = merged(result[name], value) if deeper else value
    return result


def validated(model: type[T], settings: dict[str, Any], where: object) -> T:
    """Return settings as a model; InputError that names the first invalid field and what is allowed."""
    data, own = dict(settings), set(model.model_fields) - set(flat_groups(model))
    for name, kind in flat_groups(model).items():
        data = {key: value for key, value in settings.items() if key in own}
        data[name] = validated(kind, {key: value for key, value in settings.items() if key not in own}, where)
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise setting_error(where, error, model) from error


def parse_request(model: type[T], arguments: Sequence[str], prog: str, description: str) -> T:
    """Return a command's request from its preset, its YAML file and its options.

    Parameters
    ----------
    model : type
        The request. Where it has the fields ``preset`` and ``config``, these layers lie below the options.
    arguments : sequence of str
        The command line without the program.
    prog, description : str
        For the help text.

    Raises
    ------
    InputError
        For the first invalid setting or option, in one line.
    """
    _check_not_empty(arguments)
    default: dict[str, Any] = {"default": _layers(model, arguments)} if "config" in model.model_fields else {}
    if asks_for_help(arguments):
        print_help(model, default.get("default"), arguments, prog, description)
        raise SystemExit(0)

    def refuse(event: tyro_errors.ParseErrorEvent) -> None:
        raise _argument_error(prog, event, model, words)

    words = _with_full_names(arguments)  # as they were typed, for error lines
    full = without_units(prog, model, words, FLAT)
    try:
        with tyro_errors.on_parse_error(refuse):
            return tyro.cli(model, **default, args=full, prog=prog, description=description)
    except ValidationError as error:  # of a `FLAT` group: the parser passes these on
        raise setting_error(prog, error) from error


def typed_names(model: type[BaseModel], arguments: Sequence[str]) -> tuple[str, ...]:
    """Return the settings of a model that a command line has options of, by their dotted names, each once."""
    options = [option for section in sections(model) for option in section.options if not option.positional]
    names = {typed: one.name for one in options for typed in (switch_names(one) if one.switch else (one.name,))}
    words = [word.partition("=")[0].replace("_", "-") for word in _with_full_names(arguments)]
    return tuple(dict.fromkeys(names[word].removeprefix("--").replace("-", "_") for word in words if word in names))


def _layers(model: type[T], arguments: Sequence[str]) -> T:
    """Return the settings below the options: the preset, and on top of it the YAML file."""
    name, path = _value(arguments, "--preset"), _value(arguments, "--config")
    settings, where = {}, "preset"
    loaded: dict[str, Any] = {}
    if "preset" in model.model_fields:
        settings = preset(name or model.model_fields["preset"].default)
    if path is not None:
        loaded = yaml_settings(path)
        for name in ("preset", "config"):
            if name in loaded:
                raise InputError(f"{path}: {name}", f"--{name} on the command line alone", shortened(loaded[name]))
        check_booleans(model, loaded, path)
        loaded = beside_file(model, loaded, Path(path).parent)
        where = path
    cameras = with_cameras(settings, loaded, _with_full_names(arguments)) if _draws_scenes(model) else {}
    return validated(model, merged(settings, loaded) | cameras, where)


def _draws_scenes(model: type[BaseModel]) -> bool:
    """Return whether a request has settings of scenes, and so of cameras; that of training has none."""
    return any("cameras" in one.model_fields for one in (model, *flat_groups(model).values()))


def check_booleans(model: type[BaseModel], settings: dict[str, Any], where: str, prefix: str = "") -> None:
    """Raise InputError where a number or text is yes or no.

    Pydantic takes a boolean for the number 1 or 0. Its strict mode does not, but refuses 1e-4 as well, which YAML 1.1
    reads as a text.
    """
    kinds = {name: field.annotation for name, field in model.model_fields.items()}
    for group in flat_groups(model).values():
        kinds |= {name: field.annotation for name, field in group.model_fields.items()}
    for name, value in settings.items():
        kind, place = kinds.get(name), f"{prefix}{name}"
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            if isinstance(value, dict):
                check_booleans(kind, value, where, f"{place}.")
        elif name in kinds and not _is_boolean(kind):
            values = value if isinstance(value, list) else [value]
            if any(isinstance(one, bool) for one in values):
                raise InputError(f"{where}: {place}", "a number or a text, not yes or no", shortened(value))


def _is_boolean(kind: Any) -> bool:
    return kind is bool or any(_is_boolean(part) for part in get_args(kind))


def _value(arguments: Sequence[str], option: str) -> str | None:
    """Return the value of an option, ``--option value`` or ``--option=value``; the last one counts."""
    found = None
    for position, argument in enumerate(arguments):
        if argument == option and position + 1 < len(arguments):
            found = arguments[position + 1]
        elif argument.startswith(option + "="):
            found = argument.removeprefix(option + "=")
    return found


def _check_not_empty(arguments: Sequence[str]) -> None:
    """Raise InputError where a value is empty, as an unset shell variable leaves it."""
    for position, argument in enumerate(arguments):
        option, equals, value = argument.partition("=")
        if not argument or (option.startswith("--") and equals and not value):
            name = option or (arguments[position - 1] if position else "the request")
            raise InputError(name, "a value", "''")


def _with_full_names(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with the full names of short options."""
    parts = [argument.partition("=") for argument in arguments]
    full = [SHORT.get(name, name) + equals + value for name, equals, value in parts]
    return [word for before, one in zip(["", *full], full, strict=False) for word in _listed(before, one)]


def _listed(before: str, argument: str) -> list[str]:
    """Return the values of an option that takes a list with commas, as arguments of their own."""
    name, equals, value = argument.partition("=")
    if equals and name in LISTS:
        return [name, *value.split(",")]
    return argument.split(",") if before in LISTS and not argument.startswith("--") else [argument]


def _argument_error(
    prog: str, event: tyro_errors.ParseErrorEvent, model: type[BaseModel], arguments: Sequence[str]
) -> InputError:
    """Return an error of the parser as one line."""
    match event:
        case tyro_errors.InstantiationFailure(argument=None):
            return _validation_error(prog, event.message, model)
        case tyro_errors.InstantiationFailure(argument=argument):
            return InputError(
                _place(prog, argument), _form(argument), _with_point(argument, _given(argument, arguments))
            )
        case tyro_errors.InvalidChoice(argument=argument, value=value, choices=choices):
            return InputError(
                _place(prog, argument), f"one of {', '.join(choices)}", repr(value) + suggest(value, choices)
            )
        case tyro_errors.BadValue(argument=argument, offending_value=value):
            return InputError(_place(prog, argument), _form(argument), _with_point(argument, value or "fewer values"))
        case tyro_errors.MissingArgs(missing_arguments=missing):
            return InputError(prog, ", ".join(one.arg.display_name() for one in missing), "nothing")
        case tyro_errors.UnrecognizedArgs(tokens=tokens):
            return _unknown_options(prog, tokens, model)
    return InputError(prog, "options as --help lists them", event)


def _unknown_options(prog: str, tokens: Sequence[str], model: type[BaseModel]) -> InputError:
    """Return the error for words that no option takes: all unknown options, each with the nearest known one."""
    expected, found = "known options with valid values (see --help)", " ".join(tokens)
    options = [word.partition("=")[0] for word in tokens if word.startswith("--")]
    if len(options) < 2:
        return InputError(prog, expected + _option_hint(tokens[0].partition("=")[0], model), found)
    return InputError(prog, expected, ", ".join(option + _option_hint(option, model) for option in options))


def _option_hint(option: str, model: type[BaseModel]) -> str:
    """Return a hint at the option that is spelt most like an unknown one; short options come first."""
    if not option.startswith("--"):
        return ""
    name = option.removeprefix("--").replace("_", "-")
    known = option_names(model)
    short = [alias.removeprefix("--") for alias, full in SHORT.items() if full in known]
    dashed = {full.removeprefix("--").replace(".", "-"): full.removeprefix("--") for full in [*known, *SHORT]}
    whole = get_close_matches(name.replace(".", "-"), dashed, n=1, cutoff=0.85)
    hint = f" (is it {dashed[whole[0]]}?)" if whole else suggest(name, short)
    hint = hint or suggest_setting(name, [full.removeprefix("--") for full in known])
    return hint.replace("(is it ", "(is it --")


def _with_point(argument: Any, text: str) -> str:
    """Return values with a hint where an option of numbers has one with a comma."""
    hints = [decimal_hint(word.strip("'")) for word in text.split()] if "FLOAT" in _form(argument) else []
    return text + next((hint for hint in hints if hint), "")


def _given(argument: Any, arguments: Sequence[str]) -> str:
    """Return the values that an option was given, as text."""
    option = argument.display_name()
    if (value := _value(arguments, option)) is None:
        return "others"
    if option not in arguments:
        return repr(value)
    rest = arguments[len(arguments) - list(reversed(arguments)).index(option) :]
    count = next((place for place, word in enumerate(rest) if word.startswith("--")), len(rest))
    return shortened(" ".join(rest[:count]))


def _validation_error(prog: str, message: str, model: type[BaseModel]) -> InputError:
    """Return the validation error that the parser handles now; it knows the fields that hold the validated model."""
    error, group = sys.exception(), ""
    while error is not None and not isinstance(error, ValidationError):
        group = str(getattr(error, "arg", ""))
        error = error.__cause__ or error.__context__
    if error is None:
        return InputError(prog, "valid settings", message)
    flat = flat_groups(model)
    return setting_error(prog, error, group=[part for part in group.split(".") if part and part not in flat])


def _form(argument: Any) -> str:
    """Return the form of an argument's value as the help text has it, such as INT; without the word for none."""
    form = (argument.lowered.metavar or "no value").removeprefix("{None}|").strip("{}")
    return f"two numbers ({form})" if form in ("INT INT", "FLOAT FLOAT") else form


def _place(prog: str, argument: Any) -> str:
    """Return the command and the dotted name of an argument, as YAML files have it."""
    return f"{prog}: {argument.display_name().removeprefix('--').replace('-', '_')}"
