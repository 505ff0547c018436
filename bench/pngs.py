"""Exposed linear pictures as PNG files, for looking at."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glassware.core.images import srgb8
from glassware.dataset.format.pictures import write_png


def write_exposed(path: Path, *exposed: np.ndarray) -> None:
    """Write pictures in exposed linear units, each (H, W, 3), one below the other as 8-bit sRGB."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, np.concatenate([srgb8(picture, 1.0) for picture in exposed]))


def write_signed(path: Path, values: np.ndarray, limit: float) -> None:
    """Write a map of signed numbers, (H, W): 0 is white, `limit` and above red, minus `limit` and below blue."""
    path.parent.mkdir(parents=True, exist_ok=True)
    share = np.clip(values / limit, -1.0, 1.0)
    high, low = 1.0 - np.maximum(-share, 0.0), 1.0 - np.maximum(share, 0.0)
    picture = np.stack([high, np.minimum(high, low), low], axis=-1)
    write_png(path, np.rint(255.0 * picture).astype(np.uint8))
