"""Pictures: of the right size, not black, not blown out, not the same from both eyes, and those of their radiance."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...procedural.description.camera import Camera
from ..stored_view import StoredView
from .fault import Fault, at_pixels
from .pinhole import Pinhole
from .tone import encoded, gains_of

#: Largest mean of a picture that shows anything but black, and smallest one of one that is not all white [of 255].
BLACK, WHITE = 2.0, 253.0
#: Rounding of 8 bits, and of float32 radiance before the curve.
STEP = 1


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


def radiance_faults(view: StoredView, camera: Camera, developed: bool) -> list[Fault]:
    """Check radiance: finite, not negative, and that of the picture where no other camera took it."""
    found: list[Fault] = []
    light: dict[str, np.ndarray] = {}
    for eye in ("left", "right"):
        path = Path(view.folder, f"{eye}.exr")
        if not path.is_file():
            continue
        light[eye] = view.radiance(eye)
        wrong = ~((light[eye] >= 0.0) & (light[eye] < np.inf))  # true of NaN
        found += at_pixels("radiance", path.name, _any(wrong), "finite light", light[eye])
        if developed or wrong.any():
            continue
        expected = np.round(encoded(light[eye], camera, gains_of(light["left"], camera)))
        apart = np.abs(expected - view.picture(eye)) > STEP
        found += at_pixels("radiance", path.name, _any(apart), "the light of the picture", light[eye])
    return found


def _any(flags: np.ndarray) -> np.ndarray:
    return flags[..., 0] | flags[..., 1] | flags[..., 2]
