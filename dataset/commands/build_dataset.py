"""``build-dataset``: many labelled scenes from one seed, by worker processes or a cluster; it can stop and go on."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Annotated, Literal, Protocol

from pydantic import Field
from rich.console import Console

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError
from ...core.exit_codes import WorkFailed, outcome
from ...core.user_text import UserPath, UserText
from ...procedural.scene.asset_files import AssetFiles, asset_files, check_inputs
from ...procedural.scene.settings import SceneSettings
from ..builds.finalize import finish
from ..builds.journal import Journal
from ..builds.manifest import Manifest, check_same, read_manifest, scan, write_manifest
from ..builds.messages import Machine, Order
from ..builds.output_folder import check_request, opened, taken
from ..builds.plan import Plan, planned
from ..builds.pool import Pool
from ..builds.scheduler import Makers, Result, run
from ..format import layout
from ..format.dataset_file import DatasetFile, digest_of, new_head
from ..format.split_file import splits_file
from ..settings.config import layered, parsed
from ..settings.scene_ranges import format_scenes, parse_scenes, shard
from .build_progress import BuildProgress

_DESCRIPTION = """Build a data set of many scenes. Run the same command again to go on where it was stopped.

Settings are those of render-scene: a preset, then a YAML file, then the command line."""


#: As CUDA_VISIBLE_DEVICES names them: by number, or by the identity of a GPU or of a part of one.
Device = Annotated[str, Field(pattern="^([0-9]+|(GPU|MIG)-[0-9A-Za-z/-]+)$")]


class BuildDataset(SceneSettings):
    """The request: which scenes, from which seed, where to, and by whom."""

    scenes: str = Field(default="", description="Which, such as 0:2000 (the end is not in it) or 3,7,10:20")
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    out: UserPath = Field(
        default=Path("data"), description="Folder of the data set: absent, empty, or one to go on with"
    )
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(default="fast", description="Settings to start from: fast, standard or syn-todd")
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")
    workers: int = Field(default=1, ge=1, le=1024, description="Worker processes of this machine")
    threads: int | None = Field(
        default=None, ge=1, le=1024, description="Threads of each worker; cores over workers unless given"
    )
    recycle: int = Field(default=50, ge=1, description="Scenes after which a worker process is replaced by a new one")
    memory: float | None = Field(default=None, gt=0.0, description="Most memory that a worker may allocate [GiB]")
    patience: float = Field(
        default=3600.0, gt=0.0, description="A worker without a sign of life for so long is ended [s]"
    )
    devices: tuple[Device, ...] = Field(
        default=(), description="CUDA devices that the workers take in turn, such as 0 1 2"
    )
    shard: str | None = Field(default=None, description="i/n: make the i-th of n equal parts of the scenes")
    overwrite: bool = Field(default=False, description="Make scenes that are there again")
    retry_failed: bool = Field(default=False, description="Make only those whose last try failed")
    check: Literal["contents", "sizes"] = Field(
        default="contents", description="How files of scenes that are there are checked before they are kept"
    )
    executor: Literal["local", "ray"] = Field(
        default="local", description="Processes of this machine, or a Ray cluster"
    )
    address: str | None = Field(default=None, description="Address of the Ray cluster; without it one is started here")
    gpus: float = Field(default=0.0, ge=0.0, le=1.0, description="GPUs that a Ray task asks for")


class _Team(Makers, Protocol):
    def machine(self) -> Machine: ...


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return outcome(lambda: _build_dataset(given))


def _build_dataset(arguments: Sequence[str]) -> None:
    request = parsed(BuildDataset, layered(BuildDataset, arguments), arguments, "build-dataset", _DESCRIPTION)
    settings = SceneSettings.model_validate({name: getattr(request, name) for name in SceneSettings.model_fields})
    if request.overwrite and request.retry_failed:
        raise InputError(
            "--retry-failed", "it without --overwrite, which removes scenes that it would not make", "both"
        )
    scenes = parse_scenes(request.scenes)
    if not scenes:
        raise InputError("--scenes", "scenes such as 0:2000", "none")
    scenes = scenes if request.shard is None else shard(scenes, request.shard)
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    root = request.out.absolute()
    with taken(root, say):
        if not request.overwrite:
            check_request(root, request.seed, settings.model_dump(mode="json"))
        files, manifest = _inputs(root, settings, request.overwrite)
        order = Order(
            root=root,
            seed=request.seed,
            settings=settings,
            manifest=manifest,
            threads=_threads(request),
            memory=request.memory,
        )
        try:
            with _team(request, order) as team:
                head = _head(request, settings, manifest, team.machine())
                head = opened(root, head, scenes, request.overwrite)
                write_manifest(root, manifest)
                contents = request.check == "contents"
                plan = planned(root, scenes, contents, _cores(), say, request.retry_failed)
                say(f"{request.out}: {len(plan.make)} scenes to make, {len(plan.kept)} are there")
                result = _made(root, plan, team, console, arguments)
        finally:  # the workers are dead now, and may have died in the middle of a scene
            remove_leftovers(root / layout.SCENES)
        say("writing index, splits and gallery")
        views = finish(root, splits_file(settings, files, request.seed, parse_scenes(head.scenes)))
    say(f"{request.out}: {len(layout.scene_ids(root))} scenes, {views} views")
    _report_failures(request, result)


def _inputs(root: Path, settings: SceneSettings, overwrite: bool) -> tuple[AssetFiles, Manifest]:
    """Return the files to draw from and their manifest, after checking them against the data set's."""
    found, kept = scan(settings), read_manifest(root)
    if kept is not None and not overwrite:
        check_same(kept, found, settings)
    if found != kept:  # each was read and found good when the manifest was first written
        check_inputs(settings)
    return asset_files(settings), found


def _head(request: BuildDataset, settings: SceneSettings, manifest: Manifest, machine: Machine) -> DatasetFile:
    config = settings.model_dump(mode="json")
    head = new_head(request.name, request.seed, config, machine.versions, machine.backend)
    return head.model_copy(update={"hashes": head.hashes | {"assets": digest_of(manifest.model_dump(mode="json"))}})


def _made(root: Path, plan: Plan, team: Makers, console: Console, arguments: Sequence[str]) -> Result:
    show = BuildProgress(console, len(plan.make))
    with Journal(root) as journal:
        facts = {"scenes": format_scenes(plan.make), "kept": len(plan.kept), "arguments": list(arguments)}
        journal.note("start", **facts)
        try:
            with show.shown():
                result = run(root, plan.make, team, journal, show)
        except BaseException as error:
            with suppress(OSError):  # a full disk takes no line about itself, and what is raised says it too
                journal.note("stop", reason=f"{type(error).__name__}: {error}".rstrip(": "))
            raise
        journal.note("end", made=len(result.made), failed=sorted(result.failed))
    return result


def _team(request: BuildDataset, order: Order) -> AbstractContextManager[_Team]:
    if request.executor == "ray":
        from ..builds.cluster import Cluster  # Ray is an extra

        return Cluster(order, request.address, request.gpus, request.patience)
    if request.address is not None:
        raise InputError("build-dataset: address", "--executor ray with it", f"--executor {request.executor}")
    return Pool(order, request.workers, request.recycle, request.patience, request.devices)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _threads(request: BuildDataset) -> int:
    return request.threads or max(1, _cores() // request.workers)


def _report_failures(request: BuildDataset, result: Result) -> None:
    if result.failed:
        listed = "; ".join(f"scene {scene}: {reason[:200]}" for scene, reason in sorted(result.failed.items())[:20])
        raise WorkFailed(
            f"{len(result.failed)} scenes failed ({format_scenes(result.failed)}); {layout.LOG} in {request.out} says "
            f"why, and --retry-failed makes them alone. {listed}"
        )


if __name__ == "__main__":
    sys.exit(main())
