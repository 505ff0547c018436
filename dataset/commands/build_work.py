"""The work of ``build-dataset``: from its request to a data set, scene by scene, with its progress on the terminal."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Protocol

from rich.console import Console

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from ...core.user_text import counted
from ...procedural.scene.asset_files import AssetFiles, asset_files, check_inputs
from ...procedural.scene.settings import SceneSettings
from ..builds.build_log import BuildLog
from ..builds.local_executor import LocalExecutor
from ..builds.manifest import Manifest, check_manifest, read_manifest, scan, write_manifest
from ..builds.messages import WorkerConfig, WorkerInfo
from ..builds.output_folder import finalize_output, lock_output, prepare_output
from ..builds.plan import Plan, plan_build
from ..builds.scheduler import Executor, Result, run
from ..format import layout
from ..format.dataset_file import DatasetFile, digest_of, new_head
from ..format.split_file import splits_file
from ..output_checks import check_request
from ..settings.scene_ranges import format_scenes, parse_scenes, shard
from .build_request import BuildDataset
from .progress import BuildProgress


class _BuildExecutor(Executor, Protocol):
    def worker_info(self) -> WorkerInfo: ...


def build(request: BuildDataset, arguments: Sequence[str]) -> None:
    """Render the scenes of a request that are not there yet, and say what was made.

    Raises
    ------
    InputError
        Where the folder holds something else, or a file of the settings cannot be used.
    WorkFailed
        Where scenes failed.
    """
    scenes = _requested_scenes(request)
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    root = request.out.absolute()
    with lock_output(root, say):
        if not request.overwrite:
            check_request(root, request.seed, request.settings.model_dump(mode="json"))
        files, manifest = _assets(root, request.settings, request.overwrite)
        config = WorkerConfig(
            root=root,
            seed=request.seed,
            settings=request.settings,
            files=request.write,
            manifest=manifest,
            threads=request.threads or max(1, _cores() // request.workers),
            memory=request.memory,
        )
        try:
            with _executor(request, config) as executor:
                head = _head(request, manifest, executor.worker_info())
                head = prepare_output(root, head, scenes, request.overwrite)
                write_manifest(root, manifest)
                plan = _plan(request, root, scenes, say)
                result = _render(request, plan, executor, console, arguments)
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


def _assets(root: Path, settings: SceneSettings, overwrite: bool) -> tuple[AssetFiles, Manifest]:
    """Return the asset files and their manifest, after comparing it with the data set's."""
    found, stored = scan(settings), read_manifest(root)
    if stored is not None and not overwrite:
        check_manifest(stored, found, settings)
    if found != stored:  # the files of a stored manifest were checked when it was written
        check_inputs(settings)
    return asset_files(settings), found


def _head(request: BuildDataset, manifest: Manifest, info: WorkerInfo) -> DatasetFile:
    config = request.settings.model_dump(mode="json")
    head = new_head(request.name, request.seed, config, info.versions, info.backend, files=request.write)
    return head.model_copy(update={"hashes": head.hashes | {"assets": digest_of(manifest.model_dump(mode="json"))}})


def _plan(request: BuildDataset, root: Path, scenes: Sequence[int], say: Callable[[str], None]) -> Plan:
    plan = plan_build(root, scenes, request.check == "contents", _cores(), say, request.retry_failed)
    say(f"{request.out}: {counted(len(plan.to_render), 'scene')} to render, {len(plan.to_keep)} kept")
    return plan


def _render(
    request: BuildDataset, plan: Plan, executor: Executor, console: Console, arguments: Sequence[str]
) -> Result:
    root = request.out.absolute()
    progress = BuildProgress(console, len(plan.to_render), request.settings.cameras.views)
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
