from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.dataset.depth_cameras.measure import REASONS
from glassware.dataset.format.camera_file import depth_camera_record
from glassware.dataset.reader import Dataset
from glassware.procedural.sensors.depth_cameras import depth_camera

#: Name of the device, whose depth is in millimetres.
DEVICE = "d435"


@pytest.fixture(scope="session")
def add_sensor_depth() -> Callable[[Path], Path]:
    """(root) -> root: give each view of a data set a depth camera's depth, with a hole every fifth row."""
    device = depth_camera(DEVICE, "device")
    assert device is not None
    assert device.unit == 1e-3
    record = depth_camera_record(device, 1e-2, 1.0, REASONS).model_dump(mode="json")

    def add(root: Path) -> Path:
        for view in Dataset.open(root).views():
            Z = view.geometry().Z
            steps = np.where(np.isfinite(Z) & (Z < 60.0), np.rint(1000.0 * Z), 0.0).astype(np.uint16)
            steps[::5] = 0
            cv2.imwrite(str(view.folder / "sensor_depth.png"), steps)
            camera = view.folder / "camera.json"
            camera.write_text(json.dumps(json.loads(camera.read_text()) | {"depth_camera": record}))
        return root

    return add
