"""Faults of a data set, found from its files alone: schema, completeness, checksums, index, labels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import zip_longest
from pathlib import Path
from typing import get_args

import pyarrow.parquet as pq
from pyarrow import ArrowException
from pydantic import ValidationError

from ...core.assets import checked_path
from ...core.errors import InputError
from ...core.setting_errors import setting_error
from ...core.user_text import counted
from ...procedural.description.depth_camera import DepthCamera
from ...procedural.description.picture import Picture
from ...procedural.description.scene import Scene
from ...procedural.description.time_of_flight import DepthDevice
from ...procedural.scene.settings import SceneSettings
from ...procedural.scene.splits import Split, split_of
from ...render.frame import EYES
from ..format import layout
from ..format.checksums import faults_of
from ..format.dataset_file import DatasetFile, digest_of
from ..format.file_kinds import LAYERED, FileKinds
from ..format.raw_files import RAW_FILES
from ..format.sensor_files import IR_FILES
from ..format.split_file import read_splits
from ..format.views_table import SCHEMA, read_scene_views, scene_views
from ..reader import StoredScene, StoredView
from ..settings.scene_ranges import format_scenes, parse_scenes
from ..verification.converted import converted_label_faults, converted_scene_faults
from ..verification.scene import scene_label_faults
from .manifest import read_manifest

#: Files of the kinds that need nothing of the scene's picture, or its layers (`LAYERED`).
REQUESTED = {
    "right-labels": (layout.RIGHT_LABELS, layout.RIGHT_GEOMETRY, layout.RIGHT_INSTANCES),
    "disparity": (layout.DISPARITY, layout.PAIR),
    "heatmap": (layout.HEATMAP,),
    "coordinates": (layout.COORDINATES,),
    "vessel-parts": (layout.VESSEL_PARTS,),
    "mattes": (layout.MATTES, layout.CRYPTOMATTE),
}
#: Files of views with a polarisation camera.
_STOKES_FILES = (layout.STOKES, layout.DOLP, layout.AOLP, layout.MOSAIC)
#: Files that each view has, whatever was requested.
_VIEW_FILES = (
    layout.CAMERA,
    layout.LABELS,
    layout.INSTANCES,
    layout.GEOMETRY,
    *(f"{eye}.png" for eye in EYES),
)


def head_faults(root: Path, head: DatasetFile) -> Iterator[str]:
    """Yield the faults outside the scenes: hashes, missing scenes, assets, splits."""
    path = root / layout.DATASET
    hashed = {"config": head.config, "backend": {"backend": head.backend, "versions": head.versions}}
    for name, data in hashed.items():
        if name in head.hashes and head.hashes[name] != digest_of(data):
            yield f"{path}: expected the {name} of the stored hash, found another"
    yield from _manifest_faults(root, head)
    listed, existing = set(parse_scenes(head.scenes, str(path))), set(layout.scene_ids(root))
    if listed - existing:
        yield f"{root / layout.SCENES}: expected scenes {head.scenes}, found {format_scenes(listed - existing)} missing"
    if existing - listed:
        yield f"{path}: expected all scenes in its list, found {format_scenes(existing - listed)} beside it"
    yield from _unknown_entries(root / layout.SCENES)
    for item in head.assets:
        try:
            checked_path(item.model_copy(update={"path": root / item.path}))
        except InputError as error:
            yield str(error)
    if head.converted is None and ((root / layout.SPLITS).exists() or (root / layout.LOG).exists()):
        yield from _with_read_errors(lambda: _split_faults(root, head, existing))


def scene_faults(root: Path, head: DatasetFile, scene_id: int) -> Iterator[str]:
    """Yield the faults of one scene: its files against their checksums, and each file against its schema."""
    folder = layout.scene_folder(root, scene_id)
    damaged = list(faults_of(folder))
    yield from damaged
    if damaged:  # the content of a damaged file means nothing
        return
    stored = StoredScene(folder, scene_id)
    if head.converted is not None:
        yield from _with_read_errors(lambda: converted_scene_faults(stored))
    else:
        yield from _with_read_errors(lambda: _content_faults(root, head, stored))


def label_faults(root: Path, scene_id: int, head: DatasetFile) -> Iterator[str]:
    """Yield the faults that `dataset.verification` finds in the labels of one scene, from the stored files alone."""
    if head.converted is not None:
        yield from _with_read_errors(lambda: converted_label_faults(root, scene_id))
    else:
        yield from _with_read_errors(lambda: scene_label_faults(root, scene_id, head.developed is not None))


def index_faults(root: Path) -> Iterator[str]:
    """Yield the faults of ``views.parquet`` against the records of the scenes; rows are read in batches."""
    path = root / layout.VIEWS
    try:
        with pq.ParquetFile(path) as file:
            if not file.schema_arrow.equals(SCHEMA):
                yield f"{path}: expected the columns of this version, found others"
                return
            rows = (row for batch in file.iter_batches() for row in batch.to_pylist())
            # dict() has the columns that files leave out as well, as the table has them.
            records = (dict(row) for record in read_scene_views(root) for row in record.views)
            for found, expected in zip_longest(rows, records):
                if found != _with_lists(expected):
                    yield f"{path}: expected {_row_name(expected)}, found {_row_name(found)}"
                    return
    except (OSError, ArrowException, InputError) as error:
        yield f"{path}: expected an index of all views, found {' '.join(str(error).split())}"


def _unknown_entries(scenes: Path) -> Iterator[str]:
    """Yield what is not a scene; hidden folders are incomplete scenes and count as absent."""
    known = {layout.scene_name(scene) for scene in layout.scene_ids(scenes.parent)}
    for path in sorted(scenes.iterdir()) if scenes.is_dir() else ():
        if path.name not in known and not path.name.startswith("."):
            yield f"{path}: expected only folders of scenes, found this one"


def _manifest_faults(root: Path, head: DatasetFile) -> Iterator[str]:
    if "assets" not in head.hashes:  # render-scene writes no manifest
        return
    try:
        manifest = read_manifest(root)
    except InputError as error:
        yield str(error)
        return
    if manifest is None or digest_of(manifest.model_dump(mode="json")) != head.hashes["assets"]:
        found = "none" if manifest is None else "another"
        yield f"{root / layout.MANIFEST}: expected the manifest whose hash {layout.DATASET} has, found {found}"


def _split_faults(root: Path, head: DatasetFile, existing: set[int]) -> Iterator[str]:
    splits, path = read_splits(root), root / layout.SPLITS
    settings = SceneSettings.model_validate(head.config)
    listed = {scene: name for name in get_args(Split) for scene in getattr(splits, name)}
    for scene in sorted(existing):
        expected = split_of(settings.splits, head.seed, scene)
        if listed.get(scene) != expected:
            yield f"{path}: expected scene {scene} in {expected}, found it in {listed.get(scene, 'none')}"


def _content_faults(root: Path, head: DatasetFile, stored: StoredScene) -> Iterator[str]:
    scene, where = stored.scene(), stored.folder / layout.SCENE
    if (scene.seed, scene.scene_id) != (head.seed, stored.scene_id):
        yield f"{where}: expected scene {stored.scene_id} of seed {head.seed}, found {scene.scene_id} of {scene.seed}"
    objects = stored.objects()
    if [item.id for item in objects.objects] != [item.id for item in scene.objects]:
        yield f"{stored.folder / layout.OBJECTS}: expected the objects of {layout.SCENE}, found others"
    numbers = [row.view for row in scene_views(root, stored.scene_id).views]
    if not [view.number for view in stored.views] == numbers == list(range(len(scene.cameras))):
        expected = counted(len(scene.cameras), "view")
        yield f"{stored.folder}: expected {expected}, found {[view.number for view in stored.views]}"
        return
    for view in stored.views:
        yield from _view_faults(scene, view, head.files)


def _view_faults(scene: Scene, view: StoredView, files: FileKinds) -> Iterator[str]:
    sensor = _sensor_files(files, scene.depth_camera)
    stokes = () if scene.polarisation_camera is None else _STOKES_FILES
    raw = RAW_FILES.values() if scene.sensitivities is not None and "radiance" in files else ()
    for name in (*_VIEW_FILES, *_extra_files(scene.picture, files), *raw, *sensor, *stokes):
        if not (view.folder / name).is_file():
            yield f"{view.folder / name}: expected a file, found none"
            return
    if view.camera().model_dump_json() != scene.cameras[view.number].model_dump_json():
        yield f"{view.folder / layout.CAMERA}: expected camera {view.number} of {layout.SCENE}, found another"
    if [label.id for label in view.labels().objects] != [item.id for item in scene.objects]:
        yield f"{view.folder / layout.LABELS}: expected labels of all objects, found others"


def _extra_files(picture: Picture, files: FileKinds) -> Iterator[str]:
    """Yield the files that a view has because they were requested."""
    if "radiance" in files or ("noisy" in files and picture.denoise):
        yield from (f"{eye}.exr" for eye in EYES)
    if "layers" in files and picture.layers:
        yield layout.LAYERS
    if "refraction" in files and picture.refraction:
        yield layout.REFRACTION
    for kind, names in REQUESTED.items():
        if kind in files and (kind not in LAYERED or picture.layers):
            yield from names


def _sensor_files(files: FileKinds, device: DepthDevice | None) -> tuple[str, ...]:
    """Return the files that a view has by its depth camera."""
    if device is None:
        return ()
    always = (layout.SENSOR_DEPTH, layout.SENSOR_VALID)
    stereo = "infrared" in files and isinstance(device, DepthCamera)
    return (*always, *IR_FILES.values()) if stereo else always


def _with_read_errors(check: Callable[[], Iterator[str]]) -> Iterator[str]:
    """Yield faults; a file that cannot be read is one."""
    try:
        yield from check()
    except InputError as error:
        yield str(error)
    except ValidationError as error:
        yield str(setting_error(f"{layout.DATASET}: config", error))


def _with_lists(row: dict | None) -> dict | None:
    """Return a row with lists in place of tuples, as Parquet returns them."""
    if row is None:
        return None
    return {name: list(value) if isinstance(value, tuple) else value for name, value in row.items()}


def _row_name(row: dict | None) -> str:
    return "no more views" if row is None else f"view {row['view']} of scene {row['scene_id']} with its values"
