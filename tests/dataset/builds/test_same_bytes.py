"""A scene's bytes depend on seed, number, settings and assets: not on workers, order, shards, cores or a cluster."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from glassware.dataset.builds.local_executor import LocalExecutor
from glassware.dataset.builds.manifest import Manifest
from glassware.dataset.builds.messages import WorkerConfig
from glassware.dataset.commands.glassware import main
from glassware.procedural.scene.settings import SceneSettings


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "scenes", "more"),
    [
        pytest.param(
            2, "5,4,3,2,1,0", ("--max-tasks-per-child", 2), id="two workers, backwards, replaced after two scenes"
        ),
        pytest.param(4, "3,0,5,1,4,2", ("--threads", 2), id="four workers, in disorder"),
    ],
)
def test_workers_and_order_do_not_matter(builds, undisturbed, content, tmp_path, workers, scenes, more):
    ended = builds.run(tmp_path / "data", "--workers", workers, *more, scenes=scenes)
    assert ended.returncode == 0, ended.stderr
    assert content(tmp_path / "data") == content(undisturbed)


@pytest.mark.slow
def test_merged_shards_are_the_whole_and_a_merge_can_be_repeated(builds, undisturbed, content, tmp_path, capsys):
    shards = [tmp_path / f"shard-{i}" for i in (1, 2, 3)]
    for i, folder in enumerate(shards, start=1):
        ended = builds.run(folder, "--shard", f"{i}/3")
        assert ended.returncode == 0, ended.stderr
    given = [str(shards[2]), str(shards[0]), str(shards[1])]
    for _ in range(2):
        assert main(["merge", *given, "--out", str(tmp_path / "whole")]) == 0
        assert content(tmp_path / "whole") == content(undisturbed)
    assert main(["verify", str(tmp_path / "whole")]) == 0
    assert "6 scenes, no faults" in capsys.readouterr().out


@pytest.mark.slow
def test_workers_on_one_core_do_not_wait_for_each_other(builds, undisturbed, content, tmp_path):
    core = str(min(os.sched_getaffinity(0)))
    ended = builds.run(tmp_path / "data", "--workers", 2, before=("taskset", "-c", core))
    assert ended.returncode == 0, ended.stderr
    assert content(tmp_path / "data") == content(undisturbed)


@pytest.mark.slow
def test_a_data_set_grows_and_is_the_one_that_was_built_at_once(builds, undisturbed, content, tmp_path):
    for scenes in ("2:4", "0:6"):
        ended = builds.run(tmp_path / "data", scenes=scenes)
        assert ended.returncode == 0, ended.stderr
    assert "4 scenes to render, 2 kept" in ended.stdout
    assert content(tmp_path / "data") == content(undisturbed)


def test_workers_are_told_their_threads_and_their_device(tmp_path):
    config = WorkerConfig(root=tmp_path, seed=1, settings=SceneSettings(), manifest=Manifest(), threads=3)
    with LocalExecutor(config, workers=2, max_tasks_per_child=1, timeout=60.0, devices=("7", "5")) as executor:
        info = executor.worker_info()
        environment = Path(f"/proc/{info.process}/environ").read_bytes().split(b"\0")
    assert b"CUDA_VISIBLE_DEVICES=7" in environment
    assert {b"OMP_NUM_THREADS=3", b"OPENBLAS_NUM_THREADS=3", b"OIDN_NUM_THREADS=3"} < set(environment)
    assert not Path(f"/proc/{info.process}").exists()  # leaving the executor kills its workers
