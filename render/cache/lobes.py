"""Lobes of the opaque material in closed form: the glossy (specular) lobe and its sampling.

Mitsuba's `principled` BSDF as our materials use it (Burley 2012, "Physically-Based Shading at Disney", section 5; index
1.5, no sheen, clearcoat or anisotropy). Implemented here because the irradiance cache answers the diffuse lobe alone,
and Mitsuba evaluates the sum of all lobes. A test compares the sum with Mitsuba's BSDF.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi

#: Index of refraction of the specular layer [1]: Mitsuba's default `specular` of 0.5.
_ETA = 1.5
#: Smallest GGX roughness [1], as in Mitsuba.
_MIN_ALPHA = 1e-3


@dataclass(eq=False)  # not frozen: maps replace fields
class OpaqueParameters:
    """Parameters of the material at shading points."""

    colour: mi.Color3f  #: base colour
    roughness: mi.Float
    metallic: mi.Float


def schlick(cos: mi.Float) -> mi.Float:
    """Return Schlick's weight, (1 - cos)^5."""
    x = dr.clip(1.0 - cos, 0.0, 1.0)
    return dr.square(dr.square(x)) * x


def eval_glossy(material: OpaqueParameters, wi: mi.Vector3f, wo: mi.Vector3f) -> tuple[mi.Color3f, mi.Float]:
    """Evaluate the glossy lobe times the cosine, and the density of `sample_glossy`.

    Parameters
    ----------
    material : OpaqueParameters
        The material.
    wi, wo : mi.Vector3f
        Towards the eye and towards the light, unit, in the frame of the shading normal.
    """
    above = (wi.z > 0.0) & (wo.z > 0.0)
    facets, half = _facets(material), dr.normalize(wi + wo)
    cos = dr.dot(wi, half)
    F, *_ = mi.fresnel(cos, _ETA)
    metal = material.colour + (1.0 - material.colour) * schlick(cos)
    fresnel = (1.0 - material.metallic) * F + material.metallic * metal
    value = fresnel * (facets.eval(half) * facets.G(wi, wo, half) / (4.0 * dr.maximum(wi.z, 1e-6)))
    pdf = facets.pdf(wi, half) / (4.0 * dr.maximum(dr.dot(wo, half), 1e-6))
    return dr.select(above, value, 0.0), dr.select(above, pdf, 0.0)


def sample_glossy(material: OpaqueParameters, wi: mi.Vector3f, sample: mi.Point2f) -> mi.Vector3f:
    """Sample a direction of the glossy lobe, by the distribution of visible normals (Heitz 2018)."""
    half, _ = _facets(material).sample(wi, sample)
    return mi.reflect(wi, half)


def _facets(material: OpaqueParameters) -> mi.MicrofacetDistribution:
    alpha = dr.maximum(dr.square(material.roughness), _MIN_ALPHA)
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha, True)
