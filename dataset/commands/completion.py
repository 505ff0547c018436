"""``glassware completion``: a script by which a shell completes commands, options and their values."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from typing import Annotated, Literal

import tyro
from pydantic import Field

from ...core.exit_codes import run_command
from ...core.model import Model
from ..settings.config import parse_request
from ..settings.options import SHORT, Option, sections, switch_names
from .build_request import BuildDataset
from .convert import Convert
from .develop import Develop
from .export import Export
from .inspect import Inspect
from .merge import Merge
from .report import Report
from .scene_request import RenderScene
from .show import Show
from .verify import Verify

_DESCRIPTION = """Print a script that completes commands, options and values. Install it by one line:

  glassware completion bash >> ~/.bash_completion
  glassware completion zsh >> ~/.zshrc
  glassware completion fish > ~/.config/fish/conf.d/glassware.fish

It works in the next shell that is opened."""

Shell = Literal["bash", "zsh", "fish"]
#: Options of every command.
_COMMON = ("--help", "--help-all", "--version")


class Completion(Model):
    """The request: for which shell."""

    shell: Annotated[Shell, tyro.conf.Positional] = Field(default="bash", description="bash (the default), zsh or fish")


#: Commands of `glassware` with the types of their requests.
_REQUESTS: dict[str, type[Model]] = {
    "render": RenderScene,
    "build": BuildDataset,
    "show": Show,
    "report": Report,
    "verify": Verify,
    "export": Export,
    "inspect": Inspect,
    "convert": Convert,
    "develop": Develop,
    "merge": Merge,
    "completion": Completion,
}
#: Commands with names of their own.
_PROGRAMS = {"render-scene": "render", "build-dataset": "build"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _completion(given))


def _completion(arguments: Sequence[str]) -> None:
    request = parse_request(Completion, arguments, "glassware completion", _DESCRIPTION)
    sys.stdout.write(script(request.shell))


def script(shell: Shell) -> str:
    """Return the script for a shell."""
    if shell == "fish":
        return "\n".join(_fish()) + "\n"
    lines = list(_bash())
    if shell == "zsh":
        lines = ["autoload -Uz compinit bashcompinit && compinit && bashcompinit", *lines]
    return "\n".join(lines) + "\n"


def _options(request: type[Model]) -> list[Option]:
    return [option for section in sections(request) for option in section.options]


def _names(request: type[Model]) -> list[str]:
    """Return all words that begin an option of a command."""
    names = [name for option in _options(request) if not option.positional for name in _spellings(option)]
    return sorted({*names, *_COMMON})


def _spellings(option: Option) -> Iterator[str]:
    yield from switch_names(option) if option.switch else (option.name,)
    yield from (short for short, full in SHORT.items() if full == option.name)


def _commands() -> dict[str, list[str]]:
    """Return the option words of each command of `glassware`; those of other packages have only the common ones."""
    others: dict[str, list[str]] = {entry.name: [*_COMMON] for entry in entry_points(group="glassware.commands")}
    for entry in entry_points(group="glassware.commands"):
        try:
            request = getattr(import_module(entry.module), "REQUEST", None)
        except ImportError:  # its libraries are an extra
            request = None
        if request is not None:
            others[entry.name] = _names(request)
    return {name: _names(request) for name, request in _REQUESTS.items()} | others


def _bash() -> Iterator[str]:
    """Yield a script for bash: words of options, values where they are few, file names elsewhere."""
    commands = _commands()
    yield "# Completion of glassware; made by: glassware completion"
    yield "_glassware_options() {"
    yield '  case "$1" in'
    for name, words in commands.items():
        yield f'    {name}) echo "{" ".join(words)}" ;;'
    yield "  esac"
    yield "}"
    yield "_glassware() {"
    yield '  local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" command="${COMP_WORDS[1]}"'
    yield '  case "${COMP_WORDS[0]##*/}" in'
    for program, name in _PROGRAMS.items():
        yield f"    {program}) command={name} ;;"
    yield '    *) if [ "$COMP_CWORD" = 1 ]; then'
    first = " ".join([*commands, "--help", "--version"])
    yield f'         COMPREPLY=($(compgen -W "{first}" -- "$word")); return; fi ;;'
    yield "  esac"
    yield '  case "$before" in'
    for name, choices in _values().items():
        yield f'    {name}) COMPREPLY=($(compgen -W "{" ".join(choices)}" -- "$word")); return ;;'
    yield "  esac"
    yield '  if [ "$command" = completion ] && [ "${word#-}" = "$word" ]; then'
    yield '    COMPREPLY=($(compgen -W "bash zsh fish" -- "$word"))'
    yield '  elif [ "${word#-}" != "$word" ]; then'
    yield '    COMPREPLY=($(compgen -W "$(_glassware_options "$command")" -- "$word"))'
    yield "  else"
    yield '    COMPREPLY=($(compgen -f -- "$word"))'
    yield "  fi"
    yield "}"
    yield f"complete -o filenames -F _glassware glassware {' '.join(_PROGRAMS)}"


def _values() -> dict[str, tuple[str, ...]]:
    """Return the values of options that have few, without those of more than one word."""
    every = [option for request in (RenderScene, BuildDataset) for option in _options(request)]
    return {option.name: option.choices for option in every if option.choices and " " not in "".join(option.choices)}


def _fish() -> Iterator[str]:
    """Yield a script for fish, which shows the descriptions as well."""
    commands = _commands()
    yield "# Completion of glassware; made by: glassware completion"
    yield f"complete -c glassware -n __fish_use_subcommand -f -a '{' '.join(commands)}'"
    yield "complete -c glassware -n '__fish_seen_subcommand_from completion' -f -a 'bash zsh fish'"
    for program, name in _PROGRAMS.items():
        yield from (f"complete -c {program} {_fish_option(option)}" for option in _options(_REQUESTS[name]))
    for name, request in _REQUESTS.items():
        seen = f"-n '__fish_seen_subcommand_from {name}'"
        options = (option for option in _options(request) if not option.positional)
        yield from (f"complete -c glassware {seen} {_fish_option(option)}" for option in options)
    for program in ("glassware", *_PROGRAMS):
        yield from (f"complete -c {program} -l {word.removeprefix('--')}" for word in _COMMON)


def _fish_option(option: Option) -> str:
    name = next((short for short, full in SHORT.items() if full == option.name), option.name)
    text = option.description.split(";")[0].replace("\\", "").replace("'", "\\'")
    values = "" if option.switch else " -r"
    if option.choices and " " not in "".join(option.choices):
        values = f" -x -a '{' '.join(option.choices)}'"
    return f"-l {name.removeprefix('--')}{values} -d '{text}'"


if __name__ == "__main__":
    sys.exit(main())
