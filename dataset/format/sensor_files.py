"""Files of a depth camera: ``sensor_depth.png``, ``sensor_valid.png``, ``ir_left.png``, ``ir_right.png``."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...procedural.description.depth_camera import DepthCamera
from ...procedural.description.scene import Scene
from ...procedural.description.time_of_flight import TimeOfFlightCamera
from ...render.frame import EYES, Eye, Frame
from ..depth_cameras.measure import REASONS, SensorDepth, measured
from ..depth_cameras.time_of_flight import TIME_OF_FLIGHT_REASONS, timed
from . import layout
from .camera_file import DepthCameraRecord, depth_camera_record, time_of_flight_record
from .pictures import read_png, write_png

#: Infrared pictures by eye.
IR_FILES: dict[Eye, str] = {"left": layout.IR_LEFT, "right": layout.IR_RIGHT}


def sensor_depth(scene: Scene, frame: Frame) -> SensorDepth | None:
    """Return what a scene's depth camera reports of a rendered view; None where the scene has none."""
    device, colour = scene.depth_camera, scene.cameras[frame.view]
    place = scene.seed, scene.scene_id, frame.view
    if isinstance(device, TimeOfFlightCamera) and frame.beams is not None:
        return timed(device, frame.beams, colour, frame.geometry.Z, place)
    if isinstance(device, DepthCamera) and frame.infrared is not None:
        return measured(device, frame.infrared, colour, frame.geometry.Z, place)
    return None


def write_sensor(folder: Path, scene: Scene, frame: Frame, files: Collection[str]) -> DepthCameraRecord | None:
    """Write the files of a view's depth camera, and return its record; None where the scene has none.

    Parameters
    ----------
    folder : Path
        The view's folder.
    scene, frame : Scene, Frame
        The scene, and the rendered view.
    files : collection of str
        Kinds of files (`file_kinds`): the infrared pictures are written on request.
    """
    found, device = sensor_depth(scene, frame), scene.depth_camera
    if found is None or device is None:
        return None
    write_png(folder / layout.SENSOR_DEPTH, found.depth)
    write_png(folder / layout.SENSOR_VALID, found.reason)
    if isinstance(device, TimeOfFlightCamera):
        return time_of_flight_record(device, TIME_OF_FLIGHT_REASONS)
    pictures = found.infrared
    if pictures is None:
        raise ValueError(f"{folder}: expected the infrared pictures of {device.name}, found none")
    if "infrared" in files:
        for eye in EYES:
            write_png(folder / IR_FILES[eye], getattr(pictures, eye))
    return depth_camera_record(device, pictures.exposure, pictures.gain, REASONS)


def read_sensor_depth(path: Path, unit: float) -> np.ndarray:
    """Read ``sensor_depth.png``, (H, W) float32 [m]; NaN where there is no depth."""
    numbers = read_numbers(path)
    return np.where(numbers > 0, numbers * np.float32(unit), np.float32(np.nan))


def read_numbers(path: Path) -> np.ndarray:
    """Read a file of 16-bit numbers, (H, W) uint16; InputError where it is anything else."""
    numbers = read_png(path)
    if numbers.dtype != np.uint16:
        raise InputError(path, "a picture of one 16-bit channel", f"{numbers.shape} {numbers.dtype}")
    return numbers
