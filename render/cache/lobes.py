"""The opaque material in closed form, its diffuse and its glossy part apart.

Mitsuba's `principled` BSDF as our materials use it (Burley 2012, "Physically-Based Shading at Disney", section 5; index
1.5, no sheen, clearcoat or anisotropy). Written out because the stored light answers the diffuse part alone, and
Mitsuba evaluates the sum. A test holds the sum of both against Mitsuba's own.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi

#: Index of refraction under the gloss: Mitsuba's default `specular` of 0.5.
_ETA = 1.5
#: Least GGX roughness, Mitsuba's.
_LEAST_ALPHA = 1e-3


@dataclass(frozen=True, eq=False)
class Gloss:
    """The numbers of the material at the points that are shaded."""

    colour: mi.Color3f  #: base colour
    roughness: mi.Float
    metallic: mi.Float


def schlick(cos: mi.Float) -> mi.Float:
    """Return Schlick's weight, (1 - cos)^5."""
    x = dr.clip(1.0 - cos, 0.0, 1.0)
    return dr.square(dr.square(x)) * x


def glossy(gloss: Gloss, wi: mi.Vector3f, wo: mi.Vector3f) -> tuple[mi.Color3f, mi.Float]:
    """Return the glossy part times the cosine, and the density that `sampled_gloss` draws `wo` with.

    Parameters
    ----------
    gloss : Gloss
        The material.
    wi, wo : mi.Vector3f
        Towards the eye and towards the light, unit, in the frame of the shading normal.
    """
    above = (wi.z > 0.0) & (wo.z > 0.0)
    facets, half = _facets(gloss), dr.normalize(wi + wo)
    cos = dr.dot(wi, half)
    F, *_ = mi.fresnel(cos, _ETA)
    metal = gloss.colour + (1.0 - gloss.colour) * schlick(cos)
    shine = (1.0 - gloss.metallic) * F + gloss.metallic * metal
    value = shine * (facets.eval(half) * facets.G(wi, wo, half) / (4.0 * dr.maximum(wi.z, 1e-6)))
    pdf = facets.pdf(wi, half) / (4.0 * dr.maximum(dr.dot(wo, half), 1e-6))
    return dr.select(above, value, 0.0), dr.select(above, pdf, 0.0)


def sampled_gloss(gloss: Gloss, wi: mi.Vector3f, sample: mi.Point2f) -> mi.Vector3f:
    """Return a mirrored direction: on a facet drawn from those that the eye sees (Heitz 2018)."""
    half, _ = _facets(gloss).sample(wi, sample)
    return mi.reflect(wi, half)


def _facets(gloss: Gloss) -> mi.MicrofacetDistribution:
    alpha = dr.maximum(dr.square(gloss.roughness), _LEAST_ALPHA)
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha, True)
