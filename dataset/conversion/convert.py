"""Convert another project's data set: read each view, and write it in our format."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import get_args

from ...core.atomic_io import atomic_folder, remove_folder
from ...core.errors import InputError
from ...core.passed_over import Finding
from ...core.stopping import check_stop
from ...procedural.scene.splits import Split
from ..format import layout
from ..format.checksums import write_checksums
from ..format.conversion import LABEL_KINDS, Conversion, LabelKind
from ..format.dataset_file import DatasetFile, new_head, read_head, write_head
from ..format.exr import unstacked, write_exr
from ..format.pictures import write_png
from ..format.split_file import SplitsFile, write_splits
from ..format.views_table import SceneViews
from ..readers.layout import Layout
from ..readers.source_view import Collection, Entry, LeftOut, SourceView, kinds_of
from ..settings.scene_ranges import format_scenes
from ..writer import finish_dataset, start_dataset, write_json
from .records import camera_record, labels_record, view_row

#: Packages whose version can change what is written: decoding of pictures and EXR files.
_PACKAGES = ("glassware", "numpy", "opencv-python-headless", "OpenEXR", "scipy")
#: Renderer of a converted data set.
_NO_RENDERER = "none"
#: Most threads: pictures are read and compressed in parallel, the rest is Python.
_MOST_THREADS = 8


@dataclass(frozen=True)
class WrittenScene:
    """A scene that was written."""

    kinds: tuple[tuple[LabelKind, ...], ...]  #: what each of its views has
    damaged: tuple[LeftOut, ...]  #: its views that could not be read


#: Passes on the scenes one by one, and may show how many are done of a total.
Track = Callable[[Iterable[WrittenScene], int], Iterable[WrittenScene]]


def convert(
    root: Path, found: Layout, collection: Collection, out: Path, track: Track = lambda done, _: done
) -> DatasetFile:
    """Write the views of a collection as a data set of ours; return its head.

    A view that cannot be read is left out, and ``dataset.json`` names it. Scenes that are complete in the output
    folder are written again: a conversion costs little, and the files that it read may have changed.

    Parameters
    ----------
    root : Path
        The folder that was read; only its name is stored.
    found, collection : Layout, Collection
        From `recognition.open_source`.
    out : Path
        Output folder: absent, empty, or an earlier conversion of the same folder.
    track : callable, optional
        (scenes, their total) -> the same, to show progress.

    Raises
    ------
    InputError
        Where the output folder holds something else, or no view can be read.
    """
    scenes = _scenes(collection.entries)
    head = _head(root, found, collection, len(scenes))
    _check_out(out, head)
    start_dataset(out, head, range(len(scenes)))
    written = [*track(_write_all(out, scenes), len(scenes))]
    left_out = [*collection.left_out, *(item for scene in written for item in scene.damaged)]
    counts: Counter[LabelKind] = Counter(kind for scene in written for kinds in scene.kinds for kind in kinds)
    views = sum(len(scene.kinds) for scene in written)
    if not views:
        first = left_out[0]
        raise InputError(root, "a view that can be read", f"none of {len(left_out)}; {first.name}: {first.reason}")
    findings = tuple(Finding(folder=found.name, path=item.name, reason=item.reason) for item in left_out)
    record = _conversion(root, found, collection, counts, views, len(left_out))
    splits = {number: scenes[number][0].split for number, scene in enumerate(written) if scene.kinds}
    return _finished(out, head.model_copy(update={"converted": record, "findings": findings}), splits)


def _finished(out: Path, head: DatasetFile, splits: dict[int, str | None]) -> DatasetFile:
    """Write head, index and splits of the scenes that were written, and delete others; return the head."""
    for scene_id in set(layout.scene_ids(out)) - set(splits):  # of an earlier conversion that could read more
        remove_folder(layout.scene_folder(out, scene_id))
    finish_dataset(out, head)
    head = read_head(out).model_copy(update={"scenes": format_scenes(splits)})
    write_head(out, head)
    if any(splits.values()):
        write_splits(out, _splits(splits))
    else:
        (out / layout.SPLITS).unlink(missing_ok=True)
    return head


def _write_all(out: Path, scenes: Sequence[Sequence[Entry]]) -> Iterator[WrittenScene]:
    """Write all scenes on several threads, and go through them in order."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with ThreadPoolExecutor(min(cores, _MOST_THREADS)) as pool:
        try:
            yield from pool.map(lambda item: _write_scene(out, *item), enumerate(scenes))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _check_out(out: Path, head: DatasetFile) -> None:
    """Refuse a folder with any other data set than an earlier conversion of the same folder."""
    if not (out / layout.DATASET).exists():
        return
    earlier, record = read_head(out).converted, head.converted
    assert record is not None
    if earlier is None or (earlier.layout, earlier.folder) != (record.layout, record.folder):
        found = "a rendered data set" if earlier is None else f"that of {earlier.folder} ({earlier.layout})"
        raise InputError(out, f"an empty folder or an earlier conversion of {record.folder}", found)


def _scenes(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Return the views of each scene, in the order of their first ones."""
    found: dict[str, list[Entry]] = {}
    for entry in entries:
        found.setdefault(entry.scene, []).append(entry)
    return list(found.values())


def _head(root: Path, found: Layout, collection: Collection, scenes: int) -> DatasetFile:
    versions = {package: metadata.version(package) for package in _PACKAGES}
    record = _conversion(root, found, collection, Counter(), 0, 0)
    head = new_head(root.resolve().name, 0, {}, versions, _NO_RENDERER, f"0:{scenes}", ())
    return head.model_copy(update={"converted": record})


def _conversion(
    root: Path, found: Layout, collection: Collection, counts: Counter[LabelKind], written: int, left_out: int
) -> Conversion:
    return Conversion(
        layout=found.name,
        title=found.title,
        folder=root.resolve().name,
        licence=found.licence,
        has={kind: counts[kind] for kind in LABEL_KINDS if counts[kind]},
        views=written,
        left_out=left_out,
        classes=collection.classes,
        notes=collection.notes,
    )


def _write_scene(out: Path, scene_id: int, entries: Sequence[Entry]) -> WrittenScene:
    """Write the views of a scene that can be read."""
    kinds: list[tuple[LabelKind, ...]] = []
    rows, damaged = [], []
    folder = layout.scene_folder(out, scene_id)
    with atomic_folder(folder) as partial:
        for entry in entries:
            check_stop()
            try:
                view = entry.read()
            except InputError as error:  # one damaged view does not end a conversion; it is counted and named
                damaged.append(LeftOut(entry.name, str(error)))
                continue
            number = len(kinds)
            labels = labels_record(entry.name, view)
            _write_view(partial / layout.view_name(number), view)
            write_json(partial / layout.view_name(number) / layout.LABELS, labels)
            rows.append(view_row(scene_id, number, view, labels))
            kinds.append(kinds_of(view))
        write_json(partial / layout.SCENE_VIEWS, SceneViews(views=tuple(rows), assets=()))
        write_checksums(partial)
    if not kinds:
        remove_folder(folder)
    return WrittenScene(tuple(kinds), tuple(damaged))


def _write_view(folder: Path, view: SourceView) -> None:
    folder.mkdir()
    write_json(folder / layout.CAMERA, camera_record(view))
    write_png(folder / "left.png", view.picture)
    if view.right is not None and view.camera.baseline is not None:
        write_png(folder / "right.png", view.right)
    channels = {} if view.Z is None else {"Z": view.Z}
    if view.normals is not None:
        channels |= unstacked(view.normals.astype("float16"), "N.XYZ")
    if channels:
        write_exr(folder / layout.GEOMETRY, channels)
    if view.sensor_Z is not None:
        write_exr(folder / layout.MEASURED_DEPTH, {"Z": view.sensor_Z})
    for name, values in ((layout.INSTANCES, view.instances), (layout.CLASSES, view.classes)):
        if values is not None:
            write_png(folder / name, values)


def _splits(found: dict[int, str | None]) -> SplitsFile:
    train, val, test = (tuple(scene for scene, split in found.items() if split == name) for name in get_args(Split))
    return SplitsFile(train=train, val=val, test=test, unseen_families=(), unseen_assets={})
