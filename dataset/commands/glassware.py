"""``glassware COMMAND ...``: all commands under one name. Each is imported when it is used."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.setting_errors import suggest

#: What each command does, and its module here, by name.
_COMMANDS = {
    "render": ("one labelled scene from a seed (also: render-scene)", "render_scene"),
    "build": ("many scenes, by worker processes or a cluster (also: build-dataset)", "build_dataset"),
    "show": ("the contact sheet of a data set: opens it, or prints where it is", "show"),
    "view": ("a data set in a browser or in Rerun: pictures, every label, 3D", "view"),
    "report": ("a page about a data set: pictures, what was drawn, time and size, licences", "report"),
    "verify": ("check a data set: files, labels, or by rendering views again", "verify"),
    "export": ("a data set in another project's layout: coco, bop, nerfstudio, ply, syn-todd, webdataset", "export"),
    "assets": ("what is in a folder of meshes, with a contact sheet, and what cannot be used", "assets"),
    "develop": ("the pictures of a data set by another camera: a phone, a webcam, or your own", "develop"),
    "inspect": ("what a folder with another project's data set holds, and what is wrong in it", "inspect"),
    "convert": ("another project's data set (KeyPose, ClearGrasp, BOP, ...) in our format", "convert"),
    "merge": ("merge the shards of a build into one data set", "merge"),
    "completion": ("a script that completes commands and options: bash, zsh or fish", "completion"),
}
#: Group of entry points for the commands of other packages, which are imported when they are used.
_GROUP = "glassware.commands"
#: What those of `learn` do; their modules load torch.
_PURPOSES = {
    "train": "train a network that finds glass in pictures (needs the extra `learn`)",
    "evaluate": "measure a network against the labels of a data set (needs the extra `learn`)",
    "predict": "objects and depth in pictures of your own (needs the extra `learn`)",
    "export-weights": "the weights of a training run alone, to use or to pass on (needs the extra `learn`)",
    "export-onnx": "a network for other runtimes (needs the extras `learn` and `onnx`)",
    "tables": "the paper's tables: networks trained, compared and written up (needs the extra `learn`)",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that the first argument names, and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given and given[0] in _COMMANDS:
        return import_module(f".{_COMMANDS[given[0]][1]}", __package__).main(given[1:])
    for entry in entry_points(group=_GROUP, name=given[0]) if given else ():
        return _run(entry, given[1:])
    if given in (["--help"], ["-h"], ["--help-all"]):
        _help()
        return 0
    return run_command(lambda: _refuse(given))


def _help() -> None:
    console = Console()

    def say(line: str) -> None:
        console.print(line, highlight=False, markup=False, soft_wrap=True)

    say("Pictures of glass with labels: glassware COMMAND [OPTIONS]\n")
    for name, purpose in _purposes().items():
        say(f"  {name:14} {purpose}")
    say("\nglassware COMMAND --help lists the options of a command, glassware --version the version.")
    say("A first scene: glassware render --seed 7 --out out")


def _purposes() -> dict[str, str]:
    """Return what each command does, those of other packages last."""
    others = {entry.name: _PURPOSES.get(entry.name, f"from {entry.module}") for entry in entry_points(group=_GROUP)}
    ordered = sorted(others, key=lambda name: (list(_PURPOSES).index(name) if name in _PURPOSES else 9, name))
    return {name: purpose for name, (purpose, _) in _COMMANDS.items()} | {name: others[name] for name in ordered}


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
    names = list(_purposes())
    hint = suggest(given[0], names) if given else ""
    raise InputError("glassware", f"a command, one of {', '.join(names)}{hint}", given[0] if given else "none")


if __name__ == "__main__":
    sys.exit(main())
