"""Where a depth camera's parts stand and what they see: pinholes of a page's scene in 3D."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...procedural.description.depth_camera import DepthCamera
from ...procedural.description.time_of_flight import DepthDevice
from ..reader import StoredView


def rig(view: StoredView, device: DepthDevice | None) -> list[dict[str, Any]]:
    """Return infrared cameras and projector of a view as JSON records, named; none without a depth camera.

    Parameters
    ----------
    view : StoredView
        The view.
    device : DepthCamera or TimeOfFlightCamera, optional
        The scene's device, which knows the field of its projector.
    """
    record = view.depth_camera()
    if record is None:
        return []
    world_T_camera, own = view.camera().world_T_camera, (np.array(record.K), record.width, record.height)
    parts = {"infrared left": (record.camera_T_left, own), "infrared right": (record.camera_T_right, own)}
    if isinstance(device, DepthCamera):
        parts["projector"] = record.camera_T_projector, _field(device.projector.field)
    return [
        {
            "name": name,
            "K": K.tolist(),
            "pose": (world_T_camera @ camera_T_part).ravel().tolist(),
            "width": width,
            "height": height,
        }
        for name, (camera_T_part, (K, width, height)) in parts.items()
        if camera_T_part is not None
    ]


def _field(angles: tuple[float, float]) -> tuple[np.ndarray, int, int]:
    """Return a pinhole of 2 x 2 pixels whose centres lie at the corners of a field, full angles across and down."""
    fx, fy = 0.5 / np.tan(0.5 * np.array(angles))
    return np.array([[fx, 0.0, 0.5], [0.0, fy, 0.5], [0.0, 0.0, 1.0]]), 2, 2
