"""``raw_left.exr`` and ``raw_right.exr``: what the sensors of the colour cameras make of the light of a view.

Their channels ``raw.R``, ``raw.G`` and ``raw.B`` are raw responses (`procedural.description.sensitivities`). They are
written with radiance, whose unit they have.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...procedural.description.scene import Scene
from ...render.frame import Eye, Frame
from ..cameras.model import SensorColour
from . import layout
from .exr import read_exr, stacked, unstacked, write_exr
from .file_kinds import FileKinds
from .pictures import stored_radiance

#: File of each eye.
RAW_FILES: dict[Eye, str] = {"left": layout.RAW_LEFT, "right": layout.RAW_RIGHT}
_CHANNELS = "raw.RGB"


def sensor_colour(scene: Scene) -> SensorColour | None:
    """Return what ``camera.json`` says of the sensor of a scene's cameras; None where it has no sensitivities."""
    sensor = scene.sensitivities
    return None if sensor is None else SensorColour(name=sensor.name, white=sensor.white, matrix=sensor.matrix)


def write_raw(folder: Path, scene: Scene, frame: Frame, files: FileKinds) -> None:
    """Write the raw responses of a view where its radiance is written; with half floats where these are as good."""
    if frame.raw is None or "radiance" not in files:
        return
    exposure = scene.cameras[frame.view].exposure
    for name, picture in zip(RAW_FILES.values(), frame.raw, strict=True):
        write_exr(folder / name, unstacked(stored_radiance(picture, exposure), _CHANNELS))


def read_raw(folder: Path, eye: Eye, sensor: SensorColour | None) -> np.ndarray:
    """Read the raw response of an eye of a view, (H, W, 3) float32.

    Parameters
    ----------
    folder : Path
        The view's.
    eye : {"left", "right"}
        Which of the two cameras.
    sensor : SensorColour, optional
        That of ``camera.json``.

    Raises
    ------
    InputError
        Where the view has no sensor, or the file is missing or damaged.
    """
    path = folder / RAW_FILES[eye]
    if sensor is None:
        expected = "a data set of a sensor, made with --sensors.sensitivities nikon-d5100"
        raise InputError(folder / layout.CAMERA, expected, "one without")
    if not path.is_file():
        raise InputError(path, "raw responses, which --write radiance writes", "none")
    return stacked(read_exr(path), _CHANNELS, path).astype(np.float32, copy=False)
