"""The work of ``build-dataset``: from its request to a data set, scene by scene, with its progress on the terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from time import perf_counter
from typing import Protocol

from rich.console import Console

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from ...core.passed_over import report
from ...core.user_text import counted, sized
from ...procedural.scene.asset_files import AssetFiles, asset_files
from ...procedural.scene.settings import SceneSettings
from ..builds.build_log import BuildLog
from ..builds.local_executor import LocalExecutor
from ..builds.manifest import Manifest, check_manifest, read_manifest, scan, write_manifest
from ..builds.messages import Attempt, WorkerConfig, WorkerInfo
from ..builds.output_folder import finalize_output, lock_output, prepare_output
from ..builds.plan import Plan, plan_build
from ..builds.scheduler import Executor, Result, run
from ..builds.shared_files import check_original, link_equal_files
from ..builds.space import Need, dataset_size, estimated, measured, space_error
from ..format import layout
from ..format.dataset_file import DatasetFile, digest_of, new_head, with_files
from ..format.developed import check_camera
from ..format.split_file import splits_file
from ..output_checks import check_request
from ..settings.scene_ranges import format_scenes, parse_scenes
from .build_request import BuildDataset
from .progress import BuildProgress, SceneProgress, clock


class _BuildExecutor(Executor, Protocol):
    def worker_info(self) -> WorkerInfo: ...


def build(request: BuildDataset, scenes: Sequence[int], console: Console, arguments: Sequence[str]) -> None:
    """Render the scenes of a request that are not there yet, and say what was made.

    Raises
    ------
    InputError
        Where the folder holds something else, a file of the settings cannot be used, or the disk is too small.
    WorkFailed
        Where scenes failed.
    """

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    root, start = request.out.absolute(), perf_counter()
    if request.twin_of is not None:
        check_original(request.twin_of, root, request.seed, request.settings.twin)
    with lock_output(root, say):
        if not request.overwrite:
            check_request(root, request.seed, request.settings.model_dump(mode="json"))
        request = _with_space(request, root, scenes, console)
        files, manifest = _assets(root, request.settings, request.overwrite, SceneProgress(console))
        try:
            say(f"starting {counted(request.workers, 'worker')}")
            with _executor(request, _worker_config(request, root, manifest)) as executor:
                head = _head(request, manifest, executor.worker_info())
                head = with_files(head, files)
                head = prepare_output(root, head, scenes, request.overwrite)
                write_manifest(root, manifest)
                plan = _plan(request, root, scenes, say)
                result = _render(request, plan, executor, console, arguments)
        finally:  # the workers are dead now, and may have died in the middle of a scene
            remove_leftovers(root / layout.SCENES)
        say("writing index, splits and gallery")
        views = finalize_output(root, splits_file(request.settings, files, request.seed, parse_scenes(head.scenes)))
        if request.twin_of is not None:
            count, size = link_equal_files(root, request.twin_of)
            say(f"{counted(count, 'file')}, {sized(size)}, stored once with {request.twin_of}")
    say(_made(request, views, perf_counter() - start))
    _report_failures(request, result)


def _worker_config(request: BuildDataset, root: Path, manifest: Manifest) -> WorkerConfig:
    return WorkerConfig(
        root=root,
        seed=request.seed,
        settings=request.settings,
        files=request.write,
        manifest=manifest,
        threads=request.threads or max(1, _cores() // request.workers),
        memory=request.memory,
    )


def _made(request: BuildDataset, views: int, seconds: float) -> str:
    """Return what is there now, how large it is, and what to do next."""
    out = request.out
    scenes = layout.scene_ids(out)
    size = sized(dataset_size(out, scenes)) if scenes else "nothing"
    made = f"{out}: {counted(len(scenes), 'scene')}, {counted(views, 'view')}, {size}, after {clock(seconds)}"
    if not scenes:  # neither a preview nor anything to check
        return made
    return f"{made}. Look at {out / layout.PREVIEW} (glassware show {out}); check it with glassware verify {out}"


def _with_space(request: BuildDataset, root: Path, scenes: Sequence[int], console: Console) -> BuildDataset:
    """Say what the build is likely to take, and ask where it does not fit; return the request with the answer."""
    there = set() if request.overwrite else set(layout.scene_ids(root))
    missing = len(set(scenes) - there)
    need = estimated(root, request.settings, request.write, missing)
    if not missing:
        console.print(f"all {counted(len(set(scenes)), 'scene')} are there", markup=False, highlight=False)
        return request
    console.print(
        f"about {sized(need.each)} a pair, {sized(need.total)} in all, {sized(need.free)} free; "
        "the first scene measures space and time",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )
    _allow(request, root, need, console)
    return request if need.fits else request.model_copy(update={"yes": True})


def _allow(request: BuildDataset, root: Path, need: Need, console: Console) -> None:
    """Raise InputError where scenes do not fit on the disk, unless the user wants them all the same."""
    if need.fits or request.yes:
        return
    if console.is_terminal and sys.stdin.isatty():
        question = f"{sized(need.total)} may not fit into {sized(need.free)}. Build anyway? [y/N] "
        console.print(question, markup=False, highlight=False, soft_wrap=True, end="")
        if input().strip().lower() in ("y", "yes"):
            return
    raise space_error(root, need)


def _assets(
    root: Path, settings: SceneSettings, overwrite: bool, progress: SceneProgress
) -> tuple[AssetFiles, Manifest]:
    """Return the asset files and their manifest, after comparing it with the data set's; say what is passed over."""
    check_camera(settings)
    found, stored = scan(settings), read_manifest(root)
    if stored is not None and not overwrite:
        check_manifest(stored, found, settings)
    files = asset_files(settings, progress.checking)
    progress.say_all(report(files.findings))
    return files, found


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
    root, count = request.out.absolute(), len(plan.to_render)

    def first_made(attempt: Attempt) -> None:
        need = measured(root, attempt.scene, count)
        pair = attempt.total / max(1, attempt.views)
        whole = clock(pair * need.pairs / request.workers)
        progress.say(
            f"scene {attempt.scene} took {sized(need.each)} and {pair:.3g} s a pair: about "
            f"{sized(need.total)} and {whole} for {counted(count, 'scene')}"
        )
        with progress.paused():
            _allow(request, root, need, console)

    progress = BuildProgress(console, count, request.settings.cameras.views, first_made)
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
