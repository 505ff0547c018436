"""``glassware COMMAND ...``: all commands under one name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint, entry_points

from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from . import assets, build_dataset, merge, render_scene, verify

#: What each command does, and its entry point, by name.
_COMMANDS: dict[str, tuple[str, Callable[[Sequence[str]], int]]] = {
    "assets": ("what is in a folder of meshes, with a contact sheet, and what cannot be used", assets.main),
    "build": ("many scenes, by worker processes or a cluster (also: build-dataset)", build_dataset.main),
    "merge": ("merge the shards of a build into one data set", merge.main),
    "render": ("one labelled scene from a seed (also: render-scene)", render_scene.main),
    "verify": ("check a data set: files, labels, or by rendering views again", verify.main),
}
#: Group of entry points for the commands of other packages, which are imported when they are used.
_GROUP = "glassware.commands"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that the first argument names, and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given and given[0] in _COMMANDS:
        return _COMMANDS[given[0]][1](given[1:])
    for entry in entry_points(group=_GROUP, name=given[0]) if given else ():
        return _run(entry, given[1:])
    if given in (["--help"], ["-h"]):
        _help()
        return 0
    return run_command(lambda: _refuse(given))


def _help() -> None:
    console = Console()
    console.print("usage: glassware COMMAND [OPTIONS]", highlight=False)
    for name, (purpose, _) in _COMMANDS.items():
        console.print(f"  {name:10} {purpose}", highlight=False)
    for entry in sorted(entry_points(group=_GROUP), key=lambda entry: entry.name):
        console.print(f"  {entry.name:10} from {entry.module}; see glassware {entry.name} --help", highlight=False)


def _run(entry: EntryPoint, arguments: Sequence[str]) -> int:
    """Run a command of another package; InputError in one line where its libraries are not installed."""
    try:
        command = entry.load()
    except ModuleNotFoundError as error:
        missing = InputError(f"glassware {entry.name}", "its extra, as in pip install 'glassware[learn]'", error)

        def refuse() -> None:
            raise missing

        return run_command(refuse)
    return command(arguments)


def _refuse(given: Sequence[str]) -> None:
    names = [*_COMMANDS, *sorted(entry.name for entry in entry_points(group=_GROUP))]
    raise InputError("glassware", f"a command, one of {', '.join(names)}", given[0] if given else "none")


if __name__ == "__main__":
    sys.exit(main())
