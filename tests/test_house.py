"""The rules of the house, read from the sources themselves."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
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

#: The same inside `render`, of its rooms and of the files beside them: each may import only what stands before it.
MAY_IMPORT_IN_RENDER = {
    "backend": set(),
    "__init__": {"backend"},
    "frame": set(),
    "scene": {"frame"},
    "interfaces": set(),
    "labels": {"frame", "scene", "interfaces"},
    "pictures": {"frame", "scene", "interfaces"},
    "cache": {"frame", "scene", "interfaces", "pictures"},
    "derivatives": {"frame", "scene", "interfaces", "pictures"},
    "view": {"frame", "scene", "labels", "pictures"},
}

#: Packages that only one folder imports.
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

#: A package exists once it holds Python: an empty folder is only a name on the map.
PACKAGES = [name for name in MAY_IMPORT if any((REPOSITORY / name).rglob("*.py"))]
FILES = sorted(path for name in PACKAGES for path in (REPOSITORY / name).rglob("*.py"))
RENDER_FILES = [path for path in FILES if path.is_relative_to(REPOSITORY / "render")]

each_file = pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))
each_file_of_render = pytest.mark.parametrize("path", RENDER_FILES, ids=lambda path: str(path.relative_to(REPOSITORY)))


def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), filename=str(path))


def functions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree(path)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def package_of(path: Path) -> tuple[str, ...]:
    """Return the dotted package of a file inside the repository, such as ("glassware", "procedural", "optics")."""
    return ("glassware", *path.relative_to(REPOSITORY).parts[:-1])


def imported_modules(code: ast.Module, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the absolute dotted name of all that a module imports, at its top or inside a function."""
    for node in ast.walk(code):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            # One dot is the package itself; each further dot is one folder up.
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = (*base, *(node.module or "").split(".")) if node.module else base
            yield from (".".join((*module, alias.name)) for alias in node.names)


def dotted(node: ast.expr) -> str:
    """Return a call's dotted name, with NumPy's usual abbreviation written out."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    if isinstance(node, ast.Name):
        parts.append({"np": "numpy"}.get(node.id, node.id))
    return ".".join(reversed(parts))


def calls(code: ast.Module) -> Iterator[ast.Call]:
    return (node for node in ast.walk(code) if isinstance(node, ast.Call))


def forbidden_in(code: ast.Module) -> list[str]:
    """Return what a module calls and should not."""
    found = []
    for call in calls(code):
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


@each_file
def test_imports_run_one_way(path: Path) -> None:
    folder = path.relative_to(REPOSITORY).parts[0]
    for module in imported_modules(tree(path), package_of(path)):
        root, *rest = module.split(".")
        if root == "glassware":
            assert rest[0] in MAY_IMPORT[folder] | {folder}, f"{folder} imports {module}"
        assert root not in MAY_IMPORT, f"{module} is not glassware.{module}"


@each_file_of_render
def test_imports_between_the_rooms_of_render_run_one_way(path: Path) -> None:
    room = path.relative_to(REPOSITORY / "render").parts[0].removesuffix(".py")
    for module in imported_modules(tree(path), package_of(path)):
        if module.startswith("glassware.render."):
            assert module.split(".")[2] in MAY_IMPORT_IN_RENDER[room] | {room}, f"{room} imports {module}"


def test_the_order_of_the_rooms_has_no_circle() -> None:
    before: set[str] = set()
    for room, others in MAY_IMPORT_IN_RENDER.items():
        assert others <= before, f"{room} may import what does not stand before it"
        before.add(room)


@each_file
def test_packages_import_each_other_relatively(path: Path) -> None:
    absolute = [
        node.module
        for node in ast.walk(tree(path))
        if isinstance(node, ast.ImportFrom) and not node.level and (node.module or "").split(".")[0] == "glassware"
    ]
    assert not absolute


@each_file
def test_only_render_imports_the_renderer(path: Path) -> None:
    used = {module.split(".")[0] for module in imported_modules(tree(path), package_of(path))} & RENDERER
    assert not used or path.is_relative_to(REPOSITORY / "render")


@each_file
def test_files_and_functions_can_be_read_in_one_go(path: Path) -> None:
    assert len(path.read_text("utf-8").splitlines()) <= FILE_LINES
    long = {f.name: n for f in functions(path) if (n := (f.end_lineno or 0) - f.lineno + 1) > FUNCTION_LINES}
    assert not long


@each_file
def test_nothing_runs_code_from_a_file_or_keeps_global_random_state(path: Path) -> None:
    code = tree(path)
    assert not {module.split(".")[0] for module in imported_modules(code, package_of(path))} & FORBIDDEN_MODULES
    assert not forbidden_in(code)


@each_file
def test_public_functions_and_classes_say_what_they_do(path: Path) -> None:
    code = tree(path)
    public = [
        node for node in code.body if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]
    assert ast.get_docstring(code)
    assert not [node.name for node in public if not ast.get_docstring(node)]


def test_the_packages_in_pyproject_are_the_folders_on_disk() -> None:
    settings = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    on_disk = {".".join(package_of(path)) for path in FILES}
    assert set(settings["packages"]) == on_disk
    assert settings["package-dir"] == {f"glassware.{name}": name for name in PACKAGES}
    assert settings["packages"] == sorted(settings["packages"])


def test_every_folder_of_a_package_has_an_init() -> None:
    assert not [path for path in FILES if not path.with_name("__init__.py").is_file()]


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_refuses_to_be_imported_under_its_bare_name(name: str) -> None:
    source = (REPOSITORY / name / "__init__.py").read_text("utf-8")
    with pytest.raises(ImportError, match=f"this package is glassware.{name}"):
        exec(compile(source, name, "exec"), {"__name__": name})


def test_the_tests_are_no_package() -> None:
    assert not list((REPOSITORY / "tests").rglob("__init__.py"))


@pytest.mark.parametrize(
    "source",
    [
        "import yaml\nyaml.load(f)",
        "subprocess.run(c, shell=True)",
        "torch.load(p)",
        "torch.load(p, weights_only=False)",
    ],
)
def test_the_check_for_forbidden_calls_finds_them(source: str) -> None:
    assert forbidden_in(ast.parse(source))


def test_the_check_for_imports_follows_dots() -> None:
    code = ast.parse("from ..optics import medium\nfrom . import a\nfrom ...render.x import y\nimport mitsuba as mi")
    found = list(imported_modules(code, ("glassware", "procedural", "vessels")))
    assert found == [
        "glassware.procedural.optics.medium",
        "glassware.procedural.vessels.a",
        "glassware.render.x.y",
        "mitsuba",
    ]
