"""Thin convex parts made as thick as a simulation needs: sheets, strips and slivers of cuts have next to no volume."""

from __future__ import annotations

from itertools import product

import numpy as np

#: Least extent of a convex part in any direction [m]: half of what paper is thick, and a third of what wedges may reach
#: beyond their solid. MuJoCo computes hulls in single precision, which at 0.3 m from the origin is 3e-8 m.
LEAST_THICKNESS = 5e-5


def thickened(points: np.ndarray) -> np.ndarray:
    """Return the corners (n, 3) of a convex body around points, at least `LEAST_THICKNESS` thick along all their axes.

    A body that is thick enough is returned as it is. Along the other principal axes of its corners half of what is
    missing is added on both sides, so that the body stays where it is.
    """
    middle = points.mean(0)
    axes = np.linalg.eigh((points - middle).T @ (points - middle))[1].T
    missing = LEAST_THICKNESS - np.ptp((points - middle) @ axes.T, axis=0)
    if (missing <= 0.0).all():
        return points
    # A body that is thin along two axes is a strip, and gets a rectangle for its section.
    shifts = [(-0.5 * lack, 0.5 * lack) if lack > 0.0 else (0.0,) for lack in missing]
    return np.concatenate([points + np.array(shift) @ axes for shift in product(*shifts)])
