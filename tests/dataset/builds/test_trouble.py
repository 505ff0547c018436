"""Disks, permissions, assets, memory and signals: a clear message, nothing half-written, and the build goes on."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess

import pytest

from glassware.dataset.commands.build_dataset import main


@pytest.fixture
def small_disk(tmp_path):
    """A function that mounts a folder with so many bytes, or changes how it is mounted."""
    place = tmp_path / "disk"
    place.mkdir()

    def mount(options: str) -> object:
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(place)], capture_output=True, check=False
        )
        if done.returncode:
            pytest.skip("this process may not mount a small disk")
        return place

    yield mount
    subprocess.run(["umount", "--lazy", str(place)], capture_output=True, check=False)


def _first_scene(child) -> None:
    """Wait until a build tells of its first scene."""
    assert child.stdout is not None
    while not (line := child.stdout.readline()).startswith("scene "):
        assert line, child.stderr.read()


def _last_line(errors: str) -> str:
    assert errors.count("\n") == 1, errors
    return errors


@pytest.mark.slow
def test_a_full_disk_ends_the_build_and_a_larger_one_goes_on(builds, undisturbed, content, hidden, small_disk):
    out = small_disk("size=900k") / "data"
    ended = builds.run(out, "--workers", 2)
    assert ended.returncode == 1, ended.stderr
    assert "no room to write" in _last_line(ended.stderr)
    assert hidden(out) == []
    made = {path.parent for path in out.glob("scenes/*/checksums.json")}
    assert made == set(out.glob("scenes/*"))
    small_disk("remount,size=30m")
    ended = builds.run(out, "--workers", 2)
    assert ended.returncode == 0, ended.stderr
    assert f"{6 - len(made)} scenes to render" in ended.stdout
    assert content(out) == content(undisturbed)


def test_a_read_only_folder_is_refused_in_one_line(refused, undisturbed, small_disk):
    out = small_disk("size=30m") / "data"
    shutil.copytree(undisturbed, out)
    small_disk("remount,ro")
    refused(out, scenes="0:7", says=(f"{out}: expected a folder that can be created and written to",))


@pytest.mark.slow
def test_an_asset_that_vanishes_ends_the_build_by_its_name(builds, content, hidden, tmp_path, cleared):
    folder, spare = tmp_path / "hdri", tmp_path / "spare.hdr"
    shutil.copytree(builds.settings.parent / "hdri", folder)
    more = ("--workers", 2, "--hdri-dir", folder)
    child = builds.started(tmp_path / "data", *more, scenes="0:60")
    cleared(child)
    _first_scene(child)
    shutil.move(folder / "b.hdr", spare)
    _, errors = child.communicate(timeout=120)
    assert child.returncode == 2
    assert f"{folder / 'b.hdr'}: expected the asset" in _last_line(errors)
    assert hidden(tmp_path / "data") == []

    resumed = builds.run(tmp_path / "data", *more, scenes="0:6")
    assert resumed.returncode == 2
    assert f"{folder / 'b.hdr'}: expected the asset that manifest.json names, found no such file" in resumed.stderr
    spare.write_bytes(spare.read_bytes()[:-1] + b"\0")
    shutil.copy(spare, folder / "b.hdr")
    resumed = builds.run(tmp_path / "data", *more, scenes="0:6")
    assert resumed.returncode == 2
    assert f"{folder / 'b.hdr'}: expected the asset as manifest.json has it" in resumed.stderr
    shutil.copy(builds.settings.parent / "hdri" / "b.hdr", folder / "b.hdr")
    resumed = builds.run(tmp_path / "data", *more, scenes="0:6")
    assert resumed.returncode == 0, resumed.stderr


@pytest.mark.slow
def test_workers_without_memory_fail_their_scenes_and_retry_failed_makes_them(
    builds, undisturbed, content, hidden, tmp_path
):
    out = tmp_path / "data"
    assert builds.run(out, scenes="1:6").returncode == 0
    ended = builds.run(out, "--memory", 0.05, "--timeout", 60)
    assert ended.returncode == 1
    assert "1 scene failed (0); build.jsonl" in ended.stderr
    assert hidden(out) == []
    tries = [line for line in _log(out) if line["event"] == "scene" and line["scene"] == 0]
    assert [(line["attempt"], line["state"]) for line in tries] == [(1, "failed"), (2, "failed")]
    assert len({line["process"] for line in tries}) == 2  # the second was a fresh one
    assert all("memory" in line["reason"].lower() or "alloc" in line["reason"] for line in tries)

    shutil.rmtree(out / "scenes" / "000003")  # not there either, but it did not fail
    ended = builds.run(out, "--retry-failed")
    assert "1 scene to render" in ended.stdout
    assert sorted(path.name for path in (out / "scenes").iterdir()) == [f"{i:06d}" for i in (0, 1, 2, 4, 5)]
    assert builds.run(out).returncode == 0
    assert content(out) == content(undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "everyone"),
    [
        pytest.param(signal.SIGINT, True, id="Ctrl-C on a terminal"),
        pytest.param(signal.SIGTERM, True, id="a scheduler's SIGTERM to all"),
        pytest.param(signal.SIGTERM, False, id="SIGTERM to the build alone"),
    ],
)
def test_a_build_that_is_stopped_goes_on_later(
    builds, undisturbed, content, hidden, gone, tmp_path, cleared, number, everyone
):
    out = tmp_path / "data"
    child = builds.started(out, "--workers", 2)
    cleared(child)
    _first_scene(child)
    (os.killpg if everyone else os.kill)(child.pid, number)
    _, errors = child.communicate(timeout=60)
    assert child.returncode == 128 + number, errors
    assert _last_line(errors) == "stopped; no incomplete files are left\n"
    gone(child.pid)
    assert hidden(out) == []
    assert 1 <= len(list((out / "scenes").iterdir())) < 6
    assert [line["event"] for line in _log(out)][-1] == "stop"
    ended = builds.run(out, "--workers", 2)
    assert ended.returncode == 0, ended.stderr
    assert content(out) == content(undisturbed)


@pytest.mark.slow
def test_a_folder_is_taken_by_one_build_at_a_time(builds, tmp_path, capsys, cleared):
    child = builds.started(tmp_path / "data", scenes="0:60")
    cleared(child)
    while not (tmp_path / "data" / "dataset.json").exists():  # it is written once the folder is locked
        assert child.poll() is None
    assert main(builds.arguments(tmp_path / "data")) == 2
    assert "expected a folder that no other build works in" in _last_line(capsys.readouterr().err)


def _log(out) -> list[dict]:
    lines = []
    for line in (out / "build.jsonl").read_text().splitlines():
        with contextlib.suppress(ValueError):
            lines.append(json.loads(line))
    return lines
