"""Cut the inside of a vessel at the line where a liquid meets it."""

from __future__ import annotations

import numpy as np

from .curve import Curve

#: A point of the profile nearer to the contact line than this is moved onto it instead of making a needle [m];
#: a tenth of the finest chord error that the settings allow.
CONTACT_MERGE = 2e-7


def normal_at(inner: Curve, height: float) -> np.ndarray:
    """Return the inner curve's unit normal (2,) at a height [m] above its floor, between those of its points."""
    normal = np.array([np.interp(height, inner.points[:, 1], column) for column in inner.normals.T])
    return normal / np.hypot(*normal)


def cut_at(inner: Curve, contact: np.ndarray) -> tuple[Curve, Curve]:
    """Return the inner curve below and above a point on it, both ending in exactly that point.

    Parameters
    ----------
    inner : Curve
        From the floor up; z never falls.
    contact : (2,) float
        A point (r, z) on the curve's polygon, above the floor and below the crown [m].
    """
    z = inner.points[:, 1]
    if not z[0] < contact[1] < z[-1]:
        raise ValueError(f"contact: expected a height between {z[0]} and {z[-1]}, got {contact[1]}")
    normal = normal_at(inner, contact[1])
    below, above = z < contact[1] - CONTACT_MERGE, z > contact[1] + CONTACT_MERGE
    point, normal = np.array([contact]), normal[None]
    return (
        Curve(np.concatenate([inner.points[below], point]), np.concatenate([inner.normals[below], normal])),
        Curve(np.concatenate([point, inner.points[above]]), np.concatenate([normal, inner.normals[above]])),
    )
