"""What a depth camera reports of a view: depth in the colour camera's pixels, and why pixels have none."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...core.randomness import stream
from ...procedural.description.camera import Camera
from ...procedural.description.depth_camera import DepthCamera
from ...render.frame import Infrared
from .exposure import InfraredPictures, infrared_pictures
from .matching import matched
from .registration import projected, registered

#: Names of the numbers in `SensorDepth.reason`.
REASONS = ("unseen", "measured", "no_match", "out_of_range", "saturated", "unlit", "hidden")
UNSEEN, MEASURED, NO_MATCH, OUT_OF_RANGE, SATURATED, UNLIT, HIDDEN = range(len(REASONS))
#: Fraction of white pixels in a window from which a pixel without a match counts as saturated [1].
_WHITE = 0.2
#: How much farther than a colour pixel's point the infrared camera's own may be, and still be the same [1].
_SAME = 0.02
#: Largest difference of the disparities of one surface within a colour pixel [px]: matching tells no more apart.
_SAME_SURFACE = 1.0


@dataclass(frozen=True, eq=False)
class SensorDepth:
    """What a depth camera reports, in the pixels of the left colour camera, and what it was found in."""

    depth: np.ndarray  #: (H, W) uint16, planar depth in `unit`; 0 for none
    reason: np.ndarray  #: (H, W) uint16, numbers of `REASONS`
    unit: float  #: [m]
    infrared: InfraredPictures | None  #: of a stereo camera
    Z: np.ndarray  #: (h, w) float32, depth in the device's own pixels (the left infrared camera's) [m]; NaN for none

    @property
    def metres(self) -> np.ndarray:
        """The depth in metres, (H, W) float32; NaN for none."""
        return np.where(self.depth > 0, self.depth * np.float32(self.unit), np.float32(np.nan))


def measured(
    device: DepthCamera, infrared: Infrared, colour: Camera, Z: np.ndarray, place: tuple[int, int, int]
) -> SensorDepth:
    """Return what a device reports.

    Parameters
    ----------
    device : DepthCamera
        The device.
    infrared : Infrared
        What its infrared cameras see.
    colour : Camera
        The colour camera that the depth is registered to; its left eye counts.
    Z : (H, W) float32
        Planar depth of that camera's first surfaces [m]: it says why pixels have no depth, and nothing else.
    place : (int, int, int)
        Seed, scene and view: those of the random stream of the noise.
    """
    seed, scene_id, view = place
    pictures = infrared_pictures(infrared, device, stream(seed, scene_id, f"sensors/{view}/noise"))
    disparity = matched(pictures, device.matching)
    depth = device.imager.focal * device.baseline / disparity
    low, high = device.range
    outside = np.isfinite(disparity) & ((depth < low) | (depth > high))
    depth = np.where(outside, np.nan, depth).astype(np.float32)
    found = registered(
        depth, infrared.pair, colour, device.place, _SAME_SURFACE / (device.imager.focal * device.baseline)
    )
    numbers = np.rint(np.nan_to_num(found) / device.unit).astype(np.uint16)
    reason = _reasons(device, infrared, pictures, disparity, outside)
    reason = in_colour(reason, (infrared.pair, infrared.Z), colour, Z, device.place)
    reason[numbers > 0] = MEASURED
    return SensorDepth(numbers, reason, device.unit, pictures, depth)


def _reasons(
    device: DepthCamera, infrared: Infrared, pictures: InfraredPictures, disparity: np.ndarray, outside: np.ndarray
) -> np.ndarray:
    """Return why pixels of the left infrared camera have no depth, (h, w) uint16; `MEASURED` for those that have."""
    reason = np.full(disparity.shape, NO_MATCH, np.uint16)
    block = (device.matching.block, device.matching.block)
    white = (pictures.left == pictures.white).astype(np.float32)
    reason[cv2.blur(white, block) >= _WHITE] = SATURATED
    reason[~(infrared.lit & _in_field(device, infrared))] = UNLIT
    columns = np.arange(disparity.shape[1])
    shift = device.imager.focal * device.baseline / infrared.Z
    hidden = ~infrared.shared | (columns < shift)
    reason[hidden] = HIDDEN
    reason[np.isfinite(disparity)] = MEASURED
    # What is nearer than the largest disparity has none that could be found.
    _, high = device.range
    near = ~np.isfinite(disparity) & (shift >= device.matching.disparities)
    far = ~np.isfinite(disparity) & (high < infrared.Z)
    # What has no depth at all is behind nothing: it is far, whatever the right camera sees.
    far &= ~hidden | np.isinf(infrared.Z)
    reason[(outside & ~hidden) | near | far] = OUT_OF_RANGE
    return reason


def _in_field(device: DepthCamera, infrared: Infrared) -> np.ndarray:
    """Return which points of the left infrared camera are within the projector's field, (h, w) bool."""
    (cx, cy), focal = device.centre, device.imager.focal
    rows, columns = np.indices(infrared.Z.shape)
    x = (columns - cx) / focal - device.projector.place / infrared.Z
    y = (rows - cy) / focal
    across, down = np.tan(0.5 * np.array(device.projector.field))
    return (np.abs(x) <= across) & (np.abs(y) <= down)


def in_colour(
    reason: np.ndarray, own: tuple[Camera, np.ndarray], colour: Camera, Z: np.ndarray, shift: float
) -> np.ndarray:
    """Return the reason of each colour pixel, (H, W) uint16: that of the device's pixel which sees its point.

    Parameters
    ----------
    reason : (h, w) uint16
        Of the device's own pixels.
    own : Camera, (h, w) float
        The device's camera, and the depth of its first surfaces [m].
    colour : Camera
        The colour camera.
    Z : (H, W) float
        Depth of its first surfaces [m].
    shift : float
        x of the device in the colour camera's frame [m].
    """
    camera, first = own
    column, row = (np.rint(x) for x in projected(Z, colour, camera, shift))
    inside = (column >= 0) & (column < reason.shape[1]) & (row >= 0) & (row < reason.shape[0])
    u, v = column[inside].astype(int), row[inside].astype(int)
    there = reason[v, u]
    # Another surface in front of the point, or a depth that went to another pixel: the point was not seen.
    nearer = first[v, u] < Z[inside] * (1.0 - _SAME)
    found = np.full(Z.shape, UNSEEN, np.uint16)
    found[inside] = np.where(nearer | (there == MEASURED), UNSEEN, there)
    return found
