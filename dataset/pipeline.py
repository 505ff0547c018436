"""From a description to files: load, light, and for each view a frame, its labels and its files.

`render-scene`, the workers of a build and `glassware.write` run the same loop, so a scene has the same bytes by any of
them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from ..annotate.keypoints import SceneKeypoints, scene_keypoints
from ..annotate.labels import label
from ..annotate.mattes import Mattes, soft_mattes
from ..annotate.stereo import StereoLabels, stereo_labels
from ..core.arguments import as_path, check_type
from ..core.errors import InputError
from ..core.stopwatch import Stopwatch
from ..procedural.description.scene import Scene
from ..procedural.scene.scene_file import load_scene, scene_digest
from ..render.frame import Frame, LightCheck
from ..render.renderer import Renderer
from .format import layout
from .format.dataset_file import installed_versions, new_head
from .format.developed import margin_of
from .format.file_kinds import KINDS, NONE, PAIR_KINDS, FileKinds, parse_kinds
from .format.pictures import write_png
from .format.views_table import ViewRow
from .preview.contact_sheet import PreviewRow, chosen_views, contact_sheet
from .preview.sensor_cells import SensorPreview
from .stored_view import StoredView
from .verification.scene import check_written
from .writer import finish_dataset, scene_writer, start_dataset


@dataclass(frozen=True, eq=False)
class WrittenScene:
    """What was written of a scene."""

    rows: list[ViewRow]  #: of the index
    previews: list[PreviewRow]  #: of the views of the contact sheet
    check: LightCheck | None  #: of the irradiance cache; None where paths are traced


def _ignore(_: object) -> None:
    """Do nothing with an event."""


def write_scene(
    root: Path,
    renderer: Renderer,
    stopwatch: Stopwatch,
    on_view: Callable[[int], None] = _ignore,
    previews: Collection[int] = (),
    files: FileKinds = KINDS,
) -> WrittenScene:
    """Render, label and write a scene view by view; its folder appears after the last one.

    Parameters
    ----------
    root : Path
        The data set, started (`writer.start_dataset`).
    renderer : Renderer
        The loaded scene.
    stopwatch : Stopwatch
        Counts the seconds of each stage.
    on_view : callable
        Called with the number of each view after it was rendered and labelled; it may raise to stop the work.
    previews : collection of int
        Views of the contact sheet.
    files : tuple of str
        Files of each view beside those that every view has (`format.file_kinds`).
    """
    scene = renderer.scene
    stopwatch.add(renderer.seconds)
    points, shown = scene_keypoints(scene), []
    light = renderer.surface_light() if scene.picture.keep_light else None
    with scene_writer(root, scene, points, renderer.light_check, light, files) as writer:
        for view in range(len(scene.cameras)):
            frame = renderer.frame(view, margin_of(scene, view))
            stopwatch.add(frame.seconds)
            with stopwatch.stage("labels"):
                labels = label(scene, frame, renderer, points)
                stereo = pair_labels(files, frame, renderer, points)
                mattes = requested_mattes(files, frame, renderer)
            on_view(view)
            with stopwatch.stage("writing"):
                picture = writer.add(frame, labels, stereo, mattes)
            with stopwatch.stage("checking"):
                stored = StoredView(writer.folder / layout.view_name(view), view)
                check_written(stored, scene, writer.records)
            if view in previews:
                sensor = sensor_preview(stored)
                stokes = None if frame.stokes is None else frame.stokes.vector
                name, camera = layout.view_name(view), scene.cameras[view]
                shown.append(PreviewRow(name, picture, camera, frame.geometry, labels, sensor, stokes))
    return WrittenScene(writer.rows, shown, renderer.light_check)


def sensor_preview(view: StoredView) -> SensorPreview | None:
    """Return what the contact sheet shows of a view's depth camera; None where it has none."""
    device = view.depth_camera()
    if device is None:
        return None
    infrared = view.infrared() if (view.folder / layout.IR_LEFT).is_file() else None
    return SensorPreview(view.sensor_depth(), view.sensor_valid(), device.reasons, infrared)


def pair_labels(files: FileKinds, frame: Frame, renderer: Renderer, points: SceneKeypoints) -> StereoLabels | None:
    """Return what the right camera adds to a view's labels; None where no file of the requested kinds has it."""
    if not set(PAIR_KINDS) & set(files):
        return None
    return stereo_labels(renderer.scene, frame, renderer, points)


def requested_mattes(files: FileKinds, frame: Frame, renderer: Renderer) -> Mattes | None:
    """Return the soft mattes of a view; None where they are not requested."""
    return soft_mattes(renderer, frame.view) if "mattes" in files else None


def write(
    out: Path | str,
    scene: Scene,
    renderer: Renderer | None = None,
    name: str = "glassware",
    replace: bool = False,
    files: str | Sequence[str] = NONE,
) -> None:
    """Write a scene as a data set of one, with its index and contact sheet: what ``render-scene`` writes.

    The same scene may be written again. Another scene of the same number is replaced only where `replace` says so.

    The head (``dataset.json``) has no settings, since a scene may have been put together or changed in Python.

    Parameters
    ----------
    out : Path or str
        Folder of the data set: absent, empty, or a data set with the same seed and settings.
    scene : Scene
        The scene.
    renderer : Renderer, optional
        One that was made of this scene; a new one by default.
    name : str
        Name of the data set.
    replace : bool
        Whether to replace another scene of the same number in the data set.
    files : str or sequence of str
        Files of each view beside pictures, depth, normals, ids, camera and labels, such as ``"layers"``, or ``"all"``,
        or ``"none"`` (`format.file_kinds` has what there is).

    Raises
    ------
    InputError
        Where the folder holds something else or another scene, or the renderer was made of another scene.
    """
    root = as_path("write: out", out)
    check_type("write: scene", scene, Scene, "a Scene")
    check_type("write: renderer", renderer, (Renderer, type(None)), "a Renderer, or None for a new one")
    check_type("write: name", name, str, "a text")
    kinds = _checked_kinds(files)
    if not replace:
        _check_not_another(root, scene)
    renderer = renderer or Renderer(scene)
    if scene is not renderer.scene:
        raise InputError("write", f"the renderer's own scene, {renderer.scene!r}", f"another one, {scene!r}")
    head = new_head(name, scene.seed, {}, installed_versions(), renderer.variant, files=kinds)
    start_dataset(root, head, [scene.scene_id])
    written = write_scene(root, renderer, Stopwatch(), previews=chosen_views(len(scene.cameras)), files=kinds)
    finish_dataset(root, head)
    write_png(root / layout.PREVIEW, contact_sheet(f"seed {scene.seed}, scene {scene.scene_id}", written.previews))


def _checked_kinds(files: object) -> FileKinds:
    try:
        return cast(FileKinds, parse_kinds(files))
    except ValueError as error:
        expected, _, found = str(error).removeprefix("expected ").rpartition(", found ")
        raise InputError("write: files", expected, found) from error


def _check_not_another(root: Path, scene: Scene) -> None:
    """Refuse a data set that has another scene of this scene's number, or one that cannot be read."""
    folder = layout.scene_folder(root, scene.scene_id)
    if not folder.exists():
        return
    try:
        same = scene_digest(load_scene(folder / layout.SCENE)) == scene_digest(scene)
    except InputError:
        same = False
    if not same:
        expected = "a folder without another scene of this number; write to another folder, or pass replace=True"
        raise InputError(root, expected, f"another scene {scene.scene_id}")
