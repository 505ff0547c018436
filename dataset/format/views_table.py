"""The index of views: ``views.json`` in each scene's folder, gathered into ``views.parquet``.

A scene's rows are written with the scene, so the index of a data set can be rebuilt at any time from the scenes on
disk, and never lists a missing scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import Field

from ...annotate.labels import Labels
from ...core.assets import Asset
from ...core.atomic_io import atomic_file
from ...core.errors import InputError
from ...core.json_file import parsed, read_json, read_record
from ...core.model import Model
from ...core.polarisation import degree_of_linear_polarisation
from ...procedural.description.rest import Rest
from ...procedural.description.scene import Scene
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.photometry import Photometry
from ...render.frame import Frame, Geometry, LightCheck
from ..depth_cameras.errors import DepthErrors, depth_errors
from . import layout
from .camera_file import CAMERA_SCHEMA, CameraFile, DepthCameraRecord
from .polarisation_files import read_stokes
from .sensor_files import IR_FILES, read_numbers, read_sensor_depth

#: Scenes per row group of the index: with Syn-TODD's 57 views about 4,000 rows.
SCENES_A_GROUP = 64
#: Objects of fewer visible pixels have no degree of polarisation [px].
FEWEST_PIXELS = 100

#: One row per view. Lists run over the scene's objects by ascending id.
SCHEMA = pa.schema(
    [
        ("scene_id", pa.int64()),
        ("view", pa.int32()),
        ("seed", pa.int64()),
        ("path", pa.string()),
        ("left", pa.string()),
        ("right", pa.string()),
        ("width", pa.int32()),
        ("height", pa.int32()),
        ("grid_index", pa.int32()),
        ("vessels", pa.int32()),
        ("props", pa.int32()),
        ("objects_in_view", pa.int32()),
        ("object_ids", pa.list_(pa.int32())),
        ("visible_pixels", pa.list_(pa.int64())),
        ("visible_fractions", pa.list_(pa.float64())),
        ("seen_through_fractions", pa.list_(pa.float64())),
        ("spp_left", pa.int32()),
        ("spp_right", pa.int32()),
        ("noise_left", pa.float64()),
        ("noise_right", pa.float64()),
        ("sensor_depth", pa.string()),
        ("sensor_valid", pa.string()),
        ("ir_left", pa.string()),
        ("ir_right", pa.string()),
        ("sensor_measured", pa.float64()),
        ("sensor_reasons", pa.list_(pa.float64())),
        *((f"sensor_{name}", pa.list_(pa.float64())) for name in DepthErrors._fields),
        ("stokes", pa.string()),
        ("polarisation_degree", pa.list_(pa.float64())),
    ],
    metadata={"schema_version": "glassware/views/1"},
)


def _absent(description: str) -> Any:
    """Return a field that files leave out where it is None."""
    return Field(default=None, exclude_if=lambda value: value is None, description=description)


class ViewRow(Model):
    """One view in the index; the columns of `SCHEMA`."""

    scene_id: int
    view: int
    seed: int
    path: str  #: folder of the view, relative to the data set
    left: str  #: left picture, relative to the data set
    right: str | None  #: null in converted data sets without a right picture
    width: int
    height: int
    grid_index: int | None  #: null off the grid
    vessels: int | None  #: null in converted data sets that do not say what is transparent
    props: int | None
    objects_in_view: int  #: objects with a pixel of silhouette in the frame
    object_ids: tuple[int, ...]
    visible_pixels: tuple[int | None, ...]  #: null in converted data sets without instances
    visible_fractions: tuple[float | None, ...]  #: null where an object is out of the frame
    seen_through_fractions: tuple[float | None, ...]
    spp_left: int | None  #: samples per pixel that were taken
    spp_right: int | None
    noise_left: float | None  #: relative error before the denoiser, estimated (`render.frame.Sampling`); null: unknown
    noise_right: float | None
    #: What a depth camera reported; absent without one. Lists run over objects, as those above; null: too few pixels.
    sensor_depth: str | None = _absent("relative path")
    sensor_valid: str | None = _absent("relative path")
    ir_left: str | None = _absent("relative path; absent where infrared pictures were not written")
    ir_right: str | None = _absent("relative path; absent where infrared pictures were not written")
    sensor_measured: float | None = _absent("fraction of the pixels that have a depth")
    sensor_reasons: tuple[float, ...] | None = _absent("fraction of the pixels with each of the reasons, by its number")
    sensor_missing: tuple[float | None, ...] | None = _absent("fractions of `DepthErrors`")
    sensor_right: tuple[float | None, ...] | None = _absent("fractions of `DepthErrors`")
    sensor_behind: tuple[float | None, ...] | None = _absent("fractions of `DepthErrors`")
    sensor_front: tuple[float | None, ...] | None = _absent("fractions of `DepthErrors`")
    sensor_rim: tuple[float | None, ...] | None = _absent("ratio of `DepthErrors`")
    #: What a polarisation camera sees; absent without one.
    stokes: str | None = _absent("relative path")
    polarisation_degree: tuple[float | None, ...] | None = _absent(
        "median degree of linear polarisation of each object's visible pixels; null: fewer than `FEWEST_PIXELS`"
    )


class SceneViews(Model):
    """The rows of one scene, its assets, and the check of its stored light."""

    views: tuple[ViewRow, ...]
    assets: tuple[Asset, ...]  #: paths relative to the data set
    light: LightCheck | None = None  #: of the stored light; null where none was stored
    photometry: Photometry | None = None  #: illuminance and lamps; null in data sets of earlier versions
    rest: Rest | None = None  #: how a pile came to rest; null where objects stand apart


def view_row(scene: Scene, view: int, frame: Frame, labels: Labels) -> ViewRow:
    """Return the row of one view."""
    camera = scene.cameras[view]
    path = f"{layout.SCENES}/{layout.scene_name(scene.scene_id)}/{layout.view_name(view)}"
    fractions = [label.fractions for label in labels.objects]
    return ViewRow(
        scene_id=scene.scene_id,
        view=view,
        seed=scene.seed,
        path=path,
        left=f"{path}/left.png",
        right=f"{path}/right.png",
        width=camera.width,
        height=camera.height,
        grid_index=camera.grid_index,
        vessels=len(scene.vessels),
        props=len(scene.props),
        objects_in_view=sum(one is not None for one in fractions),
        object_ids=tuple(label.id for label in labels.objects),
        visible_pixels=tuple(label.pixels.visible for label in labels.objects),
        visible_fractions=tuple(one and one.visible for one in fractions),
        seen_through_fractions=tuple(one and one.seen_through for one in fractions),
        **_sampling(frame),
    )


def with_sensors(row: ViewRow, folder: Path, geometry: Geometry) -> ViewRow:
    """Return a row with what depth and polarisation camera reported of the view in a folder, where it has them."""
    record = read_record(CameraFile, folder / layout.CAMERA, CAMERA_SCHEMA)
    if record.depth_camera is not None:
        row = _with_depth(row, folder, geometry, record.depth_camera)
    return row if record.polarisation_camera is None else _with_polarisation(row, folder, geometry)


def _with_polarisation(row: ViewRow, folder: Path, geometry: Geometry) -> ViewRow:
    degree = degree_of_linear_polarisation(luminance(read_stokes(folder / layout.STOKES).vector)[..., None])[..., 0]
    objects = [degree[geometry.id == number] for number in row.object_ids]
    medians = tuple(float(np.median(one)) if len(one) >= FEWEST_PIXELS else None for one in objects)
    return row.model_copy(update={"stokes": f"{row.path}/{layout.STOKES}", "polarisation_degree": medians})


def _with_depth(row: ViewRow, folder: Path, geometry: Geometry, device: DepthCameraRecord) -> ViewRow:
    reported = read_sensor_depth(folder / layout.SENSOR_DEPTH, device.unit)
    reasons = read_numbers(folder / layout.SENSOR_VALID)
    counts = np.bincount(reasons.ravel(), minlength=len(device.reasons))
    names = [layout.SENSOR_DEPTH, layout.SENSOR_VALID, *IR_FILES.values()]
    errors = [depth_errors(reported, geometry.Z, geometry.id == number) for number in row.object_ids]
    columns = {
        f"sensor_{name}": tuple(None if np.isnan(one[k]) else one[k] for one in errors)
        for k, name in enumerate(DepthErrors._fields)
    }
    values = {
        "sensor_measured": float(np.isfinite(reported).mean()),
        "sensor_reasons": tuple((counts / reasons.size).tolist()),
    }
    paths = {Path(name).stem: f"{row.path}/{name}" for name in names if (folder / name).is_file()}
    return row.model_copy(update=paths | values | columns)


def _sampling(frame: Frame) -> dict[str, Any]:
    left, right = frame.sampling or (None, None)
    return {
        "spp_left": left and left.spp,
        "spp_right": right and right.spp,
        "noise_left": left and left.noise,
        "noise_right": right and right.noise,
    }


def scene_views(root: Path, scene_id: int) -> SceneViews:
    """Return the record of one scene; InputError where it is missing, damaged or of another scene."""
    path = layout.scene_folder(root, scene_id) / layout.SCENE_VIEWS
    record = parsed(SceneViews, read_json(path), path)
    others = sorted({row.scene_id for row in record.views} - {scene_id})
    if others:  # a renamed folder would add paths to the index that do not exist
        raise InputError(path, f"the views of scene {scene_id}", f"those of scene {others[0]}")
    return record


def read_scene_views(root: Path) -> Iterator[SceneViews]:
    """Yield the records of all scenes on disk, in the order of their ids."""
    return (scene_views(root, scene_id) for scene_id in layout.scene_ids(root))


def write_views_table(root: Path, scenes: Iterable[SceneViews]) -> int:
    """Write ``views.parquet`` from the records of all scenes, a few at a time; return the number of views.

    Memory holds one row group at a time. Groups are counted in scenes, so the same scenes give the same bytes.
    """
    views, waiting = 0, iter(scenes)
    with atomic_file(root / layout.VIEWS) as partial, pq.ParquetWriter(partial, SCHEMA) as writer:
        while group := list(islice(waiting, SCENES_A_GROUP)):
            rows = [row.model_dump() for scene in group for row in scene.views]
            writer.write_table(pa.Table.from_pylist(rows, schema=SCHEMA))
            views += len(rows)
    return views
