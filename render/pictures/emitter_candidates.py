"""Emitter sampling with several candidates: resampled importance sampling (RIS) of what a surface reflects.

A glossy lobe mirrors few of the directions in which a scene is bright, and one sample of emitter sampling seldom meets
both: a lamp in a brushed table is noise then. So several samples are drawn, the surface's reflection is
evaluated for each, and a shadow ray is traced to one, chosen by how much it would reflect without shadows (Talbot,
Cline, Egbert 2005, "Importance Resampling for Global Illumination"). With n candidates of density p, next to BSDF
sampling of density q, the balance heuristic (Veach 1997, eq. 9.8) gives a candidate the weight n p / (n p + q), and the
n of them estimate what is reflected, f, by

    sum over candidates of f / (n p + q)    =    1/n  sum over candidates of f / p  p / (p + q / n).

Tracing one, chosen with the probability P, divides its term by P. That is unbiased for any P above 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .._mitsuba import dr, mi, syntax

#: Shift from one candidate to the next along the second number [1]: the golden ratio's fraction. With equal steps along
#: the first, candidates are points of a lattice that is shifted as a whole, so each of them is uniform.
_GOLDEN = 0.6180339887
#: Largest float32 below 1.
_BELOW_ONE = 1.0 - 2.0**-24


@dataclass(frozen=True, eq=False)
class Candidate:
    """The sample of emitter sampling that was chosen."""

    u: mi.Point2f  #: its sample point
    weight: mi.Float  #: 1 / (n P), a factor on its estimate; 0 where no candidate is reflected
    left: mi.Float  #: a number that is uniform again, in [0, 1)


def candidates_of(column: mi.UInt32 | None, row: mi.UInt32, direct: mi.Bool) -> mi.UInt32 | None:
    """Return the number of candidates of surfaces by registry id; None where all have one (`SurfaceTable`).

    Surfaces that the eye does not see directly have one: glass, through which most others are seen, gets sixteen times
    the samples already.
    """
    return None if column is None else dr.select(direct, dr.gather(mi.UInt32, column, row), 1)


def per_candidate(pdf: mi.Float, count: mi.UInt32 | None) -> mi.Float:
    """Return the density of BSDF sampling over the number of candidates: what MIS compares with the density of one."""
    return pdf if count is None else pdf / mi.Float(count)


def chosen_candidate(
    u: mi.Point2f, u_choice: mi.Float, count: mi.UInt32 | None, reflected: Callable[[mi.Point2f], mi.Float]
) -> Candidate:
    """Choose one of several samples of emitter sampling, in proportion to what is reflected of it.

    Parameters
    ----------
    u : mi.Point2f
        The first sample point, uniform in the unit square.
    u_choice : mi.Float
        The number that chooses, uniform in [0, 1).
    count : mi.UInt32, optional
        Number of candidates n; None: one, which is the first sample itself.
    reflected : callable
        Takes a sample point, and returns what the surface reflects of that sample without shadows: over its density,
        with its MIS weight, and above 0 wherever it counts.
    """
    if count is None:
        return Candidate(u, mi.Float(1.0), u_choice)
    return _chosen(u, u_choice, count, reflected)


@syntax
def _chosen(
    u: mi.Point2f, u_choice: mi.Float, count: mi.UInt32, reflected: Callable[[mi.Point2f], mi.Float]
) -> Candidate:
    at, total, value, left, k = mi.Point2f(u), mi.Float(0.0), mi.Float(0.0), mi.Float(u_choice), mi.UInt32(0)
    step = dr.rcp(mi.Float(count))
    while dr.hint(k < count, exclude=[reflected, u, count, step]):
        shifted = u + mi.Point2f(step, _GOLDEN) * mi.Float(k)
        shifted -= dr.floor(shifted)
        found = reflected(shifted)
        total += found
        # Reservoir sampling; what is left of the number within its interval is uniform again (sample reuse).
        probability = dr.select(found > 0.0, found / total, 0.0)
        accepted = left < probability
        left = dr.select(accepted, left, left - probability) / dr.select(accepted, probability, 1.0 - probability)
        left = dr.clip(left, 0.0, _BELOW_ONE)
        at, value = dr.select(accepted, shifted, at), dr.select(accepted, found, value)
        k += 1
    return Candidate(at, dr.select(value > 0.0, total / value * step, 0.0), left)
