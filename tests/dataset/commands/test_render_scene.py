"""The command as a whole: the same files from the same seed, settings in layers, and Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from glassware.dataset.commands.render_scene import main
from glassware.dataset.reader import Dataset
from glassware.dataset.settings.config import preset
from glassware.procedural.scene.scene_file import load_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.vessels.settings import VesselSettings
from glassware.render.renderer import Renderer

#: Longest that a child process may take [s]; it takes about five on an idle core.
PATIENCE = 120
#: The command as a process of its own.
COMMAND = [sys.executable, "-P", "-m", "glassware.dataset.commands.render_scene"]


def _files(root: Path) -> dict[str, bytes]:
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in root.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def made(backend, small, tmp_path_factory) -> Path:
    """A data set of seed 7, made in this process."""
    out = tmp_path_factory.mktemp("made") / "out"
    assert main(["--seed", "7", "--config", str(small), "--out", str(out)]) == 0
    return out


def test_the_same_seed_gives_the_same_files_bit_for_bit(made, render_scene, small, tmp_path):
    assert render_scene("--seed", 7, "--config", small, "--out", tmp_path / "again").code == 0
    assert _files(tmp_path / "again") == _files(made)


@pytest.mark.slow
def test_one_core_gives_the_same_files_as_all_bit_for_bit(made, small, tmp_path):
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) < 2:
        pytest.skip("this process may use one core only")
    command = ["taskset", "-c", str(cores[0]), *COMMAND, "--seed", "7", "--config", str(small)]
    arguments = [*command, "--out", str(tmp_path / "one")]
    ended = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert ended.returncode == 0, ended.stderr
    assert _files(tmp_path / "one") == _files(made)


def test_a_picture_rendered_again_from_the_scene_file_is_the_first(made):
    (stored,) = Dataset.open(made).scenes
    renderer = Renderer(load_scene(made / "scenes" / "000000" / "scene.json"))
    # Last view first: what was rendered before must not matter either.
    for number, view in reversed(list(enumerate(stored.views))):
        frame = renderer.frame(number)
        # Depths are stored as they are, and other values as half floats (docs/format.md, "Half floats").
        np.testing.assert_array_equal(frame.left.astype(np.float16), view.radiance("left"))
        np.testing.assert_array_equal(frame.right.astype(np.float16), view.radiance("right"))
        for field, values in vars(frame.geometry).items():
            kept = values.astype(np.float16) if field in ("normal", "transmittance") else values
            np.testing.assert_array_equal(kept, getattr(view.geometry(), field), err_msg=field)


@pytest.fixture(scope="module")
def layered(backend, small, tmp_path_factory) -> Path:
    """A data set of seed 7 again, with settings from a preset, the file and the command line."""
    out = tmp_path_factory.mktemp("layered") / "out"
    above = ["--preset", "standard", "--config", str(small), "--views", "1", "--picture.no-denoise"]
    assert main(["--seed", "7", *above, "--out", str(out)]) == 0
    return out


def test_the_command_line_wins_over_the_file_and_the_file_over_the_preset(layered):
    config = json.loads((layered / "dataset.json").read_text())["config"]
    assert config["cameras"]["views"] == 1  # the command line, over the file's 2 and the preset's 10
    assert config["picture"]["denoise"] is False  # the command line, over the default
    assert config["picture"]["spp"] == 2  # the file, over the preset's 128
    assert (config["cameras"]["width"], config["cameras"]["height"]) == (32, 24)  # the file, over 640 and 480
    assert config["vessel_count"] == [1, 1]  # the file, over the default
    assert config["vessels"]["wall"] == list(
        VesselSettings().wall
    )  # the default, beside what the file says of the vessels
    (scene,) = Dataset.open(layered).scenes
    (view,) = scene.views
    assert view.radiance("left").shape == (24, 32, 3)


def test_the_number_of_views_changes_nothing_else_of_the_scene(made, layered):
    two, one = (json.loads((root / "scenes/000000/scene.json").read_text()) for root in (made, layered))
    assert (len(two["cameras"]), len(one["cameras"])) == (2, 1)
    for name in ("vessels", "props", "table", "environment", "lights"):
        assert two[name] == one[name], name


@pytest.mark.parametrize(
    ("name", "size", "views"),
    [("fast", (320, 240), 5), ("standard", (640, 480), 10), ("syn-todd", (640, 480), 57)],
)
def test_the_presets_are_those_promised(name, size, views):
    cameras = SceneSettings.model_validate(preset(name)).cameras
    assert ((cameras.width, cameras.height), cameras.views) == (size, views)
    # Syn-TODD's cameras: 613.96 px at 640 x 480, 65 mm apart.
    assert cameras.focal == pytest.approx(613.96, abs=0.005)
    assert cameras.baseline == pytest.approx(0.065)


def test_a_scene_made_again_in_the_same_folder_takes_the_first_ones_place(made, render_scene, small, tmp_path):
    out = tmp_path / "out"
    assert render_scene("--seed", 8, "--config", small, "--out", out).code == 0
    other = _files(out)
    assert render_scene("--seed", 7, "--config", small, "--out", out).code == 0
    assert _files(out) == _files(made)
    # The other seed's scene is another one altogether.
    same = {name for name, content in other.items() if _files(made).get(name) == content}
    assert not {name for name in same if name.endswith((".exr", ".ply", "scene.json", "labels.json"))}


def _started(command) -> subprocess.Popen:
    # A parent in a script's background ignores SIGINT, and its children would inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.parametrize(
    "number",
    [pytest.param(signal.SIGINT, id="ctrl-c"), pytest.param(signal.SIGTERM, id="a scheduler's SIGTERM")],
)
def test_a_scene_that_is_stopped_leaves_no_half_of_it(small, tmp_path, number):
    out = tmp_path / "out"
    arguments = ["--config", str(small), "--views", "57", "--spp", "512", "--out", str(out)]
    child = _started([*COMMAND, *arguments])
    try:
        assert child.stdout is not None
        while not child.stdout.readline().startswith("view 1/57"):  # the first view is on disk, or about to be
            assert child.poll() is None
        partial = list((out / "scenes").iterdir())
        child.send_signal(number)
        _, errors = child.communicate(timeout=PATIENCE)
    finally:
        child.kill()
        child.wait()
    assert len(partial) == 1
    assert partial[0].name.startswith(".")
    assert child.returncode == 128 + number, errors
    (line,) = errors.splitlines()
    assert "stopped" in line
    assert list((out / "scenes").iterdir()) == []
    assert not (out / "preview.png").exists()
    assert not (out / "views.parquet").exists()


@pytest.mark.slow
def test_stored_light_is_checked_and_gives_the_same_files_on_one_core(backend, small, tmp_path, capsys):
    shared = ("--seed", 7, "--config", small, "--picture.light", "shared")
    assert main([*map(str, shared), "--out", str(tmp_path / "all")]) == 0
    assert f"{tmp_path / 'all' / 'draft.png'}: a draft of the first view" in capsys.readouterr().out
    assert not (tmp_path / "all" / "draft.png").exists()
    check = json.loads((tmp_path / "all/scenes/000000/views.json").read_text())["light"]
    assert check["scene_id"] == 0
    assert check["mode"] == "shared"
    assert abs(check["difference"]) <= check["bound"] + 3.0 * check["standard_error"]
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) < 2:
        pytest.skip("this process may use one core only")
    command = ["taskset", "-c", str(cores[0]), *COMMAND, *map(str, shared), "--out", str(tmp_path / "one")]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert ended.returncode == 0, ended.stderr
    assert _files(tmp_path / "one") == _files(tmp_path / "all")
