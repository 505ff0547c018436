"""Maps of what depth and polarisation cameras report, in the left picture's pixels, and the infrared pictures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.images import reason_colours
from ...procedural.surroundings.colour import luminance
from ...render.frame import EYES
from ..format import layout
from ..format.polarisation_files import ANGLE_STEPS, DEGREE_STEPS
from ..format.sensor_files import IR_FILES, read_numbers
from ..reader import StoredView
from .map_numbers import DEPTH_STEP, LabelMap, depth_map, signed_map, stepped, unit_map

#: Difference of depths at the ends of its colours [m]: what a depth camera sees through glass is some 50 mm behind it.
DIFFERENCE = 0.05
#: Group of the maps of either camera in a page's list.
_DEPTH, _POLARISATION = "depth camera", "polarisation"
#: Steps of the components s1 to s3 over s0 [1], and half a turn in steps of the angle.
_RATIO_STEP, _HALF_TURN = 1e-3, 256
#: Largest value of an infrared picture of 8 bits; devices with more are shown up to their brightest pixel.
_WHITE = 255


def sensor_maps(view: StoredView) -> Iterator[LabelMap]:
    """Yield the maps of the cameras that a view has beside the colour cameras."""
    if view.depth_camera() is not None:
        yield from _depth_maps(view)
    if view.polarisation_camera() is not None:
        yield from _polarisation_maps(view)


def absent_sensor_files(view: StoredView) -> dict[str, str]:
    """Return the kinds of files that a view's depth camera could have and has not, with what they hold."""
    device = view.depth_camera()
    if device is None or device.kind != "stereo" or (view.folder / layout.IR_LEFT).is_file():
        return {}
    return {"infrared": "the infrared pictures of the depth camera"}


def infrared_pictures(view: StoredView) -> dict[str, np.ndarray]:
    """Return the stored infrared pictures by the name of a camera, (h, w) uint8 each; empty without any."""
    if view.depth_camera() is None or not (view.folder / layout.IR_LEFT).is_file():
        return {}
    numbers = {eye: read_numbers(view.folder / IR_FILES[eye]) for eye in EYES}
    white = max(_WHITE, *(int(one.max()) for one in numbers.values()))
    return {f"infrared {eye}": np.rint(one * (255.0 / white)).astype(np.uint8) for eye, one in numbers.items()}


def difference_map(reported: np.ndarray, Z: np.ndarray) -> LabelMap:
    """Return how much farther a reported depth is than the true one; both (H, W) [m]."""
    apart = np.where(np.isfinite(reported) & np.isfinite(Z), reported, np.nan) - np.where(np.isfinite(Z), Z, 0.0)
    title = "... minus the true depth"
    return signed_map("left/sensor-difference", title, _DEPTH, apart, DEPTH_STEP, DIFFERENCE, "m")


def _depth_maps(view: StoredView) -> Iterator[LabelMap]:
    """Yield what a depth camera reports, how wrong it is, and why it reports nothing."""
    device, reported, geometry = view.depth_camera(), view.sensor_depth(), view.geometry()
    assert device is not None
    Z = np.where(np.isfinite(reported), reported, np.inf)
    yield depth_map("left/sensor-depth", "depth of the sensor", _DEPTH, Z, geometry.id)
    yield difference_map(reported, geometry.Z)
    codes = view.sensor_valid().astype(np.uint8)
    colours = reason_colours(np.arange(len(device.reasons))).tolist()
    names = tuple(
        (name.replace("_", " "), "#{:02x}{:02x}{:02x}".format(*colour))
        for name, colour in zip(device.reasons, colours, strict=True)
    )
    yield LabelMap("left/sensor-valid", "why it has none", _DEPTH, "class", codes, none=None, names=names)


def _polarisation_maps(view: StoredView) -> Iterator[LabelMap]:
    """Yield degree and angle of linear polarisation, the Stokes vectors' luminance, and the sensor's mosaic."""
    device = view.polarisation_camera()
    assert device is not None
    degree = read_numbers(view.folder / layout.DOLP) / DEGREE_STEPS
    yield unit_map("left/dolp", "degree of linear polarisation", _POLARISATION, degree)
    turn = np.rint(read_numbers(view.folder / layout.AOLP) * (_HALF_TURN / ANGLE_STEPS)).astype(np.int64) % _HALF_TURN
    angle = np.stack([turn, np.rint(255.0 * degree)], axis=-1).astype(np.uint8)
    step = 180.0 / _HALF_TURN
    yield LabelMap("left/aolp", "angle of linear polarisation", _POLARISATION, "angle", angle, step, "deg", none=None)
    light = luminance(view.stokes().vector)
    yield _number("left/s0", "S0, luminance", light[..., 0], float(np.percentile(light[..., 0], 99)))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = light[..., 1:] / light[..., :1]
    for k in range(3):
        title = f"S{k + 1} / S0"
        yield signed_map(f"left/s{k + 1}", title, _POLARISATION, ratios[..., k], _RATIO_STEP, 1.0, "")
    numbers, top = view.polarisation_mosaic(), 2.0**device.bits - 1.0
    yield LabelMap("left/mosaic", "mosaic of the sensor", _POLARISATION, "number", numbers, high=top, none=None)


def _number(name: str, title: str, values: np.ndarray, high: float) -> LabelMap:
    """Return positive numbers in 16 bits."""
    stored, step = stepped(values, 0.0)
    return LabelMap(name, title, _POLARISATION, "number", stored, step, high=max(high, step), none=None)
