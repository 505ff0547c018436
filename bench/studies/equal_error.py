"""Error against time of two ways to render, and the time that each needs to reach the same error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from picture import Picture
from references import Reference
from table import Row


@dataclass(frozen=True)
class Point:
    """One number of samples: what it took and how far from the reference it is."""

    spp: int
    seconds: float  #: tracing and denoising
    noisy: float  #: relMSE before denoising
    clean: float  #: relMSE after denoising


@dataclass(frozen=True, eq=False)
class Way:
    """One way to render the same view."""

    render: Callable[[int, int], Picture]  #: from samples per pixel and seed
    reference: Reference


def measure(
    ways: Sequence[Way], spp: Iterable[int], repeats: int, exposure: float, show: Callable[[int, list[Picture]], None]
) -> list[list[Point]]:
    """Return the curve of each way; they alternate, so that other load of the machine affects both.

    Parameters
    ----------
    ways : sequence of Way
        The ways.
    spp : iterable of int
        Samples per pixel.
    repeats : int
        Pictures with different seeds that each point is the mean of.
    exposure : float
        Exposure of the pictures.
    show : callable
        Receives the number of samples and one picture of each way.
    """
    curves: list[list[Point]] = [[] for _ in ways]
    for samples in sorted(set(spp)):
        found = []
        for repeat in range(repeats):
            made = [way.render(samples, repeat + 1) for way in ways]
            found.append([(x.seconds, *x.errors(exposure, w.reference)) for x, w in zip(made, ways, strict=True)])
            show(samples, made)
        for curve, means in zip(curves, np.mean(found, axis=0), strict=True):
            curve.append(Point(samples, *map(float, means)))
    return curves


def curve_rows(name: str, ours: list[Point], peer: list[Point]) -> list[Row]:
    """Return the points of two curves side by side."""
    rows = []
    for a, b in zip(ours, peer, strict=True):
        at = f"{name}, {a.spp} spp:"
        rows += [
            Row(f"{at} tracing and denoising", a.seconds, "s", peer=b.seconds, ratio=b.seconds / a.seconds),
            Row(f"{at} relMSE before denoising", a.noisy, peer=b.noisy, ratio=b.noisy / a.noisy),
            Row(f"{at} relMSE after denoising", a.clean, peer=b.clean, ratio=b.clean / a.clean),
        ]
    return rows


def time_to(curve: list[Point], error: float) -> tuple[float, bool]:
    """Return the time at which the denoised picture has an error, and whether the curve reaches it.

    Between measured points the logarithms are interpolated; beyond them the last segment is extrapolated, and the
    second value is False.

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
    # x falls: the segment is the one whose ends enclose the target, else the first or the last.
    k = int(np.clip(np.searchsorted(-x, -target) - 1, 0, len(better) - 2))
    slope = (y[k + 1] - y[k]) / (x[k + 1] - x[k])
    return float(np.exp(y[k] + slope * (target - x[k]))), bool(x[-1] <= target <= x[0])


def rate(curve: list[Point], pixels: int) -> float:
    """Return samples a second from the growth of time between the fewest and the most samples.

    Fixed costs of a picture, such as the denoiser, do not count.
    """
    first, last = curve[0], curve[-1]
    return (last.spp - first.spp) * pixels / (last.seconds - first.seconds)
