"""Polarised light at one facet: Fresnel's amplitudes as Mueller matrices, and the frames that Stokes vectors stand in.

A Stokes vector (s0, s1, s2, s3) is given in a right-handed frame (x, y, f), f the direction in which the light travels:
s1 > 0 is light that swings along x, s2 > 0 half-way from x to y, s3 > 0 turns clockwise for who faces the light. Paths
are traced against the light. The Mueller matrix of a path takes light that arrives at its end to what the camera gets
of it: the next event is multiplied from the right.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi

#: Square of the sine below which light counts as meeting a facet straight on [1]: float32 has no plane of incidence
#: left there, and none is needed, for Fresnel's matrices then look the same from every side.
_STRAIGHT = 1e-12
#: Least probability that is divided by: an outcome so rare is never drawn, but float32 must not overflow.
_LEAST = 1e-20


@dataclass(frozen=True, eq=False)
class Shares:
    """What a smooth facet does to light: the matrix [[m, d, 0, 0], [d, m, 0, 0], [0, 0, c, -e], [0, 0, e, c]].

    m and d are half the sum and half the difference of the shares of both polarisations. The frame's x is perpendicular
    to the plane of incidence on both sides.
    """

    s: mi.Float  #: share of the power that swings perpendicular to the plane of incidence
    p: mi.Float  #: share of the power that swings in it
    c: mi.Float
    e: mi.Float


@dataclass(eq=False)  # not frozen: Dr.Jit writes into what changes in a loop
class Mueller:
    """A Mueller matrix of numbers that hold for all wavelengths, by its columns."""

    of_s0: mi.Vector4f
    of_s1: mi.Vector4f
    of_s2: mi.Vector4f
    of_s3: mi.Vector4f


def identity() -> Mueller:
    """Return the matrix that changes nothing."""
    return Mueller(*(mi.Vector4f(*(float(row == column) for row in range(4))) for column in range(4)))


def as_matrix(M: Mueller) -> mi.Matrix4f:
    """Return it as Mitsuba wants it."""
    columns = (M.of_s0, M.of_s1, M.of_s2, M.of_s3)
    return mi.Matrix4f(*(columns[column][row] for row in range(4) for column in range(4)))


def fresnel_shares(cos_i: mi.Float, cos_t: mi.Float, eta: mi.Float) -> tuple[Shares, Shares]:
    """Return what an interface mirrors and what it lets through.

    Born and Wolf 1999, "Principles of Optics", section 1.5.2, eq. 20a and 21a (amplitudes), 14 and 15 (shares); beyond
    the critical angle section 1.5.4, eq. 61 (the difference of the phases). Their vector p is turned round here in all
    beams alike, which changes no matrix.

    Parameters
    ----------
    cos_i, cos_t : mi.Float
        Cosines of the angles to the normal before and behind the interface, >= 0; `cos_t` is 0 where reflection is
        total.
    eta : mi.Float
        Index behind the interface over the index before it.
    """
    a, eta2 = eta * cos_t, dr.square(eta)
    by_s, by_p = dr.rcp(cos_i + a), dr.rcp(dr.fma(eta2, cos_i, a))
    r_s, r_p = (cos_i - a) * by_s, dr.fma(eta2, cos_i, -a) * by_p
    sin2 = 1.0 - dr.square(cos_i)
    lag = cos_i * dr.sqrt(dr.maximum(sin2 - eta2, 0.0))  # tangent of half the phase difference, times sin2
    scale = dr.rcp(dr.square(sin2) + dr.square(lag))
    total = cos_t == 0.0
    c = dr.select(total, (dr.square(sin2) - dr.square(lag)) * scale, r_s * r_p)
    e = dr.select(total, 2.0 * sin2 * lag * scale, 0.0)
    mirrored = Shares(dr.square(r_s), dr.square(r_p), c, e)
    passed = 4.0 * a * cos_i
    crossed = eta * passed * by_s * by_p
    return mirrored, Shares(passed * dr.square(by_s), eta2 * passed * dr.square(by_p), crossed, mi.Float(0.0))


def across(facet: mi.Vector3f, towards: mi.Vector3f, axis: mi.Vector3f) -> mi.Vector3f:
    """Return the unit vector perpendicular to the plane of incidence; `axis` where there is none."""
    normal = dr.cross(facet, towards)
    sin2 = dr.squared_norm(normal)
    return dr.select(sin2 > _STRAIGHT, normal * dr.rsqrt(dr.maximum(sin2, _STRAIGHT)), axis)


def turned(M: Mueller, axis: mi.Vector3f, to: mi.Vector3f, forward: mi.Vector3f) -> Mueller:
    """Return the matrix for light that is given in the frame with x along `to` instead of `axis`.

    Parameters
    ----------
    M : Mueller
        The matrix.
    axis, to : mi.Vector3f
        Unit vectors perpendicular to `forward`.
    forward : mi.Vector3f
        Unit direction in which the light travels.
    """
    cos, sin = dr.dot(to, axis), dr.dot(dr.cross(to, axis), forward)
    scale = dr.rcp(dr.square(cos) + dr.square(sin))  # rounding must not make light from nothing
    c2, s2 = (dr.square(cos) - dr.square(sin)) * scale, 2.0 * cos * sin * scale
    return Mueller(M.of_s0, M.of_s1 * c2 - M.of_s2 * s2, M.of_s1 * s2 + M.of_s2 * c2, M.of_s3)


def then(M: Mueller, event: Shares, scale: mi.Float) -> Mueller:
    """Return the matrix for light that has yet to meet the facet, whose matrix is multiplied by `scale`."""
    m, d = 0.5 * scale * (event.s + event.p), 0.5 * scale * (event.s - event.p)
    c, e = scale * event.c, scale * event.e
    return Mueller(
        M.of_s0 * m + M.of_s1 * d, M.of_s0 * d + M.of_s1 * m, M.of_s2 * c + M.of_s3 * e, M.of_s3 * c - M.of_s2 * e
    )


def drawn(
    M: Mueller, analyser: mi.Vector4f, mirrored: Shares, passed: Shares, total: mi.Bool, coin: mi.Float
) -> tuple[Mueller, mi.Bool]:
    """Draw one outcome of a facet; return the matrix with it, over its probability, and whether it mirrors.

    The probability of each outcome is the share of unpolarised light behind the facet that the outcome brings to the
    camera. So the brightness of the path stays what it is, through any number of events: with the shares of unpolarised
    light it would wander, ever more on long paths, for the camera's filter is polarised by the events in between.

    Parameters
    ----------
    M : Mueller
        What leads from the facet to the place of `analyser`.
    analyser : mi.Vector4f
        Row of the matrix from there to the camera that makes the brightness, with 1 in its first place.
    mirrored, passed : Shares
        The facet's outcomes.
    total : mi.Bool
        Whether it mirrors everything.
    coin : mi.Float
        Uniform random number.
    """
    leaning = dr.clip(dr.dot(analyser, M.of_s1), -1.0, 1.0)
    by_s, by_p = 0.5 * (1.0 + leaning), 0.5 * (1.0 - leaning)
    mirrors = total | (coin < by_s * mirrored.s + by_p * mirrored.p)
    event = dr.select(mirrors, mirrored, passed)
    return then(M, event, dr.rcp(dr.maximum(by_s * event.s + by_p * event.p, _LEAST))), mirrors
