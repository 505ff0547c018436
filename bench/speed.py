"""Error against time for two renderers, and the time that each needs for the same error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Point:
    """One number of samples: what it took and how far from the reference it is."""

    spp: int
    seconds: float  #: tracing and denoising
    noisy: float  #: relMSE before denoising
    clean: float  #: relMSE after denoising


def time_to(curve: list[Point], error: float) -> tuple[float, bool]:
    """Return the time at which the denoised picture has an error, and whether the curve reaches it.

    Between measured points the logarithms are interpolated; beyond them the last stretch is drawn on, which the second
    value (False) tells.

    Parameters
    ----------
    curve : list of Point
        At least two, by growing number of samples.
    error : float
        relMSE after denoising.
    """
    # Points that another one beats in both time and error do not count: error falls along the curve.
    better = [p for p in curve if not any(q.seconds <= p.seconds and q.clean <= p.clean for q in curve if q is not p)]
    better.sort(key=lambda point: point.seconds)
    if len(better) < 2:
        return (better[0].seconds, better[0].clean <= error)
    x = np.log([point.clean for point in better])
    y = np.log([point.seconds for point in better])
    target = np.log(error)
    # x falls: the stretch is the one whose ends hold the target, else the first or the last.
    k = int(np.clip(np.searchsorted(-x, -target) - 1, 0, len(better) - 2))
    slope = (y[k + 1] - y[k]) / (x[k + 1] - x[k])
    return float(np.exp(y[k] + slope * (target - x[k]))), bool(x[-1] <= target <= x[0])


def rate(curve: list[Point], pixels: int) -> float:
    """Return samples a second from the growth of time between the fewest and the most samples.

    What a picture costs once, such as the denoiser, does not count.
    """
    first, last = curve[0], curve[-1]
    return (last.spp - first.spp) * pixels / (last.seconds - first.seconds)
