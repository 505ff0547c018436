"""In which direction a data set states the poses of its cameras, where it does not say.

Objects stand still: of both directions the right one brings an object to one place in the world from all cameras.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Literal

import numpy as np

from ...annotate.projection import inverse_pose

#: Greatest mean distance between the places of an object, by the right direction [m].
_STILL = 0.02
#: By the wrong direction the places must be this many times as far apart; else the cameras hardly moved.
_CLEARER = 3.0
#: Most cameras that are compared.
_MOST = 24

Direction = Literal["stated", "inverse"]


def camera_to_world(cameras: Sequence[tuple[np.ndarray | None, Mapping[Hashable, np.ndarray]]]) -> Direction | None:
    """Return whether stated poses or their inverses go from the camera to the world; None where it does not follow.

    Parameters
    ----------
    cameras : sequence of ((4, 4) array or None, mapping)
        The stated pose of each camera, and in its frame the poses of objects, by anything that names an object.
    """
    step = max(1, len(cameras) // _MOST)
    chosen = [(pose, objects) for pose, objects in cameras[::step] if pose is not None]
    if len(chosen) < 2 or len(chosen) < len(cameras[::step]):
        return None
    spread = {"stated": _spread(chosen, False), "inverse": _spread(chosen, True)}
    best: Direction = "stated" if spread["stated"] <= spread["inverse"] else "inverse"
    worst = max(spread.values())
    return best if spread[best] < _STILL and worst > _CLEARER * spread[best] else None


def _spread(cameras: Sequence[tuple[np.ndarray, Mapping[Hashable, np.ndarray]]], inverse: bool) -> float:
    """Return how far apart the places of an object are, mean over all objects [m]; infinite without a common one."""
    places: dict[Hashable, list[np.ndarray]] = {}
    for pose, objects in cameras:
        world_T_camera = inverse_pose(pose) if inverse else pose
        for name, camera_T_object in objects.items():
            places.setdefault(name, []).append((world_T_camera @ camera_T_object)[:3, 3])
    shared = [np.array(rows) for rows in places.values() if len(rows) > 1]
    if not shared:
        return float("inf")
    return float(np.mean([np.linalg.norm(rows - rows.mean(axis=0), axis=1).mean() for rows in shared]))
