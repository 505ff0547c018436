"""A depth camera's files against its record, the scene's device, and the depth that flat opaque places truly have."""

from __future__ import annotations

import cv2
import numpy as np

from ...procedural.description.depth_camera import DepthCamera
from ...procedural.description.scene import TABLE_ID
from ...procedural.description.time_of_flight import DepthDevice
from ...render.frame import Geometry
from ..format import layout
from ..format.camera_file import DepthCameraRecord
from ..format.sensor_files import read_numbers
from ..stored_view import StoredView
from .fault import Fault, at_pixels, unlike

#: Number of `sensor_valid.png` that means a depth, as docs/format.md lists them.
MEASURED = 1
#: Float64 through JSON [m, px].
EXACT = 1e-12
#: Largest median error on the table, as a disparity [px]: devices have 0.08 px about the truth, and most of that has no
#: sign. What is off by more has another frame, unit or focal length.
MEDIAN_ERROR = 0.25
#: ... and that of a time-of-flight camera [m]: the L515's data sheet has 5 mm at 1 m.
MEDIAN_DISTANCE = 0.005
#: Fewest pixels of the table that are compared, and how far from anything else they are [px].
FEWEST, AWAY = 500, 12


def sensor_faults(view: StoredView, device: DepthDevice | None, geometry: Geometry) -> list[Fault]:
    """Check the files of a view's depth camera.

    Parameters
    ----------
    view : StoredView
        The view.
    device : DepthCamera or None
        The scene's device.
    geometry : Geometry
        What the left colour camera sees.
    """
    record = view.depth_camera()
    if device is None or record is None:
        expected, stored = (None if one is None else one.name for one in (device, record))
        return unlike("sensor", layout.CAMERA, "depth_camera", expected, stored)
    found = record_faults(record, device)
    depth, reason = view.sensor_depth(), view.sensor_valid()
    for file, values in ((layout.SENSOR_DEPTH, depth), (layout.SENSOR_VALID, reason)):
        if values.shape != geometry.Z.shape:
            found.append(Fault("sensor", file, "size", str(geometry.Z.shape), str(values.shape)))
    if found:
        return found
    return [
        *_pixel_faults(record, depth, reason),
        *_table_faults(record, depth, geometry),
        *_infrared_faults(view, record, device),
    ]


def record_faults(record: DepthCameraRecord, device: DepthDevice) -> list[Fault]:
    """Compare the record of a depth camera with the scene's device."""
    file, step = layout.CAMERA, np.eye(4)
    faults = unlike("sensor", file, "depth_camera name", device.name, record.name)
    faults += unlike("sensor", file, "depth_camera unit", device.unit, record.unit, EXACT)
    faults += unlike("sensor", file, "depth_camera range", device.range, record.range, EXACT)
    faults += unlike("sensor", file, "depth_camera K", device.K, record.K, EXACT)
    stereo = isinstance(device, DepthCamera)
    faults += unlike("sensor", file, "depth_camera kind", "stereo" if stereo else device.kind, record.kind)
    own = device.imager if stereo else device
    size = own.width, own.height
    faults += unlike("sensor", file, "depth_camera size", size, (record.width, record.height))
    if isinstance(device, DepthCamera):
        faults += _exposure_faults(record, device)
    if faults:
        return faults
    places = {"camera_T_left": device.place}
    if stereo:
        faults += unlike("sensor", file, "depth_camera baseline", device.baseline, record.baseline, EXACT)
        places["camera_T_right"] = device.place + device.baseline
        places["camera_T_projector"] = device.place + device.projector.place
    for name, place in places.items():
        step[0, 3] = place
        faults += unlike("sensor", file, f"depth_camera {name}", step.copy(), getattr(record, name), EXACT)
    return faults


def _exposure_faults(record: DepthCameraRecord, device: DepthCamera) -> list[Fault]:
    """Check that time and gain are some that the device can have."""
    (low, high), most = device.imager.exposure, device.imager.gain
    time, gain = record.exposure, record.gain
    margin = 1.0 + EXACT
    if (
        time is not None
        and gain is not None
        and low <= time * margin
        and time <= high * margin
        and gain <= most * margin
    ):
        return []
    expected = f"{low:g} to {high:g} s and a gain of 1 to {most:g}"
    return [Fault("sensor", layout.CAMERA, "depth_camera exposure, gain", expected, f"{time}, {gain}")]


def _infrared_faults(view: StoredView, record: DepthCameraRecord, device: DepthDevice) -> list[Fault]:
    """Check size and numbers of the infrared pictures, where there are any."""
    found: list[Fault] = []
    if not isinstance(device, DepthCamera):
        return found
    white = 2**device.imager.bits - 1
    for name in (layout.IR_LEFT, layout.IR_RIGHT):
        if not (view.folder / name).is_file():
            continue
        numbers = read_numbers(view.folder / name)
        found += unlike("sensor", name, "size", str((record.height, record.width)), str(numbers.shape))
        found += at_pixels("sensor", name, numbers > white, f"a number of {device.imager.bits} bits", numbers)
    return found


def _pixel_faults(record: DepthCameraRecord, depth: np.ndarray, reason: np.ndarray) -> list[Fault]:
    has, (low, high) = np.isfinite(depth), record.range
    meanings, margin = len(record.reasons), record.unit  # rounding to the unit, at either end
    return [
        *at_pixels("sensor", layout.SENSOR_VALID, has != (reason == MEASURED), "1 where there is a depth", reason),
        *at_pixels("sensor", layout.SENSOR_VALID, reason >= meanings, f"a number below {meanings}", reason),
        *at_pixels(
            "sensor",
            layout.SENSOR_DEPTH,
            has & ((depth < low - margin) | (depth > high + margin)),
            f"{low:g} to {high:g} m",
            depth,
        ),
    ]


def _table_faults(record: DepthCameraRecord, depth: np.ndarray, geometry: Geometry) -> list[Fault]:
    """Compare the depth on the open table with its own in the median: as disparities, or as a distance."""
    table = (geometry.id == TABLE_ID).astype(np.uint8)
    open_table = cv2.erode(table, np.ones((2 * AWAY + 1, 2 * AWAY + 1), np.uint8), borderValue=0) > 0
    seen = open_table & np.isfinite(depth)
    if np.count_nonzero(seen) < FEWEST:
        return []
    if record.baseline is None:
        error = float(np.median(depth[seen] - geometry.Z[seen]))
        if abs(error) <= MEDIAN_DISTANCE:
            return []
        expected = f"within {MEDIAN_DISTANCE:g} m of the table's depth in the median"
        return [
            Fault("sensor", layout.SENSOR_DEPTH, f"{np.count_nonzero(seen)} px of the table", expected, f"{error:.3g}")
        ]
    fb = record.K[0][0] * record.baseline
    error = float(np.median(fb / depth[seen] - fb / geometry.Z[seen]))
    if abs(error) <= MEDIAN_ERROR:
        return []
    expected = f"a disparity within {MEDIAN_ERROR:g} px of the table's in the median"
    return [Fault("sensor", layout.SENSOR_DEPTH, f"{np.count_nonzero(seen)} px of the table", expected, f"{error:.3g}")]
