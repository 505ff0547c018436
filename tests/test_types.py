"""A user's type checker reads our types, after `pip install .` and after `pip install -e .`."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]

#: What a user writes; pyright says which type it sees.
SCRIPT = """
from pathlib import Path
from glassware.dataset.reader import Dataset

reveal_type(Dataset.open(Path("out")).views())
"""
SEEN = "StoredView"
#: Longest that building or checking may take [s]; each takes some seconds on an idle core.
LIMIT = 300

BUILD = "import sys; from setuptools import build_meta; print(getattr(build_meta, sys.argv[1])(sys.argv[2]))"


def run(*command: object, folder: Path) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=LIMIT, check=False)
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what a build reads, so that nothing is built in the checkout itself."""
    folder = tmp_path_factory.mktemp("checkout")
    settings = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    for name in [*settings["package-dir"].values(), ".ci"]:
        shutil.copytree(REPOSITORY / name, folder / name, symlinks=True, dirs_exist_ok=True)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(REPOSITORY / name, folder / name)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "hook",
    [
        "build_wheel",
        pytest.param(
            "build_editable",
            marks=pytest.mark.xfail(
                reason="setuptools writes an import hook, which type checkers do not run, until there is a package"
                " `glassware` and one folder over all: then it writes the folder's path",
                strict=True,
            ),
        ),
    ],
)
def test_a_users_script_is_checked_against_our_types(hook: str, checkout: Path, tmp_path: Path) -> None:
    run(sys.executable, "-c", BUILD, hook, tmp_path, folder=checkout)
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "venv", with_pip=False, symlinks=True)
    (site,) = (tmp_path / "venv").glob("lib/python*/site-packages")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    (tmp_path / "user").mkdir()
    (tmp_path / "user" / "script.py").write_text(SCRIPT, "utf-8")
    pyright = Path(sys.executable).with_name("pyright")
    said = run(pyright, "--pythonpath", tmp_path / "venv/bin/python", "script.py", folder=tmp_path / "user")
    assert SEEN in said, said
    assert "0 errors" in said, said
