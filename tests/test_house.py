"""The rules of the house, read from the sources themselves. Every test names all its offenders at once."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]

#: Each folder and the folders it may import, as the flow of data runs.
MAY_IMPORT = {
    "core": set(),
    "procedural": {"core"},
    "render": {"core", "procedural"},
    "annotate": {"core", "procedural", "render"},
    "dataset": {"core", "procedural", "render", "annotate"},
    "learn": {"core", "procedural", "annotate", "dataset"},
}

#: The package over all folders: a user's way in. It is there once its folder is.
FRONT = "glassware"

#: The folder of links that gives each folder its name under `glassware`.
LINKS = REPOSITORY / ".ci" / "packages"

#: Packages that only `render` imports.
RENDERER = {"mitsuba", "drjit"}

#: The longest file and function that one reads in one go [lines].
FILE_LINES, FUNCTION_LINES = 400, 70

#: Modules whose readers run code from a file, or whose state is global.
FORBIDDEN_MODULES = {"pickle", "cPickle", "dill", "marshal", "shelve", "joblib", "random"}

#: Calls that run code from a file or hand text to a shell, by their dotted name.
FORBIDDEN_CALLS = {
    "yaml.load",
    "yaml.unsafe_load",
    "yaml.full_load",
    "os.system",
    "os.popen",
    "eval",
    "exec",
}

#: Private words that must not come back as a part of a name, and the field's term for each. Add a row to ban a word.
BANNED_WORDS = {
    "answers": "messages, results",
    "asked": "requested",
    "campaign": "scheduler",
    "chance": "probability",
    "coin": "u_lobe",
    "complaint": "setting error",
    "complaints": "setting errors",
    "dismissed": "stop",
    "doomed": "to_delete",
    "durable": "atomic_io",
    "enlarged": "upsample",
    "farewell": "shutdown timeout",
    "figures": "summarise, metrics",
    "gamble": "russian_roulette, u_rr",
    "hire": "start",
    "hope": "expected_radiance",
    "lucky": "u_lobe",
    "makers": "executor",
    "odds": "guided_reflect_probability",
    "patience": "timeout",
    "quartered": "at_quarter",
    "recycle": "max_tasks_per_child",
    "sanity": "validate",
    "share": "fraction, probability, weight",
    "shares": "fractions, probabilities, weights",
    "staff": "workers",
    "starts": "sample points, path origins",
    "steered": "guided",
    "taken": "lock",
    "tally": "film",
    "told": "reported, known",
    "unshadowed": "visible",
    "whoever": "the caller",
    "worth": "weight, score",
}

#: Names of settings in the files of data sets (`config` of dataset.json, and YAML files of settings), by the module
#: that has them. They are a part of the file format, which does not change with our words.
SETTINGS_IN_FILES = {
    "procedural/props/draw.py": {"file_share"},
    "procedural/surroundings/settings.py": {"hdri_share", "room_share", "shipped_share"},
    "procedural/surroundings/table.py": {"round_share"},
}

#: What reading and drawing scenes need: a program that only does that must start no renderer.
RENDERER_FREE = ["glassware.core.json_file", "glassware.procedural.scene.draw"]
READING = ["glassware.annotate.labels", "glassware.dataset.reader"]

#: Run in a fresh interpreter: imports the modules named in argv and reports what else that did.
IMPORT_PROBE = """
import importlib, json, os, sys
import cv2  # OpenCV itself puts its own folder into LD_LIBRARY_PATH
started = []
STARTS = ("subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.exec", "os.system")
sys.addaudithook(lambda event, args: started.append(f"{event} {args[:1]}") if event in STARTS else None)
before = dict(os.environ)
for name in sys.argv[1:]:
    importlib.import_module(name)
environment = sorted(key for key in before.keys() | os.environ if before.get(key) != os.environ.get(key))
renderer = sorted({"mitsuba", "drjit"} & set(sys.modules))
print(json.dumps({"processes": started, "environment": environment, "renderer": renderer}))
"""

#: A row of the table of rooms: | `room` | what it holds | what it may import |.
TABLE_ROW = re.compile(r"^\| `([a-z_/]+)` \| (.+?) \| (.*?) ?\|$", re.MULTILINE)

#: A package exists once it holds Python: an empty folder is only a name on the map.
PACKAGES = [name for name in MAY_IMPORT if any((REPOSITORY / name).rglob("*.py"))]
FRONTS = [FRONT] if (REPOSITORY / FRONT / "__init__.py").is_file() else []
FILES = sorted(path for name in [*PACKAGES, *FRONTS] for path in (REPOSITORY / name).rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    """Return a file's syntax tree; each file is parsed once in a session."""
    return ast.parse(path.read_text("utf-8"), filename=str(path))


def short(path: Path) -> str:
    return str(path.relative_to(REPOSITORY))


def package_of(path: Path) -> tuple[str, ...]:
    """Return the dotted package of a file inside the repository, such as ("glassware", "procedural", "optics")."""
    folders = path.relative_to(REPOSITORY).parts[:-1]
    return folders if folders == (FRONT,) else (FRONT, *folders)


def module_of(path: Path) -> str:
    """Return the dotted name of a file; a package has the name of its folder."""
    return ".".join(package_of(path) + (() if path.stem == "__init__" else (path.stem,)))


MODULES = {module_of(path): path for path in FILES}


def imported_modules(code: ast.Module, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the absolute dotted name of all that a module imports: at its top, in a function, for type checks only."""
    for node in ast.walk(code):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            # One dot is the package itself; each further dot is one folder up.
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = (*base, *(node.module or "").split(".")) if node.module else base
            yield from (".".join((*module, alias.name)) for alias in node.names)


@cache
def imports(path: Path) -> tuple[str, ...]:
    return tuple(imported_modules(tree(path), package_of(path)))


def files_imported(path: Path) -> set[Path]:
    """Return the files of ours that a file imports: a name that is no module is looked for in what defines it."""
    found = {MODULES.get(name) or MODULES.get(name.rpartition(".")[0]) for name in imports(path)}
    return {file for file in found if file is not None} - {path}


def room_of(path: Path) -> str:
    """Return the room of a file: a subfolder, or a file beside subfolders; a folder without them is one room."""
    folder, *rest = path.relative_to(REPOSITORY).parts
    if len(rest) > 1:
        return f"{folder}/{rest[0]}"
    alone = folder == FRONT or not any((REPOSITORY / folder).glob("*/__init__.py"))
    return folder if alone else f"{folder}/{rest[0].removesuffix('.py')}"


def rooms_of_the_table(text: str) -> dict[str, set[str]]:
    """Return each room of a document's table, in order, with what it may import: rooms, or folders with all rooms."""
    return {room: set(re.findall(r"`([a-z_/]+)`", last)) for room, _, last in TABLE_ROW.findall(text)}


def rooms_on_disk() -> dict[str, set[str]]:
    """Return each room with the rooms that it imports. An `__init__` that imports nothing of ours is no room."""
    rooms: dict[str, set[str]] = {}
    for path in FILES:
        others = {room_of(file) for file in files_imported(path)} - {room_of(path)}
        if others or path.name != "__init__.py" or not room_of(path).endswith("__init__"):
            rooms.setdefault(room_of(path), set()).update(others)
    return rooms


def table_faults(table: dict[str, set[str]], disk: dict[str, set[str]]) -> list[str]:
    """Return where a table of rooms and the imports between them differ, and where its order has a circle."""
    faults = [f"the table has no row for {room}" for room in disk if room not in table]
    faults += [f"the table has {room}, which is not on disk" for room in table if room not in disk]
    before: set[str] = set()
    for room, allowed in table.items():
        # The name of a folder stands for all its rooms, so it is no help inside the folder itself.
        known = before - {room.split("/")[0]}
        faults += [f"{room} may import {other}, which no row above it is" for other in sorted(allowed - known)]
        before |= {room, room.split("/")[0]}
        missing = {other for other in disk.get(room, set()) if not {other, other.split("/")[0]} & allowed}
        faults += [f"{room} imports {other}, which its row does not allow" for other in sorted(missing)]
    return faults


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return the sets of nodes that reach each other (strongly connected components of two nodes or more)."""
    reach = {node: reachable(graph, node) for node in graph}
    found = {tuple(sorted(m for m in reach[n] if n in reach.get(m, set()))) for n in graph if n in reach[n]}
    return sorted(list(circle) for circle in found)


def reachable(graph: dict[str, set[str]], start: str) -> set[str]:
    found: set[str] = set()
    waiting = list(graph[start])
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting.extend(graph.get(node, set()))
    return found


def words_of(name: str) -> list[str]:
    """Return the words of an identifier: `_MOST_TOLD`, `EmissionMap` and `u_lobe` have two each."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def defined_names(code: ast.Module) -> set[str]:
    """Return the names that a module defines: functions, classes, arguments, variables, fields, renamed imports."""
    names: set[str] = set()
    for node in ast.walk(code):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            names.add(node.id if isinstance(node, ast.Name) else node.attr)
        elif isinstance(node, ast.alias) and node.asname:
            names.add(node.asname)
    return names


def banned_in(names: Iterable[str]) -> list[str]:
    return [
        f"{name} ({BANNED_WORDS[word]})" for name in sorted(names) for word in words_of(name) if word in BANNED_WORDS
    ]


def dotted(node: ast.expr) -> str:
    """Return a call's dotted name, with NumPy's usual abbreviation written out."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    if isinstance(node, ast.Name):
        parts.append({"np": "numpy"}.get(node.id, node.id))
    return ".".join(reversed(parts))


def forbidden_in(code: ast.Module) -> list[str]:
    """Return what a module calls and should not."""
    found = []
    for call in (node for node in ast.walk(code) if isinstance(node, ast.Call)):
        name = dotted(call.func)
        options = {keyword.arg: keyword.value for keyword in call.keywords}
        if (
            name in FORBIDDEN_CALLS
            or options.keys() & {"shell", "allow_pickle"}
            or name.startswith("numpy.random.default_rng")
        ):
            found.append(name)
        if name == "torch.load" and ast.unparse(options.get("weights_only", ast.Constant(False))) != "True":
            found.append(name)
    return found


def import_effects(modules: list[str], folder: Path | None = None) -> dict[str, list[str]]:
    """Import modules in a fresh interpreter; return the processes, changed variables and renderers that came of it.

    `folder` holds modules that are not installed. The choice of LLVM that this process has made is not handed on.
    """
    environment = {key: value for key, value in os.environ.items() if key != "DRJIT_LIBLLVM_PATH"}
    environment |= {"PYTHONPATH": str(folder)} if folder else {}
    command = [sys.executable, "-P", "-c", IMPORT_PROBE, *modules]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120)
    return json.loads(run.stdout)


def test_imports_between_folders_run_one_way() -> None:
    wrong = []
    for path in FILES:
        folder = path.relative_to(REPOSITORY).parts[0]
        allowed = {folder} | (MAY_IMPORT[folder] if folder in MAY_IMPORT else set(MAY_IMPORT))
        for module in imports(path):
            root, *rest = module.split(".")
            if (root == FRONT and rest[:1] and rest[0] not in allowed) or root in MAY_IMPORT:
                wrong.append(f"{short(path)}: {module}")
    assert not wrong


def test_the_table_of_rooms_in_contributing_is_what_the_code_imports() -> None:
    table = rooms_of_the_table((REPOSITORY / "CONTRIBUTING.md").read_text("utf-8"))
    disk = rooms_on_disk()
    assert not table_faults(table, disk), "what each room imports today: " + json.dumps(
        {room: sorted(others) for room, others in sorted(disk.items())}
    )


def test_no_files_import_each_other_in_a_circle() -> None:
    assert not circles({short(path): {short(file) for file in files_imported(path)} for path in FILES})


def test_no_library_code_imports_a_command() -> None:
    wrong = [
        f"{short(path)}: {short(file)}"
        for path in FILES
        for file in sorted(files_imported(path))
        if "commands" in file.parts and "commands" not in path.parts
    ]
    assert not wrong


def test_packages_import_each_other_relatively() -> None:
    wrong = [
        f"{short(path)}: {node.module}"
        for path in FILES
        for node in ast.walk(tree(path))
        if isinstance(node, ast.ImportFrom) and not node.level and (node.module or "").split(".")[0] == FRONT
    ]
    assert not wrong


def test_only_render_imports_the_renderer() -> None:
    users = {short(path) for path in FILES if {module.split(".")[0] for module in imports(path)} & RENDERER}
    assert users
    assert not {path for path in users if not path.startswith("render/")}


def test_files_and_functions_can_be_read_in_one_go() -> None:
    long = {short(path): n for path in FILES if (n := len(path.read_text("utf-8").splitlines())) > FILE_LINES}
    for path in FILES:
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                lines = (node.end_lineno or 0) - node.lineno + 1
                long |= {f"{short(path)}: {node.name}": lines} if lines > FUNCTION_LINES else {}
    assert not long


def test_nothing_runs_code_from_a_file_or_keeps_global_random_state() -> None:
    wrong = []
    for path in FILES:
        modules = {module.split(".")[0] for module in imports(path)} & FORBIDDEN_MODULES
        wrong += [f"{short(path)}: {name}" for name in [*modules, *forbidden_in(tree(path))]]
    assert not wrong


def test_public_functions_and_classes_say_what_they_do() -> None:
    silent = [short(path) for path in FILES if not ast.get_docstring(tree(path))]
    silent += [
        f"{short(path)}: {node.name}"
        for path in FILES
        for node in tree(path).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        if not node.name.startswith("_") and not ast.get_docstring(node)
    ]
    assert not silent


def test_no_name_has_a_private_word() -> None:
    wrong = {}
    for path in FILES:
        names = defined_names(tree(path)) | set(path.relative_to(REPOSITORY).with_suffix("").parts)
        if found := banned_in(names - SETTINGS_IN_FILES.get(short(path), set())):
            wrong[short(path)] = found
    assert not wrong, json.dumps(wrong, indent=1)


def test_every_name_of_a_setting_that_is_excused_exists() -> None:
    for file, names in SETTINGS_IN_FILES.items():
        assert names <= defined_names(tree(REPOSITORY / file)), file


def test_the_packages_in_pyproject_are_the_folders_on_disk() -> None:
    settings = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    assert set(settings["packages"]) == {".".join(package_of(path)) for path in FILES}
    assert settings["package-dir"] == {"": LINKS.relative_to(REPOSITORY).as_posix()}
    assert settings["packages"] == sorted(settings["packages"])
    assert not [short(path) for path in FILES if not path.with_name("__init__.py").is_file()]
    # The links by which setuptools and pyright find the packages.
    links = {link.name: link.resolve() for link in (LINKS / FRONT).iterdir()}
    fronts = {path.name: path for path in FILES if path.parent == REPOSITORY / FRONT}
    fronts["py.typed"] = REPOSITORY / FRONT / "py.typed"
    assert links == {name: REPOSITORY / name for name in PACKAGES} | fronts


def test_a_package_refuses_to_be_imported_under_its_bare_name() -> None:
    for name in PACKAGES:
        source = (REPOSITORY / name / "__init__.py").read_text("utf-8")
        with pytest.raises(ImportError, match=f"this package is glassware.{name}"):
            exec(compile(source, name, "exec"), {"__name__": name})


def test_the_tests_are_no_package() -> None:
    assert not list((REPOSITORY / "tests").rglob("__init__.py"))


def test_describing_and_drawing_scenes_imports_no_renderer_and_changes_nothing() -> None:
    assert import_effects(RENDERER_FREE) == {"processes": [], "environment": [], "renderer": []}


def test_reading_imports_no_renderer_and_changes_nothing() -> None:
    assert import_effects([*READING, *FRONTS]) == {"processes": [], "environment": [], "renderer": []}


def test_the_rules_find_what_breaks_them(tmp_path: Path) -> None:
    sources = ["import yaml\nyaml.load(f)", "subprocess.run(c, shell=True)", "torch.load(p)"]
    assert all(forbidden_in(ast.parse(source)) for source in [*sources, "torch.load(p, weights_only=False)"])
    code = ast.parse("from ..optics import medium\nfrom . import a\nfrom ...render.x import y\nimport mitsuba as mi")
    found = list(imported_modules(code, ("glassware", "procedural", "vessels")))
    assert found == [
        "glassware.procedural.optics.medium",
        "glassware.procedural.vessels.a",
        "glassware.render.x.y",
        "mitsuba",
    ]
    names = defined_names(ast.parse("class LuckyCoin:\n  _worth: int = 0\ndef f(odds, shared): self.tally = 1"))
    assert len(banned_in(names)) == 5
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [["b", "c"]]
    table = rooms_of_the_table(
        "| `a` | floor | |\n| `b/x` | one | `a`, `b/y` |\n| `b/y` | two | |\n| `c` | gone | `a` |\n"
    )
    disk = {"a": set(), "b/x": set(), "b/y": {"a"}, "d": set()}
    assert len(table_faults(table, disk)) == 4
    effects = "import os, subprocess, mitsuba\nos.environ['A_KEY'] = '1'\nsubprocess.run(['true'], check=True)\n"
    (tmp_path / "has_effects.py").write_text(effects, "utf-8")
    found = import_effects(["has_effects"], tmp_path)
    assert found["renderer"] == ["drjit", "mitsuba"]
    assert "A_KEY" in found["environment"]
    assert found["processes"]
