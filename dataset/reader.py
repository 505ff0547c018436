"""Read a data set as the typed data that it was written from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Literal, TypeVar, cast, get_args

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..annotate.labels import LABELS_SCHEMA, Labels
from ..annotate.masks import decode_mask
from ..annotate.projection import transformed, unproject
from ..core.arguments import as_path, check_type, described, whole_number
from ..core.errors import InputError
from ..core.html import html_images
from ..core.json_file import check_schema, parsed, read_json
from ..core.model import Model
from ..core.setting_errors import suggest
from ..core.user_text import counted
from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene
from ..procedural.scene.scene_file import load_scene
from ..procedural.scene.splits import Split
from ..procedural.surroundings.photometry import Photometry
from ..render.frame import EYES, Eye, Geometry, Layers, Refraction, SurfaceLight
from .format import layout
from .format.camera_file import CAMERA_SCHEMA, CameraFile, camera_of
from .format.dataset_file import DatasetFile, read_head
from .format.exr import channel, read_exr, stacked
from .format.file_kinds import FileKind
from .format.light_file import read_light
from .format.objects_file import OBJECTS_SCHEMA, ObjectsFile
from .format.pictures import read_png
from .format.ray_files import read_layers, read_refraction
from .format.split_file import read_splits
from .format.views_table import scene_views
from .preview.gallery import gallery

M = TypeVar("M", bound=Model)
_Frame = Literal["camera", "world"]
#: Largest number of a scene: as folders have six digits or more, and names have an end.
MOST_SCENE = 10**12


@dataclass(frozen=True)
class StoredView:
    """A view on disk; each call reads its file."""

    folder: Path
    number: int

    def camera(self) -> Camera:
        """Return the stereo pair."""
        return camera_of(_read(CameraFile, self.folder / layout.CAMERA, CAMERA_SCHEMA))

    def labels(self) -> Labels:
        """Return the labels."""
        return _read(Labels, self.folder / layout.LABELS, LABELS_SCHEMA)

    def picture(self, eye: Eye = "left") -> np.ndarray:
        """Return the 8-bit sRGB picture, (H, W, 3) uint8."""
        return read_png(self.folder / f"{_checked_eye(eye)}.png")

    def radiance(self, eye: Eye = "left", noisy: bool = False) -> np.ndarray:
        """Return linear Rec.709 radiance, (H, W, 3) float32; ``noisy`` is before the denoiser."""
        path, kind = self._of_kind(f"{_checked_eye(eye)}.exr", "noisy" if noisy else "radiance")
        channels = read_exr(path)
        if ("noisy.R" if noisy else "R") not in channels:
            raise _absent(path, kind)
        return stacked(channels, "noisy.RGB" if noisy else "RGB", path)

    def geometry(self) -> Geometry:
        """Return the left camera's geometry; the silhouettes come from the masks of the labels."""
        path = self.folder / layout.GEOMETRY
        channels = read_exr(path)
        ids = read_png(self.folder / layout.INSTANCES)
        Z = channel(channels, "Z", path)
        if ids.shape != Z.shape or ids.dtype != np.uint16:
            raise InputError(self.folder / layout.INSTANCES, f"16-bit ids of {Z.shape} px", f"{ids.shape} {ids.dtype}")
        return Geometry(
            Z=Z,
            normal=stacked(channels, "N.XYZ", path),
            id=ids,
            background_Z=channel(channels, "background.Z", path),
            background_id=channel(channels, "background.id", path).astype(np.uint16),
            transmittance=stacked(channels, "transmittance.RGB", path),
            crossed=self._masks("mask_amodal", Z.shape),
            reached=self._masks("mask_seen", Z.shape),
        )

    def layers(self) -> Layers:
        """Return the surfaces along the left camera's straight rays, as many layers as the file has."""
        return read_layers(self._of_kind(layout.LAYERS, "layers")[0])

    def refraction(self) -> Refraction:
        """Return the end points of the left camera's refracted rays."""
        return read_refraction(self._of_kind(layout.REFRACTION, "refraction")[0])

    def points(self, frame: _Frame = "camera") -> np.ndarray:
        """Return the point cloud of the first surfaces that the left camera sees, glass included.

        Parameters
        ----------
        frame : {"camera", "world"}
            Frame of the points: the left camera's (OpenCV axes), or the world's.

        Returns
        -------
        (n, 3) float64
            One point per pixel that sees a surface, row by row [m].
        """
        if frame not in get_args(_Frame):
            raise InputError("frame", "'camera' or 'world'", repr(frame))
        camera, path = self.camera(), self.folder / layout.GEOMETRY
        seen = unproject(channel(read_exr(path), "Z", path), camera.K)
        points = seen[np.isfinite(seen[..., 2])]
        return points if frame == "camera" else transformed(camera.world_T_camera, points)

    def _of_kind(self, name: str, kind: FileKind) -> tuple[Path, FileKind]:
        """Return a file that is written on request, with its kind; InputError where it was not."""
        path = self.folder / name
        if not path.is_file():
            raise _absent(path, kind)
        return path, kind

    def _masks(self, field: str, shape: tuple[int, ...]) -> np.ndarray:
        masks = np.zeros((0, *shape), bool)
        for label in self.labels().objects:
            rle = getattr(label, field)
            where = f"{self.folder / layout.LABELS}: object {label.id} {field}"
            if rle.size != shape:
                raise InputError(where, f"size {shape}", rle.size)
            try:
                masks = np.concatenate([masks, decode_mask(rle.counts, rle.size)[None]])
            except ValueError as error:
                raise InputError(where, "a mask", error) from error
        return masks


@dataclass(frozen=True)
class StoredScene:
    """A scene on disk."""

    folder: Path
    scene_id: int

    def scene(self) -> Scene:
        """Return the whole description."""
        return load_scene(self.folder / layout.SCENE)

    def objects(self) -> ObjectsFile:
        """Return the properties of each object that all views share."""
        return _read(ObjectsFile, self.folder / layout.OBJECTS, OBJECTS_SCHEMA)

    def light(self) -> SurfaceLight | None:
        """Return the irradiance of the scene's opaque surfaces; None where it was not stored."""
        path = self.folder / layout.LIGHT
        return read_light(path) if path.exists() else None

    def photometry(self) -> Photometry | None:
        """Return illuminance and lamps of the scene; None in data sets of earlier versions."""
        return scene_views(self.folder.parent.parent, self.scene_id).photometry

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
        try:
            known = pq.read_schema(path).names
            for name in columns or ():
                if name not in known:
                    raise InputError(path, f"one of the columns {', '.join(known)}{suggest(name, known)}", repr(name))
            return pq.read_table(path, columns=None if columns is None else list(columns))
        except (OSError, pa.ArrowException) as error:
            raise InputError(path, "an index of views", " ".join(str(error).split())[:200]) from error

    def split(self, name: Split) -> tuple[StoredScene, ...]:
        """Return the scenes of a split, in the order of their ids; InputError where the data set has no splits."""
        if name not in get_args(Split):
            raise InputError("split", f"one of {', '.join(get_args(Split))}", described(name))
        if not (self.root / layout.SPLITS).is_file():
            raise InputError(self.root, "a data set that is split, as build-dataset writes it", "one without splits")
        existing = set(layout.scene_ids(self.root))
        scenes = getattr(read_splits(self.root), name)
        return tuple(self.scene(scene_id) for scene_id in scenes if scene_id in existing)


def _absent(path: Path, kind: FileKind) -> InputError:
    """Return the error of a file that a view may lack, with how it is made."""
    expected = f"a data set with {kind}, made with --write {kind} (from Python: files={kind!r})"
    return InputError(path, expected, f"one without {kind}")


def _checked_eye(eye: object) -> Eye:
    if eye not in EYES:
        raise InputError("eye", "'left' or 'right'", described(eye))
    return cast(Eye, eye)


def _read(model: type[M], path: Path, schema: str) -> M:
    data = read_json(path)
    check_schema(path, data, schema)
    return parsed(model, data, path)
