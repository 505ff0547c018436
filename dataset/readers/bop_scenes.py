"""Which images of a BOP folder show one scene.

A folder of rendered images (``train_pbr``) holds many scenes, and their poses are in several worlds. Images whose
objects stand at the same places in the world show one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Greatest distance between the places of an object that stands still [m]: poses are rounded and refined image by
#: image.
_STILL = 0.005


def scene_names(base: str, numbers: Sequence[int], at: Sequence[np.ndarray | None]) -> list[str]:
    """Return the scene of each image, by the places of its objects in the world.

    Parameters
    ----------
    base : str
        Name of the folder.
    numbers : sequence of int
        Numbers of the images, in order.
    at : sequence of (n, 4) arrays or None
        From `bop_records.places`; an image without a pose is a scene of its own.
    """
    names, last, current = [], None, ""
    for number, rows in zip(numbers, at, strict=True):
        if rows is None or last is None or not _same(rows, last):
            current = f"{base}/{number:06d}"
        names.append(current)
        last = rows
    return names


def _same(rows: np.ndarray, last: np.ndarray) -> bool:
    if rows.shape != last.shape or not rows.size:
        return False
    return bool((rows[:, 0] == last[:, 0]).all() and np.abs(rows[:, 1:] - last[:, 1:]).max() < _STILL)
