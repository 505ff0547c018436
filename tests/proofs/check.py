"""One comparison with a law: the closed form, the measurement, and how far a right renderer may be off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

#: Half the spacing of float32 numbers near 1: the most that one rounding changes, as a share.
EPS = 2.0**-24
#: Roundings in a row that one interface takes: interpolating the normal, normalising it, the cosine, Snell's square
#: root, the new direction, normalising that. They are added up as if all went one way.
ROUNDINGS = 16
#: Probability that one statistical comparison fails without any fault.
FALSE_ALARM = 1e-4


@dataclass(frozen=True)
class Check:
    """One quantity."""

    name: str
    expected: float
    measured: float
    unit: str  #: of both
    error: float  #: distance of the two; the largest of all that were measured
    error_unit: str  #: of `error`, `limit` and `bound`
    limit: float  #: what rounding, facets and noise explain at most
    basis: str  #: where `limit` comes from
    share: float  #: largest share of its limit that any of them uses: at most 1 in a right renderer
    bound: float | None = None  #: what the project promises; None where `limit` is all there is to ask


def worst(
    name: str,
    expected: ArrayLike,
    measured: ArrayLike,
    limit: ArrayLike,
    basis: str,
    *,
    unit: str = "",
    relative: bool = False,
    bound: float | None = None,
) -> Check:
    """Return the check of arrays of one shape: the entry with the largest error, and the most that any limit is used.

    Parameters
    ----------
    name : str
        The quantity.
    expected, measured, limit : array or float
        Closed form, measurement, and the largest difference that is explained, in the unit of the error.
    basis : str
        Where the limit comes from.
    unit : str
        Unit of the quantity.
    relative : bool
        Whether error, limit and bound are percentages of the closed form; in `unit` otherwise.
    bound : float, optional
        What the project promises, in the unit of the error.
    """
    expected, measured, limit = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(v, np.float64)) for v in (expected, measured, limit))
    )
    if not np.isfinite(measured).all():
        raise ValueError(f"{name}: expected numbers, measured {measured}")
    error = np.abs(measured - expected) * (100.0 / np.abs(expected) if relative else 1.0)
    at = np.unravel_index(np.argmax(error), error.shape)
    return Check(
        name=name,
        expected=float(expected[at]),
        measured=float(measured[at]),
        unit=unit,
        error=float(error[at]),
        error_unit="%" if relative else unit,
        limit=float(limit[at]),
        basis=basis,
        share=float((error / limit).max()),
        bound=bound,
    )


def single(name: str, expected: float, measured: float, error: float, unit: str, limit: float, basis: str) -> Check:
    """Return the check of one number whose error is not a plain difference, such as a test statistic."""
    share = error / limit if limit > 0.0 else float("inf") if error > 0.0 else 0.0
    numbers = float(expected), float(measured), unit, float(error), unit, float(limit)
    return Check(name, *numbers, basis, float(share))


def mean_check(name: str, expected: float, values: np.ndarray, rounding: float, bound: float | None) -> Check:
    """Return the check of a mean of independent samples, relative to its closed form.

    Parameters
    ----------
    name : str
        The quantity.
    expected : float
        Closed form.
    values : (n,) float
        The samples.
    rounding : float
        Relative error of one sample by float32.
    bound : float, optional
        What the project promises [%].
    """
    values = np.asarray(values, np.float64)
    standard_error = values.std(ddof=1) / np.sqrt(len(values))
    limit = stats.norm.isf(FALSE_ALARM / 2) * standard_error / abs(expected) + rounding
    basis = f"noise of {len(values)} paths, false alarm {FALSE_ALARM:g}"
    return worst(name, expected, values.mean(), 100.0 * limit, basis, relative=True, bound=bound)
