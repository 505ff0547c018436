"""What a time-of-flight camera reports of a view: the returns of its beams as depth, and why pixels have none."""

from __future__ import annotations

import numpy as np

from ...core.randomness import stream
from ...procedural.description.camera import Camera
from ...procedural.description.time_of_flight import TimeOfFlightCamera
from ...render.frame import Beams
from .measure import MEASURED, OUT_OF_RANGE, SensorDepth, in_colour
from .registration import registered

#: Names of the numbers in `SensorDepth.reason`: the first two and the last but one as those of stereo cameras.
TIME_OF_FLIGHT_REASONS = ("unseen", "measured", "no_return", "out_of_range", "weak")
NO_RETURN, WEAK = 2, 4
#: Largest difference of the inverse depths of one surface within a colour pixel [1/m]: eight standard deviations of the
#: L515's at 1 m.
_SAME_SURFACE = 0.02


def timed(
    device: TimeOfFlightCamera, beams: Beams, colour: Camera, Z: np.ndarray, place: tuple[int, int, int]
) -> SensorDepth:
    """Return what a time-of-flight camera reports.

    Parameters
    ----------
    device : TimeOfFlightCamera
        The device.
    beams : Beams
        What comes back along its beams.
    colour : Camera
        The colour camera that the depth is registered to; its left eye counts.
    Z : (H, W) float32
        Planar depth of that camera's first surfaces [m]: it says why pixels have no depth, and nothing else.
    place : (int, int, int)
        Seed, scene and view: those of the random stream of the noise.
    """
    seed, scene_id, view = place
    strength, path = chosen(beams, device)
    seen = strength >= device.least
    rng = stream(seed, scene_id, f"sensors/{view}/noise")
    noise = rng.standard_normal(path.shape) * spread(np.where(seen, strength, device.least), device)
    depth = np.where(seen, path + noise, np.nan) * _cosines(beams.camera)
    low, high = device.range
    outside = seen & ~((depth >= low) & (depth <= high))
    depth = np.where(outside, np.nan, depth).astype(np.float32)
    reason = np.select([strength <= 0.0, ~seen, outside], [NO_RETURN, WEAK, OUT_OF_RANGE], MEASURED).astype(np.uint16)
    found = registered(depth, beams.camera, colour, device.place, _SAME_SURFACE)
    numbers = np.rint(np.nan_to_num(found) / device.unit).astype(np.uint16)
    reason = in_colour(reason, (beams.camera, beams.Z), colour, Z, device.place)
    reason[numbers > 0] = MEASURED
    return SensorDepth(numbers, reason, device.unit, None, depth)


def chosen(beams: Beams, device: TimeOfFlightCamera) -> tuple[np.ndarray, np.ndarray]:
    """Return strength [1/m^2] and optical length [m] of the return that each pixel reports, (h, w) float64 each.

    Returns that are less than `pulse` apart are one, at their mean: at a rim it hangs in the air between the two
    surfaces (a mixed pixel). Of those that are told apart, the device's kind counts.
    """
    light = beams.strength.astype(np.float64) * beams.weight[:, None, None]
    path = np.where(light > 0.0, beams.path, np.inf).astype(np.float64)
    length = np.where(light > 0.0, path, 0.0)
    best, best_path, first = (np.zeros(path.shape[1:]) for _ in range(3))
    for k in range(len(path)):
        near = np.abs(np.where(np.isfinite(path), path, -np.inf) - length[k]) < device.pulse
        total = np.where(near, light, 0.0).sum(axis=0)
        mean = np.where(near, light * length, 0.0).sum(axis=0) / np.maximum(total, 1e-30)
        strong = (total >= device.least) & (light[k] > 0.0)
        if device.returns == "first":
            better = strong & ((best < device.least) | (length[k] < first))
            better |= ~strong & (best < device.least) & (total > best) & (light[k] > 0.0)
        else:
            better = (total > best) & (light[k] > 0.0)
        first = np.where(better, length[k], first)
        best, best_path = np.where(better, total, best), np.where(better, mean, best_path)
    return best, best_path


def spread(strength: np.ndarray, device: TimeOfFlightCamera) -> np.ndarray:
    """Return the standard deviation of the lengths of returns [m].

    The timing error of a pulse under constant noise is inverse to its height, on top of one that does not depend on it:
    both are fixed by the two figures of `error`.
    """
    floor, weakest = device.error
    slope = np.sqrt(weakest**2 - floor**2) * device.least
    return np.hypot(floor, slope / strength)


def _cosines(camera: Camera) -> np.ndarray:
    """Return planar depth over distance for the rays through the pixel centres, (h, w) float64."""
    rows, columns = np.indices((camera.height, camera.width))
    cx, cy = camera.centre
    x, y = (columns - cx) / camera.fx, (rows - cy) / camera.fy
    return 1.0 / np.sqrt(1.0 + x * x + y * y)
