"""Mueller matrices of smooth dielectric facets from the Fresnel amplitudes, and the frames of Stokes vectors.

A Stokes vector (s0, s1, s2, s3) is given in a right-handed frame (x, y, f) with f the direction in which the light
travels: s1 > 0 is linear polarisation along x, s2 > 0 along the diagonal from x to y, s3 > 0 circular polarisation that
turns clockwise seen against the light. Paths are traced against the light. The Mueller matrix of a path maps light that
arrives at its end to light at the camera: the next event is multiplied from the right.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi

#: Squared sine of the angle of incidence below which incidence counts as normal [1]: float32 cannot resolve the plane
#: of incidence there, and the Fresnel matrices of normal incidence are rotationally symmetric.
_NORMAL_INCIDENCE = 1e-12
#: Smallest probability in a division: so rare an outcome is never sampled, but float32 must not overflow.
_MIN_PROBABILITY = 1e-20


@dataclass(frozen=True, eq=False)
class FacetMueller:
    """Mueller matrix of reflection or transmission: [[m, d, 0, 0], [d, m, 0, 0], [0, 0, c, -e], [0, 0, e, c]].

    m and d are half the sum and half the difference of `s` and `p`. The frame's x axis is perpendicular to the plane of
    incidence on both sides.
    """

    s: mi.Float  #: reflectance or transmittance of s-polarised power (perpendicular to the plane of incidence)
    p: mi.Float  #: the same of p-polarised power (in the plane of incidence)
    c: mi.Float  #: real part of the product of the s amplitude and the conjugated p amplitude
    e: mi.Float  #: its imaginary part


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class Mueller:
    """A Mueller matrix by its columns, one for all wavelengths."""

    of_s0: mi.Vector4f
    of_s1: mi.Vector4f
    of_s2: mi.Vector4f
    of_s3: mi.Vector4f


def identity() -> Mueller:
    """Return the identity matrix."""
    return Mueller(*(mi.Vector4f(*(float(row == column) for row in range(4))) for column in range(4)))


def as_matrix(M: Mueller) -> mi.Matrix4f:
    """Return the matrix as Mitsuba's type."""
    columns = (M.of_s0, M.of_s1, M.of_s2, M.of_s3)
    return mi.Matrix4f(*(columns[column][row] for row in range(4) for column in range(4)))


def fresnel_mueller(cos_i: mi.Float, cos_t: mi.Float, eta: mi.Float) -> tuple[FacetMueller, FacetMueller]:
    """Return the Mueller matrices of reflection and transmission at an interface.

    Born and Wolf 1999, "Principles of Optics", section 1.5.2, eq. 20a and 21a (amplitudes), 14 and 15 (reflectance
    and transmittance); beyond the critical angle section 1.5.4, eq. 61 (phase difference). The vector p has the
    opposite sign here in all beams, which changes no matrix.

    Parameters
    ----------
    cos_i, cos_t : mi.Float
        Cosines of the angles to the normal before and behind the interface, >= 0; `cos_t` is 0 at total internal
        reflection.
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
    reflection = FacetMueller(dr.square(r_s), dr.square(r_p), c, e)
    passed = 4.0 * a * cos_i
    crossed = eta * passed * by_s * by_p
    return reflection, FacetMueller(passed * dr.square(by_s), eta2 * passed * dr.square(by_p), crossed, mi.Float(0.0))


def s_axis(facet: mi.Vector3f, towards: mi.Vector3f, axis: mi.Vector3f) -> mi.Vector3f:
    """Return the unit vector perpendicular to the plane of incidence; `axis` at normal incidence."""
    normal = dr.cross(facet, towards)
    sin2 = dr.squared_norm(normal)
    return dr.select(sin2 > _NORMAL_INCIDENCE, normal * dr.rsqrt(dr.maximum(sin2, _NORMAL_INCIDENCE)), axis)


def rotated_basis(M: Mueller, axis: mi.Vector3f, to: mi.Vector3f, forward: mi.Vector3f) -> Mueller:
    """Return the matrix for incoming light in the frame with x along `to` instead of `axis`.

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
    scale = dr.rcp(dr.square(cos) + dr.square(sin))  # rounding must not add energy
    c2, s2 = (dr.square(cos) - dr.square(sin)) * scale, 2.0 * cos * sin * scale
    return Mueller(M.of_s0, M.of_s1 * c2 - M.of_s2 * s2, M.of_s1 * s2 + M.of_s2 * c2, M.of_s3)


def multiplied(M: Mueller, event: FacetMueller, scale: mi.Float) -> Mueller:
    """Return ``M @ event`` times `scale`."""
    m, d = 0.5 * scale * (event.s + event.p), 0.5 * scale * (event.s - event.p)
    c, e = scale * event.c, scale * event.e
    return Mueller(
        M.of_s0 * m + M.of_s1 * d, M.of_s0 * d + M.of_s1 * m, M.of_s2 * c + M.of_s3 * e, M.of_s3 * c - M.of_s2 * e
    )


def sampled_event(
    M: Mueller,
    analyser: mi.Vector4f,
    reflection: FacetMueller,
    transmission: FacetMueller,
    total: mi.Bool,
    u_lobe: mi.Float,
) -> tuple[Mueller, mi.Bool]:
    """Sample reflection or transmission at a facet.

    The probability of each lobe is the fraction of unpolarised light beyond the facet that the lobe carries to the
    camera. So the path's throughput of s0 stays constant over any number of events. With the Fresnel reflectance of
    unpolarised light its variance would grow with the path's length, because the events between facet and camera act as
    a polarising filter.

    Parameters
    ----------
    M : Mueller
        Matrix from the facet to the point that `analyser` starts from.
    analyser : mi.Vector4f
        First row of the matrix from there to the camera (the row that gives s0), scaled to 1 in its first element.
    reflection, transmission : FacetMueller
        The facet's two lobes.
    total : mi.Bool
        Whether reflection is total.
    u_lobe : mi.Float
        Uniform random number.

    Returns
    -------
    M : Mueller
        The matrix including the event, over the event's probability.
    reflects : mi.Bool
        Whether the event is a reflection.
    """
    polarisation = dr.clip(dr.dot(analyser, M.of_s1), -1.0, 1.0)
    weight_s, weight_p = 0.5 * (1.0 + polarisation), 0.5 * (1.0 - polarisation)
    reflects = total | (u_lobe < weight_s * reflection.s + weight_p * reflection.p)
    event = dr.select(reflects, reflection, transmission)
    probability = weight_s * event.s + weight_p * event.p
    return multiplied(M, event, dr.rcp(dr.maximum(probability, _MIN_PROBABILITY))), reflects
