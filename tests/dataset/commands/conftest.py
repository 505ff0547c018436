from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.dataset.commands.render_scene import main


@dataclass(frozen=True)
class Told:
    """How a command ended: its exit code, and the lines that it wrote to stderr."""

    code: int
    errors: list[str]


def write_hdri(path: Path, rng: np.random.Generator) -> Path:
    """Write a small environment map, which takes no time to read or to bake."""
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), rng.uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32))
    return path


@pytest.fixture(scope="session")
def small(tmp_path_factory) -> Path:
    """Settings of a scene that is made in about a second."""
    folder = tmp_path_factory.mktemp("small")
    write_hdri(folder / "hdri" / "plain.hdr", np.random.default_rng(1))
    path = folder / "small.yaml"
    path.write_text(
        "vessel_count: [1, 1]\n"
        "prop_count: [1, 1]\n"
        "vessels: {categories: [tumbler, beaker], chord_error: 1.0e-4, fill_probability: 1.0}\n"
        "props: {kinds: [shape]}\n"
        "physics: {piled_probability: 0}\n"
        f"environment: {{hdri_dir: {folder / 'hdri'}, hdri_share: 1.0}}\n"
        "cameras: {width: 32, height: 24, views: 2}\n"
        "picture: {spp: 2}\n"
        "write: all\n"
    )
    return path


@pytest.fixture
def render_scene(backend, capsys):
    """The command with its arguments -> how it ended. No traceback can hide: it would fail the test."""

    def run(*arguments: object) -> Told:
        code = main([str(argument) for argument in arguments])
        return Told(code, capsys.readouterr().err.splitlines())

    return run
