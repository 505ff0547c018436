"""Builds as processes of their own: a small data set, how it is built, and what is left of a build."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.dataset.commands.build_dataset import main

#: The command as a process of its own.
COMMAND = [sys.executable, "-P", "-m", "glassware.dataset.commands.build_dataset"]
#: Longest that a build may take [s]; the whole one takes about ten on an idle core.
PATIENCE = 300
#: Longest that the workers of a build that was killed may live [s]. They end at once, or after a kernel that runs.
AFTERLIFE = 20
#: Scenes of the small data set, and its seed.
SCENES, SEED = 6, 3


@dataclass(frozen=True)
class Builds:
    """The small data set: its settings, and the ways to build it."""

    settings: Path

    def arguments(self, out: Path, *more: object, scenes: str = f"0:{SCENES}") -> list[str]:
        """Return the arguments of a build."""
        given = ["--config", self.settings, "--seed", SEED, "--scenes", scenes, "--out", out, *more]
        return [str(argument) for argument in given]

    def run(self, out: Path, *more: object, scenes: str = f"0:{SCENES}", before: tuple[str, ...] = ()):
        """Build to the end, and return the ended process with what it printed."""
        command = [*before, *COMMAND, *self.arguments(out, *more, scenes=scenes)]
        return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)

    def started(self, out: Path, *more: object, scenes: str = f"0:{SCENES}") -> subprocess.Popen:
        """Start a build in a session of its own, so that whatever it starts can be found."""
        # A parent in a script's background ignores SIGINT, and its children would inherit that.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            return subprocess.Popen(
                [*COMMAND, *self.arguments(out, *more, scenes=scenes)],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        finally:
            signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def builds(made_once) -> Builds:
    """The small data set; a scene of it takes half a second. It draws from a folder of three environment maps."""
    return Builds(made_once("tiny", _write_settings) / "tiny.yaml")


def _write_settings(folder: Path) -> None:
    rng = np.random.default_rng(7)
    (folder / "hdri").mkdir()
    for name in "abc":
        pixels = rng.uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32)
        assert cv2.imwrite(str(folder / "hdri" / f"{name}.hdr"), pixels)
    (folder / "tiny.yaml").write_text(
        "vessel_count: [1, 1]\n"
        "prop_count: [0, 0]\n"
        "vessels: {chord_error: 1.0e-4, fill_probability: 0.0, radius: [0.015, 0.02], height: [0.04, 0.06]}\n"
        f"environment: {{hdri_dir: {folder / 'hdri'}, hdri_share: 1.0}}\n"
        "cameras: {width: 16, height: 12, views: 1}\n"
        "picture: {spp: 2, denoise: false}\n"
        "write: all\n"
    )


@pytest.fixture(scope="session")
def undisturbed(builds, made_once) -> Path:
    """The data set, built by one worker without trouble."""

    def build(folder: Path) -> None:
        ended = builds.run(folder / "data")
        assert ended.returncode == 0, ended.stderr

    return made_once("undisturbed", build) / "data"


@pytest.fixture(scope="session")
def content():
    """A data set -> the bytes of all its files by their paths, without the log, which has times in it."""

    def read(root: Path) -> dict[str, bytes]:
        files = {path.relative_to(root).as_posix(): path for path in root.rglob("*") if path.is_file()}
        return {name: path.read_bytes() for name, path in files.items() if name != "build.jsonl"}

    return read


@pytest.fixture
def refused(builds, content, capsys):
    """Assert that a build into a folder is refused in one line with these words, and has changed nothing."""

    def check(out, *more: object, says: tuple[str, ...], scenes: str = f"0:{SCENES}") -> None:
        before = content(out)
        assert main(builds.arguments(out, *more, scenes=scenes)) == 2
        (line,) = capsys.readouterr().err.splitlines()
        for word in says:
            assert word in line
        assert content(out) == before

    return check


@pytest.fixture(scope="session")
def hidden():
    """A data set -> the names of half-made things in it."""

    def names(root: Path) -> list[str]:
        return [path.name for path in root.rglob(".*")]

    return names


@pytest.fixture(scope="session")
def family():
    """A build's process number -> the processes of its session that are alive, itself left out."""

    def alive(session: int) -> list[int]:
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                fields = (folder / "stat").read_text().rpartition(") ")[2].split()
            except OSError:
                continue
            # proc(5): after the name come the state, the parent, the process group and the session.
            if int(fields[3]) == session and fields[0] != "Z" and int(folder.name) != session:
                found.append(int(folder.name))
        return found

    return alive


@pytest.fixture(scope="session")
def gone(family):
    """Wait until nothing of a build's session is alive."""

    def wait(session: int) -> None:
        until = time.monotonic() + AFTERLIFE
        while family(session):
            assert time.monotonic() < until, f"still alive: {family(session)}"
            time.sleep(0.05)

    return wait


@pytest.fixture
def cleared(family):
    """A function that ends a build and all that it started, also where a test fails."""
    started: list[subprocess.Popen] = []
    yield started.append
    for child in started:
        if child.poll() is None:
            child.kill()
        child.communicate()
        for process in family(child.pid):
            os.kill(process, signal.SIGKILL)
