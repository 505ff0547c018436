"""Keypoints of an object in one view that all methods are compared on, and the orders of them that look the same."""

from __future__ import annotations

from typing import Literal

import numpy as np

from .objects import ViewObject

#: Cosine below which a motion turns the z axis over: symmetries keep it or reverse it, to rounding.
_REVERSED = -0.99


def axis_points(item: ViewObject) -> np.ndarray:
    """Return the middle of the top and of the bottom of an object's box, (2, 3) in its frame [m].

    Objects of revolution have no other points that pictures define, and KeyPose's bottles, cups and trees have these
    two. Of a ball both are the centre.
    """
    half = 0.0 if item.symmetry.ball else item.size[2] / 2.0
    return np.array([[0.0, 0.0, half], [0.0, 0.0, -half]])


def object_keypoints(
    item: ViewObject,
    stored: np.ndarray,
    kind: Literal["axis", "stored"] = "axis",
    orderings: tuple[str, ...] = (),
) -> tuple[np.ndarray, np.ndarray]:
    """Return the keypoints of an object and their orders that look the same.

    Parameters
    ----------
    item : ViewObject
        The object.
    stored : (k, 3) float
        Its keypoints of ``objects.json`` [m].
    kind : str
        ``axis`` for `axis_points`, whose two orders look the same where the object does upside down; ``stored``.
    orderings : tuple of str
        Orders of the stored ones, such as ``1-0-2``; the stored order is always one.

    Returns
    -------
    points : (K, 3) float64
        In the object frame [m].
    orders : (n, K) int
        Numbers of the points.
    """
    if kind == "axis":
        reversible = bool((item.symmetry.motions[:, 2, 2] < _REVERSED).any())
        return axis_points(item), np.array([[0, 1], [1, 0]] if reversible else [[0, 1]])
    orders = [list(range(len(stored))), *(parsed_order(text) for text in orderings)]
    return stored, np.array(orders)


def parsed_order(text: str) -> list[int]:
    """Return the numbers of an order such as ``1-0-2``."""
    return [int(number) for number in text.split("-")]


def keypoint_distances(found: np.ndarray, true: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Return the distances of keypoints in the order of the least mean, (K,) [m].

    Parameters
    ----------
    found, true : (K, 3) float
        Keypoints in one frame [m].
    orders : (n, K) int
        Orders of the true ones that look the same.
    """
    distances = np.linalg.norm(found[None] - true[orders], axis=2)
    return distances[distances.mean(1).argmin()]
