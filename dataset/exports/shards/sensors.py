"""What depth and polarisation cameras report, as members of samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...format import layout
from ...format.camera_file import CameraFile
from ...format.sensor_files import IR_FILES
from ...reader import StoredView
from ..files import compact_json, read_bytes, whole_png
from ..job import Job
from .features import DEPTH_CAMERA, POLARISATION_CAMERA, Kind

#: The configurations that only data sets with such cameras have, with the settings that give a data set these.
SETTINGS = {"sensor": "depth d435", "polarisation": "polarisation imx250mzr"}
SENSOR_CONFIGS = tuple(SETTINGS)
#: Their fields of `camera.json`.
_RECORDS = {"sensor": "depth_camera", "polarisation": "polarisation_camera"}
_IMAGE: Kind = "image"
_BINARY: Kind = "binary"
_DEPTH: Kind = DEPTH_CAMERA
_POLARISATION: Kind = POLARISATION_CAMERA
_INFRARED = tuple(IR_FILES.values())
_STOKES = (layout.DOLP, layout.AOLP, layout.MOSAIC)


def sensor_columns(job: Job) -> dict[str, dict[str, Kind]]:
    """Return the columns of the configurations of the cameras that a data set has, by its first view."""
    scenes = job.dataset.scenes
    view = scenes[0].views[0] if scenes and scenes[0].views else None
    if view is None:
        return {}
    record = view.camera_record()
    found: dict[str, dict[str, Kind]] = {}
    if record.depth_camera is not None:
        infrared = tuple(name for name in _INFRARED if (view.folder / name).is_file())
        columns = dict.fromkeys((layout.SENSOR_DEPTH, layout.SENSOR_VALID, *infrared), _IMAGE)
        found["sensor"] = columns | {"sensor.json": _DEPTH}
    if record.polarisation_camera is not None:
        columns = dict.fromkeys(_STOKES, _IMAGE) | {layout.STOKES: _BINARY}
        found["polarisation"] = columns | {"polarisation.json": _POLARISATION}
    return found


def sensor_members(config: str, names: list[str], view: StoredView) -> Iterator[tuple[str, bytes]]:
    """Yield the members of a view with these names; none where the view's scene has no such camera."""
    record = view.camera_record()
    if getattr(record, _RECORDS[config]) is None:
        return
    for name in names:
        if name.endswith(".json"):
            yield name, compact_json(_record(config, record)).encode()
        elif name.endswith(".png"):
            yield name, whole_png(view.folder / name)
        else:
            yield name, read_bytes(view.folder / name)


def _record(config: str, record: CameraFile) -> dict[str, Any]:
    """Return the record of a camera with every field of its type, null where it has none."""
    stored = getattr(record, _RECORDS[config]).model_dump(mode="json")
    kind = DEPTH_CAMERA if config == "sensor" else POLARISATION_CAMERA
    return {name: stored.get(name) for name in kind}
