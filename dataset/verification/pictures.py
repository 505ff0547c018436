"""Pictures: of the right size, not black, not blown out, not the same from both eyes, and those of their radiance."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...procedural.description.scene import Scene
from ...render.frame import EYES
from ..format import layout
from ..format.raw_files import RAW_FILES
from ..stored_view import StoredView
from .fault import Fault, at_pixels, unlike
from .pinhole import Pinhole
from .tone import LUMINANCE, encoded, gains_of

#: Largest mean of a picture that shows anything but black, and smallest one of one that is not all white [of 255].
BLACK, WHITE = 2.0, 253.0
#: Rounding of 8 bits, and of float32 radiance before the curve.
STEP = 1
#: Rounding of a luminance in half floats and of the weights of its channels, over the largest channel [1].
ROUNDING = 2e-3
#: Largest difference of a view's mean luminance by a sensor from the eye's [1]. In the published sensors' it is below
#: 0.03 in daylight and lamplight; curves of another kind are farther.
SAME_LIGHT = 0.25


def picture_faults(view: StoredView, camera: Pinhole) -> list[Fault]:
    """Check both pictures of a view."""
    width, height = camera.size
    pictures, found = {}, []
    for eye in ("left", "right"):
        file, picture = f"{eye}.png", view.picture(eye)
        if picture.shape != (height, width, 3):
            found.append(Fault("pictures", file, "size", f"{width} x {height} px", str(picture.shape)))
            continue
        pictures[eye] = picture
        mean = float(picture.mean())
        if not BLACK < mean < WHITE:
            expected = f"a mean between {BLACK:g} and {WHITE:g}: neither black nor blown out"
            found.append(Fault("pictures", file, "all pixels", expected, f"{mean:.1f}"))
    if len(pictures) == 2 and not found and np.array_equal(pictures["left"], pictures["right"]):
        found.append(Fault("pictures", "right.png", "all pixels", "another picture than the left one", "the same"))
    return found


def radiance_faults(view: StoredView, scene: Scene, developed: bool) -> list[Fault]:
    """Check radiance: finite, not negative, and that of the picture where no other camera took it.

    Wavelengths may lie outside of Rec.709: then the luminance is not negative. The picture of a sensor of measured
    sensitivities is that of its raw responses by its colour matrix.
    """
    camera, sensor, found = scene.cameras[view.number], view.camera_record().sensitivities, []
    light: dict[str, np.ndarray] = {}
    for eye in EYES:
        path = Path(view.folder, f"{eye}.exr")
        if not path.is_file():
            continue
        name, light[eye] = path.name, view.radiance(eye)
        found += at_pixels(
            "radiance", name, _impossible(light[eye], scene.picture.spectral), "finite light", light[eye]
        )
        if sensor is not None:
            name, raw = RAW_FILES[eye], view.raw(eye)
            found += at_pixels("radiance", name, _impossible(raw, False), "finite light", raw)
            light[eye] = raw @ np.array(sensor.matrix, np.float32).T
        if developed or found:
            continue
        expected = np.round(encoded(light[eye], camera, gains_of(light["left"], camera)))
        apart = np.abs(expected - view.picture(eye)) > STEP
        found += at_pixels("radiance", name, _any(apart), "the light of the picture", light[eye])
    return found


def _impossible(light: np.ndarray, spectral: bool) -> np.ndarray:
    """Return the pixels whose light cannot be, (H, W) bool: NaN, infinite or negative."""
    if not spectral:
        return _any(~((light >= 0.0) & (light < np.inf)))  # true of NaN
    scale = np.abs(light).max(axis=-1)
    return ~((light @ LUMINANCE >= -ROUNDING * scale) & (scale < np.inf))


def sensor_faults(view: StoredView, scene: Scene) -> list[Fault]:
    """Compare the record of a sensor of measured sensitivities with the scene's, and its light with the eye's."""
    record, sensor = view.camera_record().sensitivities, scene.sensitivities
    if record is None or sensor is None:
        expected, stored = (None if one is None else one.name for one in (sensor, record))
        return unlike("radiance", layout.CAMERA, "sensitivities", expected, stored)
    found: list[Fault] = []
    for name in ("name", "white", "matrix"):
        found += unlike(
            "radiance", layout.CAMERA, f"sensitivities {name}", getattr(sensor, name), getattr(record, name)
        )
    if found or not (view.folder / RAW_FILES["left"]).is_file():
        return found
    for eye in EYES:
        light = view.radiance(eye).mean(axis=(0, 1)) @ LUMINANCE
        seen = view.raw(eye).mean(axis=(0, 1)) @ np.array(sensor.matrix).T @ LUMINANCE
        if abs(seen - light) > SAME_LIGHT * light:
            expected = f"{light:.4g}, as in {eye}.exr"
            found.append(Fault("radiance", RAW_FILES[eye], "mean luminance by its matrix", expected, f"{seen:.4g}"))
    return found


def _any(flags: np.ndarray) -> np.ndarray:
    return flags[..., 0] | flags[..., 1] | flags[..., 2]
