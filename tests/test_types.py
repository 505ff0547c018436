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
import glassware as gw

reveal_type(gw.Dataset.open("out").views())
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
    # `glassware.render` lies in render/, and `glassware` itself in glassware/.
    for name in {package.split(".")[:2][-1] for package in settings["packages"]} | {".ci"}:
        shutil.copytree(REPOSITORY / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("*.egg-info"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(REPOSITORY / name, folder / name)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("hook", ["build_wheel", "build_editable"])
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
