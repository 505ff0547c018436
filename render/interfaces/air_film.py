"""A film of air between two media, too thin to be seen and thick against the wavelength.

Renderers that nest the mesh of a liquid in that of a glass have one, wherever their meshes do not touch. Light crosses
two interfaces there and is reflected back and forth between them, without interference. What arrives beyond the
critical angle of the first medium against air is reflected, whatever lies behind the film.
"""

from __future__ import annotations

from .._mitsuba import dr, mi
from .dielectric import InterfaceHit, Scattered, consistent_normal, refracted


def film_reflectance(cos_i: mi.Float, before: mi.Float, behind: mi.Float) -> mi.Float:
    """Return the reflectance of a film of air for unpolarised light.

    With the reflectances F1 and F2 of its two sides the series of all reflections is
    ``F1 + (1 - F1)^2 F2 (1 + F1 F2 + ...) = (F1 + F2 - 2 F1 F2) / (1 - F1 F2)``, for each of both polarisations.

    Parameters
    ----------
    cos_i : Float
        Cosine between normal and ray in the medium before the film, positive.
    before, behind : Float
        Indices of the media on its two sides.
    """
    sine_squared = dr.square(before) * dr.maximum(1.0 - dr.square(cos_i), 0.0)  # in the air
    total = sine_squared >= 1.0
    cos_air = dr.safe_sqrt(1.0 - sine_squared)
    cos_t = dr.safe_sqrt(1.0 - sine_squared / dr.square(behind))
    reflectance = mi.Float(0.0)
    for parallel in (False, True):
        first = _fresnel(before, 1.0, cos_i, cos_air, parallel)
        second = _fresnel(1.0, behind, cos_air, cos_t, parallel)
        both = first * second
        reflectance += 0.5 * (first + second - 2.0 * both) / dr.maximum(1.0 - both, 1e-6)
    return dr.select(total, 1.0, reflectance)


def _fresnel(
    n_i: mi.Float | float, n_t: mi.Float | float, cos_i: mi.Float, cos_t: mi.Float, parallel: bool
) -> mi.Float:
    """Return the reflectance of an interface for light polarised parallel or perpendicular to the plane of incidence.

    (Born and Wolf, Principles of Optics, section 1.5.2.)
    """
    a, b = (n_t * cos_i, n_i * cos_t) if parallel else (n_i * cos_i, n_t * cos_t)
    return dr.square((a - b) / dr.maximum(a + b, 1e-6))


def scatter_at_film(hit: InterfaceHit, before: mi.Float) -> Scattered:
    """Sample reflection or refraction at a film of air between two media, which counts as smooth.

    Parameters
    ----------
    hit : InterfaceHit
        The ray, with the indices of the media on both sides of the film.
    before : Float
        Index of the medium on the ray's side.
    """
    facet = consistent_normal(hit.wi, hit.n, hit.ns, hit.eta)
    cos_i = dr.dot(hit.wi, facet)
    reflectance = film_reflectance(cos_i, before, before * hit.eta)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, hit.eta)
    # (Where light is reflected as a whole without the film, it is with it.)
    transmitted = (hit.u_lobe >= reflectance) & (cos_t != 0.0)
    through = refracted(hit.wi, facet, cos_i, cos_t, eta_ti)
    direction = dr.normalize(dr.select(transmitted, through, mi.reflect(hit.wi, facet)))
    eta_squared = dr.select(transmitted, dr.square(hit.eta), 1.0)
    probability = dr.select(transmitted, 1.0 - reflectance, reflectance)
    return Scattered(direction, dr.rcp(eta_squared), transmitted, eta_squared, probability)
