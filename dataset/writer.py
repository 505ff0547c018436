"""Write a data set: its head, scene after scene, its index.

`start_dataset` before the first scene, `scene_writer` for each, `finish_dataset` after the last. Each scene appears
whole or not at all, and the index is made from the scenes that are there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..annotate.keypoints import SceneKeypoints
from ..annotate.labels import Labels
from ..core.assets import Asset
from ..core.atomic_io import another_writes, is_leftover, remove_leftovers, whole_folder, write_atomically
from ..core.errors import InputError
from ..core.json_file import check_schema, json_text, parsed, read_json
from ..core.model import Model
from ..procedural.description.scene import Scene
from ..procedural.description.surroundings import Camera
from ..procedural.scene.scene_file import assets_of, save_scene, stored_name
from ..render.frame import Frame, Geometry, LightCheck, SurfaceLight
from .format import layout
from .format.camera_file import camera_file
from .format.checksums import write_checksums
from .format.dataset_file import DatasetFile
from .format.exr import unstacked, write_exr
from .format.light_file import write_light
from .format.objects_file import objects_file
from .format.pictures import srgb8, write_png
from .format.ray_files import write_layers, write_refraction
from .format.views_table import SceneViews, ViewRow, read_scene_views, view_row, write_views_table
from .settings.scene_ranges import format_scenes, parse_scenes


def start_dataset(root: Path, head: DatasetFile, scenes: Collection[int]) -> None:
    """Make an output folder ready; call it before anything is rendered.

    A data set that is there keeps its head until `finish_dataset`: what is stopped before then has changed nothing.

    Parameters
    ----------
    root : Path
        The output folder: absent, empty, or a data set of which scenes are to be added or replaced.
    head : DatasetFile
        What ``dataset.json`` will say; its assets are filled in by `finish_dataset`.
    scenes : collection of int
        The scenes that this run will write.

    Raises
    ------
    InputError
        Where the folder holds anything else, or a data set with another seed or other settings that would keep some of
        its scenes. Nothing is touched then.
    """
    check_output(root, head, scenes)
    try:
        root.mkdir(parents=True, exist_ok=True)
        if not (root / layout.DATASET).exists():  # first of all: without it the folder is nobody's
            write_head(root, head)
        (root / layout.SCENES).mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(root, "a folder that can be made and written to", error.strerror) from error
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)


def check_output(root: Path, head: DatasetFile, scenes: Collection[int]) -> None:
    """Raise InputError where `start_dataset` would, without touching anything; the parameters are the same."""
    if root.exists():
        check_folder(root)
    others = set(layout.scene_ids(root)) - set(scenes) or another_writes(root / layout.SCENES)
    if (root / layout.DATASET).exists() and others:
        _check_same(root / layout.DATASET, read_head(root), head)


@contextmanager
def scene_writer(
    root: Path,
    scene: Scene,
    points: SceneKeypoints,
    check: LightCheck | None = None,
    light: SurfaceLight | None = None,
) -> Iterator[SceneWriter]:
    """Open a scene's folder for writing; it appears whole at the end of the block, or not at all.

    Where anything is raised inside the block, Ctrl-C included, nothing is left of the folder.

    Parameters
    ----------
    root : Path
        The data set, started (`start_dataset`).
    scene : Scene
        The scene; a stored one with the same id is replaced.
    points : SceneKeypoints
        The keypoints that the views are labelled with.
    check : LightCheck, optional
        How pictures from the irradiance cache compare with path-traced ones.
    light : SurfaceLight, optional
        The irradiance cache, where it is to be kept (`picture.keep_light`).
    """
    with whole_folder(layout.scene_folder(root, scene.scene_id)) as folder:
        save_scene(scene, folder / layout.SCENE, root / layout.ASSETS)
        write_json(folder / layout.OBJECTS, objects_file(scene, points))
        writer = SceneWriter(folder, scene)
        yield writer
        record = SceneViews(views=tuple(writer.rows), assets=_stored_assets(scene), light=check)
        if light is not None:
            write_light(folder / layout.LIGHT, light)
        write_json(folder / layout.SCENE_VIEWS, record)
        write_checksums(folder)


class SceneWriter:
    """Writes the views of one scene (`scene_writer`)."""

    def __init__(self, folder: Path, scene: Scene) -> None:
        self._folder, self._scene = folder, scene
        self.rows: list[ViewRow] = []  #: of the index, one per view written

    def add(self, frame: Frame, labels: Labels) -> None:
        """Write all files of a view."""
        view = frame.view
        write_view(self._folder / layout.view_name(view), self._scene.cameras[view], frame, labels)
        self.rows.append(view_row(self._scene, view, frame, labels))


def finish_dataset(root: Path, head: DatasetFile | None = None) -> int:
    """Write the index, and the head with its lists of scenes and assets, from the scenes that are there.

    What is held in memory at once does not grow with the number of scenes.

    Parameters
    ----------
    root : Path
        The data set, with its scenes.
    head : DatasetFile, optional
        The head given to `start_dataset`; by default the one that is there.

    Returns
    -------
    int
        Number of views.
    """
    found: dict[str, Asset] = {}

    def records() -> Iterator[SceneViews]:
        for record in read_scene_views(root):
            found.update({item.sha256: item for item in record.assets})
            yield record

    count = write_views_table(root, records())
    assets = tuple(found[digest] for digest in sorted(found))
    head = _grown(read_head(root), head, layout.scene_ids(root))
    write_head(root, head.model_copy(update={"assets": assets}))
    return count


def _grown(kept: DatasetFile, head: DatasetFile | None, there: Collection[int]) -> DatasetFile:
    """Return the new head with the scenes that are there and, if it is of the same make, all that the kept one says."""
    if head is None or (kept.seed, kept.config) == (head.seed, head.config):
        promised, hashes = parse_scenes(kept.scenes, layout.DATASET), kept.hashes
    else:
        promised, hashes = [], {}
    head = head or kept
    return head.model_copy(update={"scenes": format_scenes({*promised, *there}), "hashes": hashes | head.hashes})


def read_head(root: Path) -> DatasetFile:
    """Read ``dataset.json``; InputError where it is missing, damaged, or of an unknown schema."""
    path = root / layout.DATASET
    data = read_json(path)
    check_schema(path, data, layout.DATASET_SCHEMA)
    return parsed(DatasetFile, data, path)


def _stored_assets(scene: Scene) -> tuple[Asset, ...]:
    return tuple(item.model_copy(update={"path": Path(layout.ASSETS, stored_name(item))}) for item in assets_of(scene))


def check_folder(root: Path) -> None:
    """Raise InputError where a folder holds anything but a data set that this version reads."""
    if not root.is_dir():
        raise InputError(root, "a folder to write to", "a file")
    names = {entry.name for entry in root.iterdir() if entry.name != layout.LOCK and not is_leftover(entry.name)}
    if names and layout.DATASET not in names:
        raise InputError(root, "an empty folder or a glassware data set", f"something else ({min(names)}, ...)")
    if names:
        read_head(root)


def _check_same(path: Path, kept: DatasetFile, head: DatasetFile) -> None:
    where = f"{path}: a scene that this run does not replace was made with another"
    if kept.seed != head.seed:
        raise InputError(f"{where} seed", str(head.seed), kept.seed)
    for name, asked, found in differences(head.config, kept.config):
        raise InputError(f"{where} setting {name}", str(asked), found)


def differences(asked: Any, found: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Go through the dotted name and both values of each setting that differs."""
    if isinstance(asked, dict) and isinstance(found, dict):
        for key in sorted({*asked, *found}):
            yield from differences(asked.get(key), found.get(key), f"{name}.{key}" if name else key)
    elif asked != found:
        yield name, asked, found


def write_head(root: Path, head: DatasetFile) -> None:
    """Write ``dataset.json``."""
    write_atomically(root / layout.DATASET, json_text(head.model_dump(mode="json")).encode())


def write_json(path: Path, record: Model) -> None:
    """Write a record as a JSON file."""
    path.write_text(json_text(record.model_dump(mode="json")), encoding="utf-8")


def write_view(folder: Path, camera: Camera, frame: Frame, labels: Labels) -> None:
    """Write all files of a view into a new folder."""
    folder.mkdir()
    write_json(folder / layout.CAMERA, camera_file(camera))
    write_json(folder / layout.LABELS, labels)
    for eye, picture, noisy in (("left", frame.left, frame.left_noisy), ("right", frame.right, frame.right_noisy)):
        channels = unstacked(picture, "RGB") | ({} if noisy is None else unstacked(noisy, "noisy.RGB"))
        write_exr(folder / f"{eye}.exr", channels)
        write_png(folder / f"{eye}.png", srgb8(picture, camera.exposure))
    write_exr(folder / layout.GEOMETRY, _channels(frame.geometry))
    write_png(folder / layout.INSTANCES, frame.geometry.id)
    if frame.layers is not None:
        write_layers(folder / layout.LAYERS, frame.layers)
    if frame.refraction is not None:
        write_refraction(folder / layout.REFRACTION, frame.refraction)


def _channels(geometry: Geometry) -> dict:
    return {
        "Z": geometry.Z,
        "background.Z": geometry.background_Z,
        "background.id": geometry.background_id,
        **unstacked(geometry.normal, "N.XYZ"),
        **unstacked(geometry.transmittance, "transmittance.RGB"),
    }
