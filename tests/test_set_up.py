"""The set-up brings exact versions, says what it brings, and goes on where it was stopped."""

from __future__ import annotations

import runpy
import tomllib
from importlib.metadata import distributions
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def set_up() -> dict:
    return runpy.run_path(str(REPOSITORY / ".ci" / "set_up.py"))


def canonical(name: str) -> str:
    return name.lower().replace("_", "-").replace(".", "-")


def test_every_installed_package_has_the_version_of_the_constraints() -> None:
    text = (REPOSITORY / "constraints.txt").read_text("utf-8")
    lines = [line.split("==") for line in text.splitlines() if not line.startswith("#")]
    pinned = {canonical(name): version for name, version in lines}
    found = {canonical(item.metadata["Name"]): item.version for item in distributions()}
    # pip comes with Python; setuptools as well with Python 3.11, until torch requires it.
    others = {name: version for name, version in found.items() if name not in ("pip", "glassware", "setuptools")}
    assert len(others) > 25
    # +cpu is a build of the same version for processors.
    assert {name: version for name, version in others.items() if pinned.get(name) != version.split("+")[0]} == {}
    assert "setuptools" in pinned


def test_packages_on_their_way_and_steps_are_lines(set_up: dict) -> None:
    shown = {
        "  Downloading mitsuba-3.9.1-cp311-cp311-manylinux_2_28_x86_64.whl (62.7 MB)\n": [
            "      mitsuba 3.9.1 (62.7 MB)"
        ],
        "  Using cached pyoidn-2.5.1.0-py3-none-manylinux2014_x86_64.whl (87.6 MB)\n": [
            "      pyoidn 2.5.1.0 (87.6 MB)"
        ],
        "  Downloading cffi-2.1.1-py3-none-any.whl (222 kB)\n": [],
        "Collecting mitsuba==3.9.1 (from glassware==0.1.0.dev0)\n": [],
        "Installing collected packages: a, b, c\n": ["[3/3] writing 3 packages into .venv, about half a minute"],
    }
    assert {line: list(set_up["progress"](line)) for line in shown} == shown


def test_a_stopped_run_leaves_no_half_package_that_pip_would_take_for_a_whole_one(set_up: dict, tmp_path: Path) -> None:
    site = tmp_path / "lib" / "python3.11" / "site-packages"
    for name in ("whole-1.dist-info", "half-1.dist-info", "~numpy"):
        (site / name).mkdir(parents=True)
        (site / name / "METADATA").touch()
    (site / "whole-1.dist-info" / "RECORD").touch()
    (tmp_path / ".unfinished").touch()
    names = set_up["remove_unfinished"].__globals__
    names |= {"VENV": tmp_path, "UNFINISHED": tmp_path / ".unfinished"}
    set_up["remove_unfinished"]()
    assert [path.name for path in site.iterdir()] == ["whole-1.dist-info"]


def test_pictures_need_no_networks_clusters_or_checkers(set_up: dict) -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    heavy = ("torch", "ray", "pyright", "lightning", "tensorboard", "matplotlib", "pytest")
    assert not [item for item in project["dependencies"] if item.startswith(heavy)]
    assert set_up["CONTENTS"]["pictures"][0] == "."
    assert set_up["torch_requirement"]().startswith("torch==")
