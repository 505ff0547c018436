"""A projector's pattern from a picture: its grey levels are proportional to the power by direction."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ...core.assets import check_content
from ...core.errors import InputError, cause_of
from ...core.silence import quiet

#: Largest side of such a picture [px]: finer ones are far beyond what an infrared camera sees.
_LONGEST = 8192


def pattern_picture(path: Path) -> np.ndarray:
    """Return the grey levels of a picture of a pattern, (rows, columns) float32 of the sum 1.

    Levels count as linear; of a picture in colour the mean of the channels.

    Raises
    ------
    InputError
        Where the file is no picture that can be read, or a black one.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable picture of a pattern", cause_of(error)) from error
    check_content(path, content)
    try:
        with quiet():
            picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED) if content else None
    except cv2.error as error:
        raise InputError(path, "a picture of a pattern of a usual size", "one of too many pixels") from error
    if picture is None:
        raise InputError(path, "a picture of a pattern (PNG or JPEG)", "something else")
    levels = np.array(picture, np.float64)
    if levels.ndim == 3:
        levels = levels[..., :3].mean(axis=2)  # without the alpha channel
    if max(levels.shape) > _LONGEST:
        raise InputError(path, f"a picture of at most {_LONGEST} px a side", f"one of {levels.shape[::-1]}")
    if not levels.sum() > 0.0:
        raise InputError(path, "a picture of a pattern with some light", "a black one")
    return (levels / levels.sum()).astype(np.float32)
