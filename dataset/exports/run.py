"""Export a data set, scene by scene; an export that was stopped goes on."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...core.arguments import as_path, described
from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError, cause_of
from ...core.setting_errors import setting_error, suggest
from ...core.stopping import check_stop
from ..reader import Dataset, StoredScene
from .detection.partial import check_exportable
from .folder import RECORD, check_target, new_record, write_record
from .formats import FORMATS
from .job import Exporter, ExportOptions, Job

#: Most threads: pictures are read and compressed in parallel, the rest is Python.
_MOST_THREADS = 8
#: Options that some formats alone have.
_OF_FORMATS = {
    "liquids": ("bop", "bop-webdataset"),
    "polygons": ("coco",),
    "layers": ("ply",),
    "licence": ("webdataset",),
}
#: Passes on finished scenes one by one, and may show how many there are of a total.
Track = Callable[[Iterable[object], int], Iterable[object]]


@dataclass(frozen=True)
class Exported:
    """What an export did."""

    scenes: int  #: in the export
    written: int  #: of them, by this run; the others were there


def export(
    root: Path | str, format: str, out: Path | str, track: Track = lambda done, _: done, **options: Any
) -> Exported:
    """Export a data set in the layout of another project.

    Parameters
    ----------
    root : Path or str
        Folder of the data set.
    format : str
        A name in `formats.FORMATS`.
    out : Path or str
        Folder of the export: absent, empty, or an export of the same kind, whose complete scenes are kept.
    track : callable, optional
        (finished scenes, their total) -> the same, to show progress.
    options
        The fields of `ExportOptions`: split, eye, labels, vessels_only, liquids, polygons, layers, copy_pictures.

    Raises
    ------
    InputError
        For an unknown format or option, a folder that holds something else, a damaged or missing file. Scenes that were
        complete before stay.
    """
    exporter = exporter_of(format)
    job = Job(Dataset.open(root), as_path("export: out", out), _checked(options))
    _check_options(job, format, exporter)
    check_exportable(job.dataset.head, format)
    record, scenes = new_record(job, format), job.scenes()
    known = check_target(job, record)
    numbers = tuple(scene.scene_id for scene in scenes)
    if known is not None and known.finished == numbers:
        return Exported(len(scenes), 0)
    _begin(job.out)
    try:
        write_record(job.out, record)
        written = _write(job, exporter, scenes, track)
        exporter.finish(job, scenes)
        write_record(job.out, record.model_copy(update={"finished": numbers}))
    except BaseException:
        _forget_if_empty(job.out)
        raise
    return Exported(len(scenes), written)


def exporter_of(name: object) -> Exporter:
    """Return the exporter of a format; InputError where there is none."""
    if not isinstance(name, str) or name not in FORMATS:
        hint = suggest(name, [*FORMATS]) if isinstance(name, str) else ""
        raise InputError("--format", f"one of {', '.join(FORMATS)}{hint}", described(name))
    return FORMATS[name]


def _checked(options: dict[str, Any]) -> ExportOptions:
    try:
        return ExportOptions.model_validate(options)
    except ValidationError as error:
        raise setting_error("export", error, ExportOptions) from error


def _check_options(job: Job, name: str, exporter: Exporter) -> None:
    if job.options.eye != "left" and not exporter.eyes:
        raise InputError("--eye", f"left, because {name} holds labels, which are the left camera's", job.options.eye)
    _check_labels(job.options.labels, name, exporter)
    for option, formats in _OF_FORMATS.items():
        if getattr(job.options, option) and name not in formats:
            raise InputError(f"--{option}", f"the format {' or '.join(formats)}", name)


def _check_labels(labels: tuple[str, ...] | None, name: str, exporter: Exporter) -> None:
    if labels is None:
        return
    if not exporter.labels:
        raise InputError("--labels", f"none for {name}, whose labels belong together", ", ".join(labels))
    wrong = next((label for label in labels if label not in exporter.labels), None)
    if wrong is not None or not labels:
        hint = suggest(wrong, [*exporter.labels]) if wrong is not None else ""
        raise InputError("--labels", f"some of {', '.join(exporter.labels)}{hint}", described(wrong))


def _begin(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(out, "a folder that can be created and written to", cause_of(error)) from error
    remove_leftovers(out)


def _write(job: Job, exporter: Exporter, scenes: tuple[StoredScene, ...], track: Track) -> int:
    """Write the scenes that are not there, in parallel; return their number."""
    places = {scene.scene_id: exporter.place(job, scene) for scene in scenes}
    for folder in {place.parent for place in places.values()}:
        remove_leftovers(folder)
    missing = [scene for scene in scenes if not places[scene.scene_id].exists()]

    def write(scene: StoredScene) -> None:
        check_stop()
        places[scene.scene_id].parent.mkdir(parents=True, exist_ok=True)
        exporter.write(job, scene)

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with ThreadPoolExecutor(min(cores, _MOST_THREADS)) as pool:
        try:
            for _ in track(_in_order(pool.map(write, missing)), len(missing)):
                check_stop()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return len(missing)


def _in_order(done: Iterator[None]) -> Iterator[object]:
    yield from done


def _forget_if_empty(out: Path) -> None:
    """Delete a folder in which nothing but the record was written."""
    remove_leftovers(out)
    if not any(path.is_file() and path.name != RECORD for path in out.rglob("*")):
        (out / RECORD).unlink(missing_ok=True)
        for folder in sorted((path for path in out.rglob("*") if path.is_dir()), reverse=True):
            folder.rmdir()
        out.rmdir()
