"""Lines of sight: how far one sees from a point towards others."""

from __future__ import annotations

import numpy as np

from .._mitsuba import dr, mi
from ..frame import LineOfSight
from ..scene.loaded_scene import LoadedScene
from .geometry import straight


def line_of_sight(kernel: LoadedScene, origin: np.ndarray, points: np.ndarray) -> LineOfSight:
    """Trace from `origin` towards each point.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene.
    origin : (3,) float
        The eye, world frame [m].
    points : (n, 3) float
        Targets, world frame [m].
    """
    if len(points) == 0:
        return LineOfSight(np.zeros(0), np.zeros(0))
    direction = dr.normalize(mi.Vector3f(np.ascontiguousarray((points - origin).T, dtype=np.float32)))
    start = dr.opaque(mi.Float, 0.0) + mi.Point3f(np.asarray(origin, dtype=np.float32))
    seen = straight(kernel, mi.Ray3f(start, direction))
    dr.eval(seen)
    return LineOfSight(np.array(seen.first, np.float64), np.array(seen.background, np.float64))
