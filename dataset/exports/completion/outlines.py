"""Outlines of objects as ClearGrasp tells them apart: where depth jumps, and where an object touches what is behind."""

from __future__ import annotations

import numpy as np

#: Classes of pixels, by ClearGrasp's numbers.
NONE, OCCLUSION, CONTACT = 0, 1, 2
#: Change of depth between neighbours that is a jump, beyond what the surfaces' slopes explain [m]: vessels stand some
#: millimetres apart from nothing that they touch, and a pixel at half a metre is 1 mm wide.
JUMP = 5e-3


def outlines(Z: np.ndarray, ids: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return the class of each pixel, (H, W) uint8.

    A pixel on an object is on an outline where one of its four neighbours shows something else. It is an occlusion
    boundary where depth jumps there, else a contact edge; of a pixel with both kinds of neighbours the first counts.
    The depth of the neighbour is compared with the pixel's own continued at its slope, so that a table seen at a
    grazing angle does not jump.

    Parameters
    ----------
    Z : (H, W) float
        Planar depth of the first surface [m]; +inf for none.
    ids : (H, W) integer
        What it is on.
    chosen : (H, W) bool
        Pixels of the objects whose outlines are asked for.
    """
    found = np.zeros(Z.shape, np.uint8)
    depth = np.where(np.isfinite(Z), Z, 0.0).astype(np.float64)
    for axis in (0, 1):
        for step in (1, -1):
            other_id, other, beyond = (
                _shifted(values, axis, step) for values in (ids, depth, _shifted(depth, axis, step))
            )
            inside = _shifted(np.ones(Z.shape, bool), axis, step)
            edge = chosen & inside & (other_id != ids)
            slope = np.where((_shifted(other_id, axis, step) == other_id) & (beyond > 0.0), other - beyond, 0.0)
            jump = (other == 0.0) | (np.abs(depth - other - slope) > JUMP)
            found[edge & ~jump & (found == NONE)] = CONTACT
            found[edge & jump] = OCCLUSION
    return found


def _shifted(values: np.ndarray, axis: int, step: int) -> np.ndarray:
    """Return the values of the neighbours along an axis; 0 beyond the edge of the picture."""
    moved = np.roll(values, -step, axis)
    edge = [slice(None)] * values.ndim
    edge[axis] = slice(-1, None) if step > 0 else slice(0, 1)
    moved[tuple(edge)] = 0
    return moved
