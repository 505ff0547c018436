"""Views made a second time, from the seed to the last file, and compared bit for bit with those that are stored."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...annotate.keypoints import scene_keypoints
from ...annotate.labels import label
from ...core.errors import InputError
from ...core.margin import NO_MARGIN
from ...procedural.scene.draw import draw_scene
from ...procedural.scene.scene_file import load_scene, save_scene
from ...procedural.scene.settings import SceneSettings
from ...render.backend.variant import activate
from ...render.renderer import Renderer
from ..format import layout
from ..format.dataset_file import DatasetFile, installed_versions
from ..format.developed import margin_of
from ..pipeline import pair_labels, requested_mattes
from ..stored_view import StoredView
from ..writer import write_view
from .development import develop_view


def ready(root: Path, head: DatasetFile) -> None:
    """Set the data set's backend; InputError where bits cannot be compared, because something else made them."""
    if head.converted is not None:
        raise InputError("--rerender", "a rendered data set", f"one that was converted from {head.converted.title}")
    activate(head.backend)
    here = installed_versions()
    for name, version in head.versions.items():
        if here.get(name) != version:
            where = f"{root / layout.DATASET}: versions.{name}"
            raise InputError(where, f"{here.get(name)}, which is here, to compare bits", version)


def chosen(root: Path, count: int, rng: np.random.Generator) -> dict[int, list[int]]:
    """Return that many random views, by scene; all where there are fewer."""
    views = [
        (scene, view)
        for scene in layout.scene_ids(root)
        for view in layout.view_numbers(layout.scene_folder(root, scene))
    ]
    picked = sorted(views[i] for i in rng.permutation(len(views))[:count])
    return {scene: [view for owner, view in picked if owner == scene] for scene, _ in picked}


def rerendered(root: Path, head: DatasetFile, scene_id: int, views: list[int]) -> Iterator[str]:
    """Go through the files of a scene, and of some of its views, that are not the same when they are made again.

    The description is drawn from the seed where the folders of its assets are there; views are rendered from the
    description that is stored.
    """
    folder = layout.scene_folder(root, scene_id)
    with tempfile.TemporaryDirectory(prefix="glassware-verify-") as name:
        again = layout.scene_folder(Path(name), scene_id)
        again.mkdir(parents=True)
        settings = SceneSettings.model_validate(head.config)
        # A data set without settings was written from Python: its scenes cannot be drawn again.
        if head.config and _folders_are_there(settings):
            drawn = draw_scene(settings, head.seed, scene_id)
            save_scene(drawn, again / layout.SCENE, Path(name, layout.ASSETS))
            yield from _unlike(again, folder)
        scene = load_scene(folder / layout.SCENE)
        renderer, points = Renderer(scene), scene_keypoints(scene)
        for view in views:
            margin = margin_of(scene, view) if head.developed is None else NO_MARGIN
            place, frame = again / layout.view_name(view), renderer.frame(view, margin)
            labels, stereo = label(scene, frame, renderer, points), pair_labels(head.files, frame, renderer, points)
            mattes = requested_mattes(head.files, frame, renderer)
            write_view(place, scene, frame, labels, head.files, stereo, mattes)
            if head.developed is not None:  # of radiance as it is stored, like the pictures that it is compared with
                develop_view(StoredView(place, view), again, head.developed, scene_id)
            yield from _unlike(place, folder / layout.view_name(view))


def _folders_are_there(settings: SceneSettings) -> bool:
    light = settings.environment
    folders = (light.hdri_dir, light.texture_dir, settings.mesh_dir, settings.texture_dir, settings.table.texture_dir)
    poses, vessels = settings.cameras.poses, settings.vessel_dir
    there = all(folder is None or folder.exists() for folder in folders) and (vessels is None or vessels.exists())
    return there and (poses is None or poses.is_file())


def _unlike(again: Path, stored: Path) -> Iterator[str]:
    for path in sorted(again.rglob("*")):
        twin = stored / path.relative_to(again)
        if path.is_file() and not (twin.is_file() and twin.read_bytes() == path.read_bytes()):
            yield f"{twin}: expected the bytes that are made here and now, found others"
