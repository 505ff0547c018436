"""The help of a command: a short form of the options that people use (``--help``), and all of them (``--help-all``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pydantic import BaseModel
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from ...core.units import Dimension
from .common_options import COMMON
from .options import SHORT, Option, Section, sections, switch_names

#: Options that ask for help.
HELP, HELP_ALL = ("--help", "-h"), "--help-all"
#: How quantities are typed, by their dimension.
_QUANTITIES: dict[Dimension, str] = {
    "length": "a number with its unit, such as 0.4m, 12cm or 55mm, or of metres",
    "angle": "a number with its unit, such as 30deg or 0.5rad, or of radians",
}
#: Widest page [characters]: longer lines are hard to read.
WIDEST = 100
#: Width of the column of names; a longer name has its description below it [characters].
NAMES = 30


def asks_for_help(arguments: Sequence[str]) -> bool:
    """Return whether a command line asks for help."""
    return any(argument in (*HELP, HELP_ALL) for argument in arguments)


def print_help(
    model: type[BaseModel], default: BaseModel | None, arguments: Sequence[str], prog: str, description: str
) -> None:
    """Print the help that a command line asks for.

    Parameters
    ----------
    model : type
        The request of the command.
    default : BaseModel, optional
        A request with the default values, those of the preset and the YAML file that the command line names.
    arguments : sequence of str
        The command line without the program.
    prog, description : str
        The command, and what it does.
    """
    every = sections(model, default)
    short = HELP_ALL not in arguments and prog in COMMON
    shown = common_sections(every, prog) if short else every
    console = Console()
    console = Console(width=min(console.width, WIDEST), soft_wrap=False)
    console.print(Group(*_page(shown, every, prog, description, short)), markup=False, highlight=False)


def common_sections(every: Sequence[Section], prog: str) -> list[Section]:
    """Return the sections of the short form; KeyError where an option does not exist."""
    by_name = {option.name: option for section in every for option in section.options}
    return [
        Section(title, tuple(replace(by_name[SHORT.get(name, name)], name=name) for name in names))
        for title, names in COMMON[prog]
    ]


def _page(
    shown: Sequence[Section], every: Sequence[Section], prog: str, description: str, short: bool
) -> list[RenderableType]:
    lines: list[RenderableType] = [Text(_flowing(description))]
    for section in shown:
        lines += [Text(), Text(_title(section, shown), style="bold"), _table(section.options, short)]
    count = sum(len(section.options) for section in every)
    rest = [] if not short else [("--help-all", f"all {count} options")]
    rest += [("--help", "this page" if not short else "these options"), ("--version", "the version")]
    lines += [Text(), Text("help", style="bold"), _rows(rest)]
    forms = " ".join(option.form for section in shown for option in section.options)
    notes = [f"{kind.upper()}: {text}." for kind, text in _QUANTITIES.items() if kind.upper() in forms]
    return [*lines, *([Text(), Text(" ".join(notes))] if notes else [])]


def _flowing(text: str) -> str:
    """Return a text whose paragraphs are one line each; indented lines are examples and stay."""
    lines: list[str] = []
    for line in text.strip().splitlines():
        goes_on = lines and lines[-1] and line and not line.startswith(" ") and not lines[-1].startswith(" ")
        lines[-1:] = [f"{lines[-1]} {line}"] if goes_on else [*lines[-1:], line]
    return "\n".join(lines)


def _title(section: Section, shown: Sequence[Section]) -> str:
    return section.title or ("options" if len(shown) == 1 else "request")


def _table(options: Sequence[Option], short: bool) -> RenderableType:
    return _rows([(_names(option, short), _described(option)) for option in options])


def _rows(rows: Sequence[tuple[str, str]]) -> RenderableType:
    """Return names beside descriptions; a long name stands above its description."""
    parts: list[RenderableType] = []
    for name, text in rows:
        grid = Table.grid(padding=(0, 2, 0, 0))
        grid.add_column(width=NAMES)
        grid.add_column()
        if len(name) > NAMES:
            parts.append(Padding(Text(name, style="cyan"), (0, 0, 0, 2)))
            name = ""
        grid.add_row(Text(name, style="cyan"), Text(text))
        parts.append(Padding(grid, (0, 0, 0, 2)))
    return Group(*parts)


def _names(option: Option, short: bool) -> str:
    if option.switch:
        return option.name if short else ", ".join(switch_names(option))
    if option.positional:
        return option.name
    alias = next((name for name, full in SHORT.items() if full == option.name and not short), None)
    return " ".join(part for part in (f"{alias}, {option.name}" if alias else option.name, option.form) if part)


def _described(option: Option) -> str:
    return f"{option.description} (default: {option.default})" if option.default else option.description
