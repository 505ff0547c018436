"""Write a data set: its head, its scenes, its index.

`start_dataset` before the first scene, `scene_writer` for each, `finish_dataset` after the last. Each scene appears
whole or not at all, and the index is made from the scenes that are there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ..annotate.keypoints import SceneKeypoints
from ..annotate.labels import Labels
from ..annotate.mattes import Mattes
from ..annotate.stereo import StereoLabels
from ..core.assets import Asset
from ..core.atomic_io import atomic_folder, remove_leftovers
from ..core.errors import InputError, cause_of
from ..core.json_file import json_text
from ..core.margin import NO_MARGIN
from ..core.model import Model
from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene
from ..procedural.scene.scene_file import assets_of, save_checked_scene, stored_name
from ..procedural.surroundings.photometry import photometry
from ..render.frame import Frame, Geometry, LightCheck, SurfaceLight
from .format import layout
from .format.checksums import write_checksums
from .format.dataset_file import DatasetFile, PileCounts, counted_in, read_head, write_head
from .format.developed import development_of, write_developed
from .format.exr import half_numbers, unstacked, write_exr
from .format.file_kinds import KINDS, FileKinds
from .format.light_file import write_light
from .format.map_files import write_disparity, write_maps, write_pair
from .format.matte_files import write_mattes
from .format.objects_file import ObjectsFile, objects_file
from .format.pictures import stored_radiance, write_png
from .format.polarisation_files import write_polarisation
from .format.raw_files import sensor_colour, write_raw
from .format.ray_files import write_layers, write_refraction
from .format.sensor_files import write_sensor
from .format.views_table import SceneViews, ViewRow, read_scene_views, view_row, with_sensors, write_views_table
from .output_checks import check_output
from .settings.scene_ranges import format_scenes, parse_scenes


def start_dataset(root: Path, head: DatasetFile, scenes: Collection[int]) -> None:
    """Check and create the output folder; call this before anything is rendered.

    An existing data set keeps its head until `finish_dataset`: a run that is stopped before has changed nothing.

    Parameters
    ----------
    root : Path
        The output folder: absent, empty, or a data set to which scenes are added, or in which scenes are replaced.
    head : DatasetFile
        The new ``dataset.json``; `finish_dataset` fills in its assets.
    scenes : collection of int
        The scenes that this run will write.

    Raises
    ------
    InputError
        Where the folder holds anything else, or a data set with another seed or other settings that would keep some of
        its scenes. Nothing is changed then.
    """
    check_output(root, head, scenes)
    try:
        root.mkdir(parents=True, exist_ok=True)
        if not (root / layout.DATASET).exists():  # first: without it the folder is not recognised as a data set
            write_head(root, head)
        (root / layout.SCENES).mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(root, "a folder that can be created and written to", cause_of(error)) from error
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)


@contextmanager
def scene_writer(
    root: Path,
    scene: Scene,
    points: SceneKeypoints,
    check: LightCheck | None = None,
    light: SurfaceLight | None = None,
    files: FileKinds = KINDS,
) -> Iterator[SceneWriter]:
    """Open a scene's folder for writing; it appears whole at the end of the block, or not at all.

    Where anything is raised inside the block, Ctrl-C included, nothing is left of the folder.

    Parameters
    ----------
    root : Path
        The data set, started (`start_dataset`).
    scene : Scene
        The scene, which a renderer has checked (`check_scene`); a stored one with the same id is replaced.
    points : SceneKeypoints
        The keypoints that the views are labelled with.
    check : LightCheck, optional
        How pictures from the irradiance cache compare with path-traced ones.
    light : SurfaceLight, optional
        The irradiance cache, where it is to be kept (`picture.keep_light`).
    files : collection of str
        Files of each view beside those that every view has (`format.file_kinds`).
    """
    with atomic_folder(layout.scene_folder(root, scene.scene_id)) as folder:
        save_checked_scene(scene, folder / layout.SCENE, root / layout.ASSETS)
        records = objects_file(scene, points)
        write_json(folder / layout.OBJECTS, records)
        writer = SceneWriter(folder, scene, records, files)
        yield writer
        record = SceneViews(
            views=tuple(writer.rows),
            assets=_stored_assets(scene),
            light=check,
            photometry=photometry(scene.environment, scene.lights),
            rest=scene.rest,
        )
        if light is not None:
            write_light(folder / layout.LIGHT, light)
        write_json(folder / layout.SCENE_VIEWS, record)
        write_checksums(folder)


class SceneWriter:
    """Writes the views of one scene (`scene_writer`)."""

    def __init__(self, folder: Path, scene: Scene, records: ObjectsFile, files: FileKinds = KINDS) -> None:
        self._scene, self._files = scene, files
        self.folder = folder  #: of the scene, hidden until it is complete
        self.records = records  #: of the scene's objects
        self.rows: list[ViewRow] = []  #: of the index, one per view written

    def add(
        self, frame: Frame, labels: Labels, stereo: StereoLabels | None = None, mattes: Mattes | None = None
    ) -> np.ndarray:
        """Write all files of a view; return its left picture, (H, W, 3) uint8."""
        folder = self.folder / layout.view_name(frame.view)
        picture = write_view(folder, self._scene, frame, labels, self._files, stereo=stereo, mattes=mattes)
        self.rows.append(with_sensors(view_row(self._scene, frame.view, frame, labels), folder, frame.geometry))
        return picture


def finish_dataset(root: Path, head: DatasetFile | None = None) -> int:
    """Write the index, and the head with its lists of scenes and assets, from the scenes on disk.

    Memory use does not grow with the number of scenes.

    Parameters
    ----------
    root : Path
        The data set, with its scenes.
    head : DatasetFile, optional
        The head given to `start_dataset`; by default the one on disk.

    Returns
    -------
    int
        Number of views.
    """
    found: dict[str, Asset] = {}
    piles = PileCounts()

    def records() -> Iterator[SceneViews]:
        nonlocal piles
        for record in read_scene_views(root):
            found.update({item.sha256: item for item in record.assets})
            piles = counted_in(piles, record.rest)
            yield record

    count = write_views_table(root, records())
    assets = tuple(found[digest] for digest in sorted(found))
    head = _merged_head(read_head(root), head, layout.scene_ids(root))
    write_head(root, head.model_copy(update={"assets": assets, "piles": piles}))
    return count


def _merged_head(old: DatasetFile, head: DatasetFile | None, scenes: Collection[int]) -> DatasetFile:
    """Return the new head, listing the scenes on disk; with the same seed and settings it also keeps the old lists."""
    if head is None or (old.seed, old.config) == (head.seed, head.config):
        listed, hashes = parse_scenes(old.scenes, layout.DATASET), old.hashes
    else:
        listed, hashes = [], {}
    head = head or old
    return head.model_copy(update={"scenes": format_scenes({*listed, *scenes}), "hashes": hashes | head.hashes})


def _stored_assets(scene: Scene) -> tuple[Asset, ...]:
    return tuple(item.model_copy(update={"path": Path(layout.ASSETS, stored_name(item))}) for item in assets_of(scene))


def write_json(path: Path, record: Model) -> None:
    """Write a record as a JSON file."""
    path.write_text(json_text(record.model_dump(mode="json")), encoding="utf-8")


def write_view(
    folder: Path,
    scene: Scene,
    frame: Frame,
    labels: Labels,
    files: FileKinds = KINDS,
    stereo: StereoLabels | None = None,
    mattes: Mattes | None = None,
) -> np.ndarray:
    """Write the files of a view into a new folder; return its left picture, (H, W, 3) uint8.

    Parameters
    ----------
    folder : Path
        The view's folder.
    scene : Scene
        The scene.
    frame, labels : Frame, Labels
        The view, rendered and labelled.
    files : collection of str
        Kinds of files beside those that every view has.
    stereo : StereoLabels, optional
        What the right camera adds, for the kinds of files that hold it (`file_kinds.PAIR_KINDS`).
    mattes : Mattes, optional
        Soft mattes, where they are requested.
    """
    folder.mkdir()
    write_json(folder / layout.LABELS, labels)
    exposure = scene.cameras[frame.view].exposure
    for eye, picture, noisy in (("left", frame.left, frame.left_noisy), ("right", frame.right, frame.right_noisy)):
        channels = unstacked(stored_radiance(picture, exposure), "RGB") if "radiance" in files else {}
        if "noisy" in files and noisy is not None:
            channels |= unstacked(stored_radiance(noisy, exposure), "noisy.RGB")
        if channels:
            write_exr(folder / f"{eye}.exr", channels)
    depth_camera = write_sensor(folder, scene, frame, files)
    write_raw(folder, scene, frame, files)
    wide = frame.oversize
    seen = frame if wide is None else wide
    pair, Z = seen.raw or (seen.left, seen.right), frame.geometry.Z if wide is None else wide.Z
    left = write_developed(
        folder,
        scene.cameras[frame.view],
        pair,
        Z,
        development_of(scene),
        (scene.scene_id, frame.view),
        depth_camera,
        write_polarisation(folder, scene, frame),
        NO_MARGIN if wide is None else wide.margin,
        None if seen.raw is None else sensor_colour(scene),
    )
    write_exr(folder / layout.GEOMETRY, _channels(frame.geometry))
    write_png(folder / layout.INSTANCES, frame.geometry.id)
    if frame.layers is not None and "layers" in files:
        write_layers(folder / layout.LAYERS, frame.layers)
    if frame.refraction is not None and "refraction" in files:
        write_refraction(folder / layout.REFRACTION, frame.refraction)
    write_maps(folder, scene, frame, labels, files)
    if stereo is not None:
        _write_stereo(folder, scene.cameras[frame.view], frame.geometry, stereo, files)
    if mattes is not None:
        write_mattes(folder, scene, mattes)
    return left


def _write_stereo(folder: Path, camera: Camera, geometry: Geometry, stereo: StereoLabels, files: FileKinds) -> None:
    if "right-labels" in files:
        write_json(folder / layout.RIGHT_LABELS, stereo.labels)
        write_exr(folder / layout.RIGHT_GEOMETRY, _channels(stereo.geometry))
        write_png(folder / layout.RIGHT_INSTANCES, stereo.geometry.id)
    if "disparity" in files:
        write_disparity(folder / layout.DISPARITY, camera, geometry, stereo.geometry)
        write_pair(folder / layout.PAIR, stereo)


def _channels(geometry: Geometry) -> dict:
    return {
        "Z": geometry.Z,
        "background.Z": geometry.background_Z,
        "background.id": half_numbers(geometry.background_id, "background.id"),
        **unstacked(geometry.normal.astype(np.float16), "N.XYZ"),
        **unstacked(geometry.transmittance.astype(np.float16), "transmittance.RGB"),
    }
