"""A data set's pictures by another camera: radiance that was rendered once, developed again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ...core.atomic_io import atomic_folder, remove_leftovers
from ...core.errors import InputError
from ...core.stopping import check_stop
from ...render.frame import EYES
from ..cameras.lens import check_distortion
from ..cameras.model import ColourCamera
from ..format import layout
from ..format.checksums import read_checksums, write_checksums
from ..format.dataset_file import DatasetFile, Development, read_head, write_head
from ..format.developed import optics_of, write_developed
from ..format.exr import channel, read_exr
from ..format.pictures import write_png
from ..format.raw_files import RAW_FILES
from ..output_checks import check_same_head
from ..preview.gallery import gallery
from ..reader import StoredScene, StoredView
from ..writer import finish_dataset
from .links import link, link_assets, link_tree
from .manifest import read_manifest, write_manifest

#: Files of a view that are written new.
_NEW = (*(f"{eye}.png" for eye in EYES), layout.CAMERA)


def developed_head(source: Path, root: Path, camera: ColourCamera, seed: int | None) -> DatasetFile:
    """Return the head of a data set whose pictures are to be developed; nothing is written.

    Parameters
    ----------
    source : Path
        A data set with radiance.
    root : Path
        Folder of the new one: absent, empty, or one that an earlier run of the same request has begun.
    camera : ColourCamera
        The camera.
    seed : int, optional
        Of its errors and noise; by default the data set's.

    Raises
    ------
    InputError
        Where the source has no radiance, the camera's distortion folds over in one of its views, or the new folder has
        other pictures.
    """
    head = read_head(source)
    if "radiance" not in head.files:
        raise _without_radiance(source)
    for view in _views(source):
        for eye in EYES:
            raw = [] if view.camera_record().sensitivities is None else [RAW_FILES[eye]]
            for name in (f"{eye}.exr", *raw):
                if not (view.folder / name).is_file():
                    raise _without_radiance(view.folder / name)
    for optics, width, height in {_lens_of(view) for view in _views(source)}:
        check_distortion(camera.distortion, optics, width, height, f"camera {camera.name}")
    development = Development(camera=camera, seed=head.seed if seed is None else seed)
    head = head.model_copy(update={"developed": development})
    if (root / layout.DATASET).exists():
        expected = "what an earlier run of this command began, or another --out"
        check_same_head(root / layout.DATASET, read_head(root), head, expected)
    return head


def develop_dataset(source: Path, root: Path, head: DatasetFile, on_scene: Callable[[int], None]) -> int:
    """Write a data set whose pictures are developed, with links to all else; return the number of views.

    Scenes that are there already are kept, so a run that was stopped can be repeated.

    Parameters
    ----------
    source : Path
        The data set, which does not change.
    root : Path
        The new one, locked (`output_folder.lock_output`).
    head : DatasetFile
        From `developed_head`.
    on_scene : callable
        Called with the number of each scene that is done.
    """
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)
    write_head(root, head)
    (root / layout.SCENES).mkdir(exist_ok=True)
    link_assets(source, root)
    manifest = read_manifest(source)
    if manifest is not None:
        write_manifest(root, manifest)
    if (source / layout.SPLITS).is_file() and not (root / layout.SPLITS).exists():
        link(source / layout.SPLITS, root / layout.SPLITS)
    for scene in layout.scene_ids(source):
        if not layout.scene_folder(root, scene).exists():
            _develop_scene(layout.scene_folder(source, scene), layout.scene_folder(root, scene), head, scene)
        on_scene(scene)
    views = finish_dataset(root)
    sheet = gallery(root)
    if sheet is not None:
        write_png(root / layout.PREVIEW, sheet)
    return views


def _develop_scene(source: Path, place: Path, head: DatasetFile, scene: int) -> None:
    development = head.developed
    if development is None:
        raise ValueError(f"{place}: expected the head of a developed data set")
    with atomic_folder(place) as partial, ThreadPoolExecutor() as pool:
        link_tree(source, partial, (*_NEW, layout.CHECKSUMS))
        # Streams belong to views, so the order of the threads does not matter.
        views = StoredScene(source, scene).views
        list(pool.map(lambda view: develop_view(view, partial, development, scene), views))
        sums = read_checksums(source).files
        write_checksums(partial, {name: item for name, item in sums.items() if Path(name).name not in _NEW})


def develop_view(view: StoredView, scene_folder: Path, development: Development, scene: int) -> None:
    """Write pictures and ``camera.json`` of a view by another camera, from its stored light.

    Parameters
    ----------
    view : StoredView
        The view, with radiance.
    scene_folder : Path
        Folder of the scene that gets them, which may be the view's own.
    development : Development
        The camera, and the seed of its errors and noise.
    scene : int
        Number of the scene.
    """
    check_stop()
    path = view.folder / layout.GEOMETRY
    Z = channel(read_exr(path), "Z", path)
    folder = scene_folder / layout.view_name(view.number)
    place, record = (scene, view.number), view.camera_record()
    sensor = record.sensitivities
    left, right = (view.radiance(eye) if sensor is None else view.raw(eye) for eye in EYES)
    devices = record.depth_camera, record.polarisation_camera
    write_developed(folder, view.camera(), (left, right), Z, development, place, *devices, sensor=sensor)


def _views(source: Path) -> Iterator[StoredView]:
    for scene in layout.scene_ids(source):
        yield from StoredScene(layout.scene_folder(source, scene), scene).views


def _lens_of(view: StoredView) -> tuple:
    camera = view.camera()
    return optics_of(camera), camera.width, camera.height


def _without_radiance(where: Path) -> InputError:
    expected = "a data set with radiance, which render-scene and build-dataset write with --write radiance"
    return InputError(where, expected, "one without")
