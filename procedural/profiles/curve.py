"""Curves in the half plane of revolution: dense points with exact normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Largest turn of the normal along one segment of a simplified profile [rad]. Half of it is the largest angle between
#: a vertex normal and its facet; 10 degrees keep the refraction through interpolated normals smooth at rims.
MAX_TURN = np.radians(10.0)
#: Longest segment of a simplified profile [m]: keeps triangles on straight walls from becoming needles.
MAX_LENGTH = 0.01
#: Angle between neighbouring points of a dense arc [rad]: 0.6 um of chord error at a radius of 4 mm.
ARC_STEP = np.radians(2.0)


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve in the half plane r >= 0.

    A duplicated point with two normals is a crease.

    Parameters
    ----------
    points : (n, 2) float64
        Rows (r, z) [m].
    normals : (n, 2) float64
        Unit normals, rows (n_r, n_z).
    """

    points: np.ndarray
    normals: np.ndarray

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2 or self.points.shape != self.normals.shape:
            raise ValueError(f"expected two (n, 2) arrays, got {self.points.shape} and {self.normals.shape}")


def backwards(curve: Curve) -> Curve:
    """Return the curve in the opposite direction, with the same normals."""
    return Curve(curve.points[::-1], curve.normals[::-1])


def chained(*curves: Curve) -> Curve:
    """Return one curve of several, each beginning where the one before ends; the common points appear once."""
    points = [curves[0].points, *(curve.points[1:] for curve in curves[1:])]
    normals = [curves[0].normals, *(curve.normals[1:] for curve in curves[1:])]
    return Curve(np.concatenate(points), np.concatenate(normals))


def arc(centre: np.ndarray, radius: float, start: float, end: float) -> Curve:
    """Return a circular arc whose normals point away from its centre.

    Parameters
    ----------
    centre : (2,) float
        Centre (r, z) [m].
    radius : float
        Radius [m].
    start, end : float
        Angles of the normals, from +r towards +z [rad].
    """
    count = max(2, int(np.ceil(abs(end - start) / ARC_STEP)) + 1)
    normals = directions(np.linspace(start, end, count))
    return Curve(centre + radius * normals, normals)


def directions(angles: np.ndarray) -> np.ndarray:
    """Return unit vectors (n, 2) at angles from +r towards +z [rad]."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def simplified(curve: Curve, tolerance: float) -> Curve:
    """Return the curve with as few of its points as the tolerance allows, both ends included.

    Each segment is the longest from its start (found by doubling and halving) that leaves no dropped point farther
    than ``tolerance`` from it, turns the normal by at most `MAX_TURN` and is no longer than `MAX_LENGTH`.

    Parameters
    ----------
    curve : Curve
        A dense, smooth curve.
    tolerance : float
        Largest distance of a dropped point from its segment [m].
    """
    kept = kept_points(curve, tolerance)
    return Curve(curve.points[kept], curve.normals[kept])


def kept_points(curve: Curve, tolerance: float) -> list[int]:
    """Return the numbers of the points that `simplified` keeps."""
    last, kept = len(curve.points) - 1, [0]
    while kept[-1] < last:
        start, good, step = kept[-1], kept[-1] + 1, 2
        while start + step <= last and _fits(curve, start, start + step, tolerance):
            good, step = start + step, 2 * step
        bad = min(start + step, last + 1)
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if _fits(curve, start, middle, tolerance) else (good, middle)
        kept.append(good)
    return kept


def _fits(curve: Curve, start: int, end: int, tolerance: float) -> bool:
    origin = curve.points[start]
    chord = curve.points[end] - origin
    length = float(np.hypot(*chord))
    if length > MAX_LENGTH or (curve.normals[start : end + 1] @ curve.normals[start]).min() < np.cos(MAX_TURN):
        return False
    inner = curve.points[start + 1 : end] - origin
    return bool(np.abs(inner[:, 0] * chord[1] - inner[:, 1] * chord[0]).max(initial=0.0) <= tolerance * length)
