"""All checks of the labels of a stored scene."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...core.user_text import counted
from ...procedural.description.scene import Scene
from ..format import layout
from ..format.objects_file import ObjectsFile
from ..format.views_table import ViewRow, scene_views
from ..reader import StoredScene
from ..stored_view import StoredView
from .description import media_faults, object_faults
from .fault import Fault, unlike
from .sensor_rows import sensor_row_faults
from .triangles import triangles_of
from .view import ViewChecks

#: Faults that an error names.
_SHOWN = 5


def scene_label_faults(root: Path, scene_id: int, developed: bool = False) -> Iterator[str]:
    """Yield the faults of a scene's labels, one line each, found from its files alone.

    Parameters
    ----------
    root : Path
        The data set.
    scene_id : int
        The scene.
    developed : bool
        Whether its pictures were taken by a camera with noise and processing.
    """
    stored = StoredScene(layout.scene_folder(root, scene_id), scene_id)
    scene, records = stored.scene(), stored.objects()
    found = object_faults(scene, records, layout.OBJECTS)
    yield from _lines(stored.folder, found)
    points = {"object points"} if found else set()
    yield from _lines(stored.folder, media_faults(scene, records, layout.OBJECTS))
    triangles = triangles_of(scene)
    rows = {row.view: row for row in scene_views(root, scene_id).views}
    developed = developed or scene.picture.camera != "ideal"
    for view in stored.views:
        checks = ViewChecks(view, scene, records, triangles, developed, wrong=set(points))
        yield from _lines(view.folder, checks.run())
        if not checks.wrong & {"objects", "counts", "fractions"}:
            yield from _lines(stored.folder, row_faults(rows[view.number], scene, view))
        if not checks.wrong & {"sensor", "polarisation", "ids", "depth"}:
            yield from _lines(stored.folder, sensor_row_faults(rows[view.number], view))


class WrongLabelError(RuntimeError):
    """Labels that contradict each other: a fault of this program, and not of its user."""


def check_written(view: StoredView, scene: Scene, records: ObjectsFile) -> None:
    """Check the files of a view that was just written against each other; the meshes are not looked at.

    Parameters
    ----------
    view : StoredView
        The view.
    scene : Scene
        Its scene.
    records : ObjectsFile
        What ``objects.json`` holds.

    Raises
    ------
    WrongLabelError
        Where a label contradicts another one or the description.
    """
    found = ViewChecks(view, scene, records, None, developed=scene.picture.camera != "ideal").run()
    if found:
        lines = "; ".join(str(fault) for fault in found[:_SHOWN])
        raise WrongLabelError(f"view {view.number} has {counted(len(found), 'wrong label')}: {lines}")


def row_faults(row: ViewRow, scene: Scene, view: StoredView) -> list[Fault]:
    """Compare a view's row of the index with its labels."""
    labels, where = view.labels(), f"view {view.number}"
    expected = {
        "vessels": len(scene.vessels),
        "props": len(scene.props),
        "object_ids": [label.id for label in labels.objects],
        "visible_pixels": [label.pixels.visible for label in labels.objects],
        "visible_fractions": [label.fractions and label.fractions.visible for label in labels.objects],
        "seen_through_fractions": [label.fractions and label.fractions.seen_through for label in labels.objects],
    }
    found: list[Fault] = []
    for name, value in expected.items():
        stored = getattr(row, name)
        plain = [*stored] if isinstance(stored, tuple) else stored
        found += unlike("index", layout.SCENE_VIEWS, f"{where} {name}", str(value), str(plain))
    return found


def _lines(folder: Path, faults: list[Fault]) -> Iterator[str]:
    yield from (f"{folder / fault.file}: {str(fault).removeprefix(f'{fault.file}: ')}" for fault in faults)
