"""``build-dataset``: many labelled scenes from one seed, by worker processes or a cluster; it can be resumed."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Annotated, Literal, Protocol

from pydantic import Field
from rich.console import Console

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError
from ...core.exit_codes import WorkFailed, run_command
from ...core.model import Model
from ...core.passed_over import report
from ...core.user_text import UserPath, UserText, counted
from ...procedural.scene.asset_files import AssetFiles, asset_files
from ...procedural.scene.settings import SceneSettings
from ..builds.build_log import BuildLog
from ..builds.local_executor import LocalExecutor
from ..builds.manifest import Manifest, check_manifest, read_manifest, scan, write_manifest
from ..builds.messages import WorkerConfig, WorkerInfo
from ..builds.output_folder import finalize_output, lock_output, prepare_output
from ..builds.plan import Plan, plan_build
from ..builds.scheduler import Executor, Result, run
from ..format import layout
from ..format.dataset_file import DatasetFile, digest_of, new_head, with_files
from ..format.split_file import splits_file
from ..output_checks import check_request
from ..settings.config import FLAT, parse_request
from ..settings.scene_ranges import format_scenes, parse_scenes, shard
from .progress import BuildProgress, Stages

_DESCRIPTION = """Build a data set of many scenes. Run the same command again to resume a build that was stopped.

Settings are those of render-scene: a preset, then a YAML file, then the command line."""


#: As in CUDA_VISIBLE_DEVICES: a number, or the UUID of a GPU or of a MIG instance.
Device = Annotated[str, Field(pattern="^([0-9]+|(GPU|MIG)-[0-9A-Za-z/-]+)$")]


class BuildDataset(Model):
    """The request: settings, scenes, seed, output folder, and how the work is distributed."""

    settings: Annotated[SceneSettings, FLAT] = SceneSettings()
    scenes: str = Field(default="", description="Scenes, such as 0:2000 (without the end) or 3,7,10:20")
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    out: UserPath = Field(default=Path("data"), description="Output folder: absent, empty, or a data set to continue")
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(default="fast", description="Settings to start from: fast, standard or syn-todd")
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")
    workers: int = Field(default=1, ge=1, le=1024, description="Worker processes on this machine")
    threads: int | None = Field(
        default=None, ge=1, le=1024, description="Threads of each worker; by default the cores divided by the workers"
    )
    max_tasks_per_child: int = Field(
        default=50, ge=1, description="Scenes after which a worker process is replaced by a new one"
    )
    memory: float | None = Field(default=None, gt=0.0, description="Limit on the memory of each worker [GiB]")
    timeout: float = Field(
        default=3600.0, gt=0.0, description="Longest time without a message from a worker before it is killed [s]"
    )
    devices: tuple[Device, ...] = Field(
        default=(), description="CUDA devices, assigned to the workers in turn, such as 0 1 2"
    )
    shard: str | None = Field(default=None, description="i/n: render the i-th of n equal parts of the scenes")
    overwrite: bool = Field(default=False, description="Render existing scenes again")
    retry_failed: bool = Field(default=False, description="Render only the scenes whose last attempt failed")
    check: Literal["contents", "sizes"] = Field(
        default="contents", description="How the files of existing scenes are checked before they are kept"
    )
    executor: Literal["local", "ray"] = Field(
        default="local", description="Processes on this machine, or a Ray cluster"
    )
    address: str | None = Field(default=None, description="Address of the Ray cluster; by default one is started here")
    gpus: float = Field(default=0.0, ge=0.0, le=1.0, description="GPUs that a Ray task requests")


class _BuildExecutor(Executor, Protocol):
    def worker_info(self) -> WorkerInfo: ...


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _build_dataset(given))


def _build_dataset(arguments: Sequence[str]) -> None:
    request = parse_request(BuildDataset, arguments, "build-dataset", _DESCRIPTION)
    scenes = _requested_scenes(request)
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    root = request.out.absolute()
    with lock_output(root, say):
        if not request.overwrite:
            check_request(root, request.seed, request.settings.model_dump(mode="json"))
        files, manifest = _assets(root, request.settings, request.overwrite, Stages(console))
        config = WorkerConfig(
            root=root,
            seed=request.seed,
            settings=request.settings,
            manifest=manifest,
            threads=request.threads or max(1, _cores() // request.workers),
            memory=request.memory,
        )
        try:
            with _executor(request, config) as executor:
                head = _head(request, manifest, executor.worker_info())
                head = with_files(head, files)
                head = prepare_output(root, head, scenes, request.overwrite)
                write_manifest(root, manifest)
                plan = _plan(request, root, scenes, say)
                result = _render(root, plan, executor, console, arguments)
        finally:  # the workers are dead now, and may have died in the middle of a scene
            remove_leftovers(root / layout.SCENES)
        say("writing index, splits and gallery")
        views = finalize_output(root, splits_file(request.settings, files, request.seed, parse_scenes(head.scenes)))
    say(f"{request.out}: {counted(len(layout.scene_ids(root)), 'scene')}, {counted(views, 'view')}")
    _report_failures(request, result)


def _requested_scenes(request: BuildDataset) -> list[int]:
    if request.overwrite and request.retry_failed:
        raise InputError(
            "--retry-failed", "it without --overwrite, which deletes scenes that would not be rendered again", "both"
        )
    scenes = parse_scenes(request.scenes)
    if not scenes:
        raise InputError("--scenes", "scenes such as 0:2000", "none")
    return scenes if request.shard is None else shard(scenes, request.shard)


def _assets(root: Path, settings: SceneSettings, overwrite: bool, stages: Stages) -> tuple[AssetFiles, Manifest]:
    """Return the asset files and their manifest, after comparing it with the data set's; say what is passed over."""
    found, stored = scan(settings), read_manifest(root)
    if stored is not None and not overwrite:
        check_manifest(stored, found, settings)
    files = asset_files(settings, stages.checking)
    stages.say_all(report(files.findings))
    return files, found


def _head(request: BuildDataset, manifest: Manifest, info: WorkerInfo) -> DatasetFile:
    config = request.settings.model_dump(mode="json")
    head = new_head(request.name, request.seed, config, info.versions, info.backend)
    return head.model_copy(update={"hashes": head.hashes | {"assets": digest_of(manifest.model_dump(mode="json"))}})


def _plan(request: BuildDataset, root: Path, scenes: Sequence[int], say: Callable[[str], None]) -> Plan:
    plan = plan_build(root, scenes, request.check == "contents", _cores(), say, request.retry_failed)
    say(f"{request.out}: {counted(len(plan.to_render), 'scene')} to render, {len(plan.to_keep)} kept")
    return plan


def _render(root: Path, plan: Plan, executor: Executor, console: Console, arguments: Sequence[str]) -> Result:
    progress = BuildProgress(console, len(plan.to_render))
    with BuildLog(root) as log:
        facts = {"scenes": format_scenes(plan.to_render), "kept": len(plan.to_keep), "arguments": list(arguments)}
        log.add("start", **facts)
        try:
            with progress.display():
                result = run(root, plan.to_render, executor, log, progress)
        except BaseException as error:
            with suppress(OSError):  # a full disk takes no line about itself; the exception says the same
                log.add("stop", reason=f"{type(error).__name__}: {error}".rstrip(": "))
            raise
        log.add("end", made=len(result.made), failed=sorted(result.failed))
    return result


def _executor(request: BuildDataset, config: WorkerConfig) -> AbstractContextManager[_BuildExecutor]:
    if request.executor == "ray":
        from ..builds.ray_executor import RayExecutor  # Ray is an extra

        return RayExecutor(config, request.address, request.gpus, request.timeout)
    if request.address is not None:
        raise InputError("build-dataset: address", "--executor ray with it", f"--executor {request.executor}")
    return LocalExecutor(config, request.workers, request.max_tasks_per_child, request.timeout, request.devices)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _report_failures(request: BuildDataset, result: Result) -> None:
    if result.failed:
        listed = "; ".join(f"scene {scene}: {reason[:200]}" for scene, reason in sorted(result.failed.items())[:20])
        raise WorkFailed(
            f"{counted(len(result.failed), 'scene')} failed ({format_scenes(result.failed)}); {layout.LOG} in "
            f"{request.out} has the reasons, and --retry-failed renders only these scenes. {listed}"
        )


if __name__ == "__main__":
    sys.exit(main())
