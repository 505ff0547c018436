"""Paths in YAML files begin at the file, and what is not there is named with its setting."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

import glassware as gw
from glassware.dataset.commands.scene_request import RenderScene
from glassware.dataset.settings.config import parse_request


def mesh_dir(arguments: list[str]) -> Path | None:
    return parse_request(RenderScene, arguments, "render-scene", "").settings.mesh_dir


def test_a_relative_path_begins_at_the_file_and_then_at_the_current_folder(tmp_path: Path) -> None:
    (tmp_path / "project" / "meshes").mkdir(parents=True)
    (tmp_path / "here").mkdir()
    file = tmp_path / "project" / "a.yaml"
    file.write_text("mesh_dir: meshes\n")
    with contextlib.chdir(tmp_path):
        assert mesh_dir(["--config", "project/a.yaml"]) == Path("project/meshes")
        assert mesh_dir(["--config", str(file)]) == tmp_path / "project" / "meshes"
        file.write_text("mesh_dir: here\n")
        assert mesh_dir(["--config", "project/a.yaml"]) == Path("here")
        # An option is typed where one is.
        assert mesh_dir(["--config", "project/a.yaml", "--mesh-dir", "meshes"]) == Path("meshes")


@pytest.mark.parametrize(
    "settings",
    [
        {"mesh_dir": "nowhere"},
        {"vessel_dir": "nowhere"},
        {"texture_dir": "nowhere"},
        {"table": {"texture_dir": "nowhere"}},
        {"environment": {"hdri_dir": "nowhere"}},
    ],
)
def test_what_is_not_there_is_named_with_its_setting(settings: dict) -> None:
    name, value = next(iter(settings.items()))
    name = f"{name}.{next(iter(value))}" if isinstance(value, dict) else name
    with pytest.raises(gw.InputError, match=rf"^{name}: expected .*, found none at nowhere"):
        gw.draw(0, **settings)
