"""Workers and builds killed at random moments: what is built again afterwards is what was built without trouble."""

from __future__ import annotations

import os
import shutil
import signal
import time

import numpy as np
import pytest

from glassware.dataset.commands.verify import main as verify


def _strike(child, family, rng) -> bool:
    """Kill the build or one of its workers; return whether it was the build."""
    workers = family(child.pid)
    if not workers or rng.random() < 0.4:
        child.kill()
        return True
    try:
        os.kill(int(rng.choice(workers)), signal.SIGKILL)
    except ProcessLookupError:  # it ended by itself in between
        return False
    return False


def _killed_build(builds, out, family, gone, rng, kills, longest) -> int:
    """Start a build, and kill what belongs to it until it is dead or done; return how many kills are left."""
    child = builds.started(out, "--workers", 2)
    try:
        while kills and child.poll() is None:
            time.sleep(rng.uniform(0.0, longest))
            if child.poll() is not None:
                break
            kills -= 1
            if _strike(child, family, rng):
                break
        child.communicate(timeout=300)
    finally:
        child.kill()
        child.communicate()
    # Killed, done, or done but for a scene whose two tries were both killed.
    assert child.returncode in (-signal.SIGKILL, 0, 1)
    gone(child.pid)
    return kills


@pytest.mark.slow
@pytest.mark.parametrize(
    "kills", [pytest.param(3, id="3 kills"), pytest.param(50, id="50 kills", marks=pytest.mark.slow)]
)
def test_after_kills_a_build_goes_on_to_the_same_bytes(
    builds, undisturbed, content, hidden, family, gone, tmp_path, kills
):
    rng, out = np.random.default_rng(kills), tmp_path / "data"
    while kills:
        kills = _killed_build(builds, out, family, gone, rng, kills, longest=5.0)
        assert not out.exists() or _whole(out)
        if kills and (out / "views.parquet").exists():  # it came to its end: the next one begins anew
            assert content(out) == content(undisturbed) or _some_failed(out)
            shutil.rmtree(out)
    ended = builds.run(out, "--workers", 2)
    assert ended.returncode == 0, ended.stderr
    assert content(out) == content(undisturbed)
    assert hidden(out) == []
    assert verify([str(out)]) == 0


@pytest.mark.slow
def test_a_build_that_is_killed_before_it_has_a_head_begins_anew(builds, tmp_path, gone, cleared):
    out = tmp_path / "data"
    child = builds.started(out)
    cleared(child)
    while not out.exists() or not list(out.iterdir()):
        assert child.poll() is None
    child.kill()
    child.communicate()
    gone(child.pid)
    assert not (out / "dataset.json").exists()  # it was early enough
    ended = builds.run(out, scenes="0:1")
    assert ended.returncode == 0, ended.stderr
    assert not (out / ".build.lock").exists()


def _whole(out) -> bool:
    """Tell whether each scene that is there has its last file: what is half-made has a hidden name."""
    return all((scene / "checksums.json").is_file() for scene in (out / "scenes").glob("[0-9]*"))


def _some_failed(out) -> bool:
    """Tell whether a scene is missing because both of its tries were killed."""
    return len(list((out / "scenes").glob("[0-9]*"))) < 6
