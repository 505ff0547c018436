from __future__ import annotations

import json

from glassware.dataset.builds.build_log import BuildLog, last_attempts, read_log
from glassware.dataset.builds.messages import Attempt


def test_the_last_try_of_each_scene_is_found(tmp_path):
    with BuildLog(tmp_path) as log:
        log.add("start", scenes="0:2")
        log.add_attempt(Attempt(scene=1, state="failed", reason="no light"), 1)
        log.add_attempt(Attempt(scene=0, state="made"), 1)
        log.add_attempt(Attempt(scene=1, state="made", total=2.5), 2)
    found = last_attempts(tmp_path)
    assert found[1] == Attempt(scene=1, state="made", total=2.5)
    assert found[0].state == "made"
    assert [line["event"] for line in read_log(tmp_path)] == ["start", "scene", "scene", "scene"]


def test_a_line_that_a_killed_build_left_torn_hides_no_other(tmp_path):
    with BuildLog(tmp_path) as log:
        log.add_attempt(Attempt(scene=0, state="failed"), 1)
    path = tmp_path / "build.jsonl"
    path.write_bytes(path.read_bytes() + b'{"event": "scene", "sce')
    with BuildLog(tmp_path) as log:
        log.add_attempt(Attempt(scene=0, state="made"), 1)
    assert last_attempts(tmp_path)[0].state == "made"
    assert len(list(read_log(tmp_path))) == 2
    assert all(line["event"] == "scene" for line in read_log(tmp_path))


def test_every_line_is_json_with_a_time(tmp_path):
    with BuildLog(tmp_path) as log:
        log.add("stop", reason="KeyboardInterrupt")
    (line,) = (tmp_path / "build.jsonl").read_text().splitlines()
    assert json.loads(line)["time"].endswith("+00:00")
