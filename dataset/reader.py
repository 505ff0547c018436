"""Read a data set as the typed data that it was written from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import get_args

import pyarrow as pa
import pyarrow.parquet as pq

from ..core.arguments import as_path, check_type, described, one_of, whole_number
from ..core.errors import InputError
from ..core.html import html_images
from ..core.json_file import read_record
from ..core.setting_errors import suggest
from ..core.user_text import counted
from ..procedural.description.scene import Scene
from ..procedural.scene.scene_file import load_scene
from ..procedural.scene.splits import Split
from ..procedural.surroundings.photometry import Photometry
from ..render.frame import Eye as Eye
from ..render.frame import SurfaceLight
from .format import layout
from .format.dataset_file import DatasetFile, read_head
from .format.light_file import read_light
from .format.objects_file import OBJECTS_SCHEMA, ObjectsFile
from .format.scene_outline import SceneOutline, read_outline
from .format.split_file import read_splits
from .format.views_table import scene_views
from .preview.gallery import gallery
from .stored_view import StoredView as StoredView

#: Largest number of a scene: as folders have six digits or more, and names have an end.
MOST_SCENE = 10**12


@dataclass(frozen=True)
class StoredScene:
    """A scene on disk."""

    folder: Path
    scene_id: int

    def scene(self) -> Scene:
        """Return the whole description."""
        return load_scene(self._rendered(layout.SCENE))

    def outline(self) -> SceneOutline:
        """Return the small parts of the description: surroundings, lamps, cameras; no mesh is read."""
        self._rendered(layout.SCENE)
        return read_outline(self.folder)

    def objects(self) -> ObjectsFile:
        """Return the properties of each object that all views share."""
        return read_record(ObjectsFile, self._rendered(layout.OBJECTS), OBJECTS_SCHEMA)

    def light(self) -> SurfaceLight | None:
        """Return the irradiance of the scene's opaque surfaces; None where it was not stored."""
        path = self.folder / layout.LIGHT
        return read_light(path) if path.exists() else None

    def photometry(self) -> Photometry | None:
        """Return illuminance and lamps of the scene; None in data sets of earlier versions."""
        return scene_views(self.folder.parent.parent, self.scene_id).photometry

    def _rendered(self, name: str) -> Path:
        """Return a file that rendered scenes have; InputError where this one was converted from another project's."""
        path = self.folder / name
        if not any((self.folder / other).exists() for other in (layout.SCENE, layout.OBJECTS)):
            raise InputError(path, "a rendered scene", "one of a converted data set (partial_labels() of its views)")
        return path

    @property
    def views(self) -> tuple[StoredView, ...]:
        """All views, in the order of their numbers."""
        numbers = layout.view_numbers(self.folder)
        return tuple(StoredView(self.folder / layout.view_name(number), number) for number in numbers)


@dataclass(frozen=True)
class Dataset:
    """A data set on disk."""

    root: Path
    # The default lets `Dataset(path)` be refused in one line.
    head: DatasetFile = None  # pyright: ignore[reportAssignmentType]

    def __post_init__(self) -> None:
        """Refuse a data set made without its head."""
        check_type("Dataset", self.head, DatasetFile, "Dataset.open(path), which reads the head")

    @classmethod
    def open(cls, path: Path | str) -> Dataset:
        """Open a data set; InputError where there is none, or one of an unknown schema."""
        path = as_path("Dataset.open: path", path)
        if not path.is_dir():
            raise InputError(path, "the folder of a data set", "none")
        return cls(path, read_head(path))

    def __repr__(self) -> str:
        """Return one line: folder, name, seed and number of scenes."""
        count = counted(len(layout.scene_ids(self.root)), "scene")
        return f"Dataset({str(self.root)!r}: {self.head.name}, seed {self.head.seed}, {count})"

    def _repr_html_(self) -> str:
        """Show the first left picture of up to 48 scenes in a notebook."""
        count = counted(len(layout.scene_ids(self.root)), "scene")
        text = f"<p>{escape(self.head.name)}: {count} in {escape(str(self.root))}</p>"
        sheet = gallery(self.root)
        return text if sheet is None else text + html_images([("", sheet)], width=sheet.shape[1])

    @property
    def scenes(self) -> tuple[StoredScene, ...]:
        """All complete scenes, in the order of their ids."""
        return tuple(self.scene(scene_id) for scene_id in layout.scene_ids(self.root))

    def scene(self, scene_id: int) -> StoredScene:
        """Return one scene; InputError where it is missing."""
        whole_number("scene", scene_id, 0, MOST_SCENE)
        folder = layout.scene_folder(self.root, scene_id)
        if not folder.is_dir():
            raise InputError(self.root, f"a scene {scene_id}", f"scenes {layout.scene_ids(self.root)[:20]}")
        return StoredScene(folder, scene_id)

    def views(self) -> tuple[StoredView, ...]:
        """Return the views of all scenes."""
        return tuple(view for scene in self.scenes for view in scene.views)

    def index(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Return the index, one row per view, or some of its columns; the folders of the scenes are not read."""
        path = self.root / layout.VIEWS
        if isinstance(columns, str) or not isinstance(columns, Iterable | None):
            raise InputError("index: columns", "a list of names of columns", described(columns))
        try:
            known = pq.read_schema(path).names
            for name in columns or ():
                if name not in known:
                    hint = suggest(str(name), known)
                    raise InputError(path, f"one of the columns {', '.join(known)}{hint}", described(name))
            return pq.read_table(path, columns=None if columns is None else list(columns))
        except (OSError, pa.ArrowException) as error:
            raise InputError(path, "an index of views", " ".join(str(error).split())[:200]) from error

    def split(self, name: Split) -> tuple[StoredScene, ...]:
        """Return the scenes of a split, in the order of their ids; InputError where the data set has no splits."""
        one_of("split", name, get_args(Split))
        if not (self.root / layout.SPLITS).is_file():
            raise InputError(self.root, "a data set that is split, as build-dataset writes it", "one without splits")
        existing = set(layout.scene_ids(self.root))
        scenes = getattr(read_splits(self.root), name)
        return tuple(self.scene(scene_id) for scene_id in scenes if scene_id in existing)
