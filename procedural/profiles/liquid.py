"""How high a liquid stands in a vessel: volumes and levels from the inner profile."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root_scalar

from ...core.errors import InputError

#: Least distance of the contact line below the rim's crown [m]: below the rim's rounding, whose radius is up to half
#: of the thickest wall (2 mm).
RIM_MARGIN = 2.5e-3
#: Largest error of a level found from a volume [m].
LEVEL_TOLERANCE = 1e-12
#: By how much a volume may be above the most that fits [1]: sums of frusta in another order differ by 1e-12.
ROUNDING = 1e-9


def volume_below(inner: np.ndarray, level: float) -> float:
    """Return the volume that the inside holds up to a level [m^3]: the exact sum of its frusta.

    A frustum of height h between radii a and b holds pi h (a^2 + a b + b^2) / 3.

    Parameters
    ----------
    inner : (n, 2) float
        Inner profile, rows (r, z), from the axis at the floor up; z never falls [m].
    level : float
        Height in the profile's frame [m].
    """
    points = np.asarray(inner, dtype=np.float64)
    z = np.minimum(points[:, 1], level)
    return float(_frusta(_radius_at(points, z), z).sum())


def brimful_volume(inner: np.ndarray) -> float:
    """Return the volume up to the crown of the rim [m^3]."""
    points = np.asarray(inner, dtype=np.float64)
    return float(_frusta(points[:, 0], points[:, 1]).sum())


def highest_contact(inner: np.ndarray) -> float:
    """Return the highest that a liquid may reach on the wall [m]: `RIM_MARGIN` below the rim's crown."""
    return float(np.asarray(inner)[-1, 1]) - RIM_MARGIN


def level_of_volume(inner: np.ndarray, volume: float) -> float:
    """Return the level at which the inside holds a volume under a flat surface [m].

    Parameters
    ----------
    inner : (n, 2) float
        Inner profile [m].
    volume : float
        Volume [m^3].

    Raises
    ------
    InputError
        Where the volume is not positive, or the level would be less than `RIM_MARGIN` below the rim's crown.
    """
    most = volume_below(inner, highest_contact(inner))
    if not 0.0 < volume <= (1.0 + ROUNDING) * most:
        raise InputError("liquid.volume", f"more than 0 and at most {most:.3e} m^3 (below the rim)", f"{volume:.3e}")
    bracket = (float(np.asarray(inner)[0, 1]), highest_contact(inner))
    volume = min(volume, most)
    return root_scalar(lambda z: volume_below(inner, z) - volume, bracket=bracket, xtol=LEVEL_TOLERANCE).root


def level_of_fill(inner: np.ndarray, fill: float) -> float:
    """Return the level at which a fraction of the brimful volume is filled [m]; InputError as `level_of_volume`."""
    most = volume_below(inner, highest_contact(inner)) / brimful_volume(inner)
    if not 0.0 < fill <= most:
        raise InputError("liquid.fill", f"more than 0 and at most {most:.4f} (below the rim)", fill)
    return level_of_volume(inner, min(fill, most) * brimful_volume(inner))


def _frusta(r: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.pi / 3.0 * np.diff(z) * (r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2)


def _radius_at(points: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Radius of the profile where its own points are clipped to a level: exact on the cut segment."""
    r = points[:, 0].copy()
    cut = z < points[:, 1]
    # Above the level all heights are equal, so only the first cut point's radius counts; at a flat floor the points
    # are not cut and keep their own.
    r[cut] = np.interp(z[cut], points[:, 1], points[:, 0])
    return r
