"""The irradiance cache, and shading from it: the diffuse lobe is read from the cache, the glossy lobe is sampled.

The diffuse lobe depends weakly on the eye's direction v. With f = (1 - cos)^5 for the light and F for the eye,
roughness r, and n, l the normal and the direction of light, Burley's diffuse lobe (2012, section 5.3) is

    (1 - f/2)(1 - F/2) + R (F + f + F f (R - 1)),    R = 2 r cos^2(half angle) = r (1 + l v),

a polynomial in v. So it follows from moments of the incident light: the irradiance E (weight 1), its part weighted with
f, and the mean directions of both. The one square, in the term with F f, is evaluated at the mean direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import TABLE_ID
from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..pictures.emitter_candidates import candidates_of, chosen_candidate
from ..pictures.integrator import Bounce, PathDimensions, StoredCaustics, emitter_weight
from ..scene.emitters import sample_emitter, unoccluded
from ..scene.loaded_scene import LoadedScene
from ..scene.surface_maps import MappedValues, SurfaceMaps, above_surface, mapped_normal, values_at
from ..scene.surfaces import SurfaceTable, registry_id
from .cache_points import CachePoints, Lookup, interpolation_weights, lookup_of
from .guiding import EmissionMap, emission_along
from .lobes import OpaqueParameters, eval_glossy, sample_glossy, schlick

#: Moments of a cache point [1]: E (3), E weighted with f (3), mean direction of both (3 each, by luminance).
MOMENTS = 12
#: Columns of an irradiance and of its mean direction.
DIRECTIONS = ((slice(0, 3), slice(6, 9)), (slice(3, 6), slice(9, 12)))
#: Survival of Russian roulette for glossy bounces [1]: this many times their weight, times the expected radiance over
#: the diffuse radiance where that is more than 1, and at least `_MIN_SURVIVAL`.
_SURVIVAL, _MIN_SURVIVAL = 3.0, 0.2
#: Radiance of a sampled emitter in the glossy lobe over the diffuse radiance below which Russian roulette decides
#: whether a shadow ray is traced [1].
_FAINT = 0.25
#: Normal part of a mean direction that irradiance is divided by, at least [1]: light that grazes the surface more than
#: this would make facets many times as bright as it.
_MIN_NORMAL_PART = 0.1
#: How much faster irradiance changes with the slope under slowly varying light than by its mean direction: 16/9 - 1.
_EVEN_LIGHT = 7.0 / 9.0


@dataclass(frozen=True, eq=False)
class IrradianceCache:
    """The light that arrives at a scene's opaque surfaces, by cache point."""

    points: CachePoints
    moments: np.ndarray  #: (count, 12) float32, irradiance [radiance unit * sr] and unitless mean directions
    samples: np.ndarray  #: (count,) paths that each point is the mean of
    photons: int = 0  #: photons that its caustics are made of
    #: (count, 12) moments of the caustics alone, not filtered (`photon_map.photon_moments`); None: there are none
    caustics: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class TracedSurfaces:
    """Surfaces of a cached scene whose light is path traced, but for their caustics."""

    rows: mi.Bool  #: by registry id
    caustics: StoredCaustics


@dataclass(frozen=True, eq=False)
class MaterialColumns:
    """The materials of opaque surfaces."""

    roughness: mi.Float  #: by registry id
    metallic: mi.Float  #: by registry id
    maps: SurfaceMaps | None  #: of the materials that have any


@dataclass(frozen=True, eq=False)
class CachedShader:
    """The irradiance cache and the materials as Dr.Jit arrays, for shading."""

    loaded: LoadedScene
    table: SurfaceTable
    lookup: Lookup
    moments: mi.Float
    materials: MaterialColumns
    emission: EmissionMap
    traced: TracedSurfaces | None = None  #: surfaces that are path traced, not read from the cache


@dataclass(frozen=True, eq=False)
class ShadingPoint:
    """A point on an opaque surface, seen from the eye."""

    si: mi.SurfaceInteraction3f
    frame: mi.Frame3f  #: of the shading normal on the eye's side
    wi: mi.Vector3f  #: towards the eye, in `frame`
    material: OpaqueParameters
    tilt: Tilt | None = None  #: None where no material of the scene has maps


@dataclass(frozen=True, eq=False)
class Tilt:
    """What maps change at a point."""

    values: MappedValues
    smooth: mi.Normal3f  #: shading normal of the surface without the map, on the eye's side
    eye: mi.Vector3f

    def above(self, point: ShadingPoint, direction: mi.Vector3f) -> mi.Bool:
        """Return whether a direction leaves the surface on the eye's side."""
        return above_surface(self.values, point.si, self.eye, direction)


@dataclass(frozen=True, eq=False)
class Moments:
    """Interpolated moments of the incident light."""

    E: mi.Color3f
    E_f: mi.Color3f
    mean: mi.Vector3f
    mean_f: mi.Vector3f


def cached_shader(
    loaded: LoadedScene, cache: IrradianceCache, emission: EmissionMap, traced: TracedSurfaces | None = None
) -> CachedShader:
    """Return the shader of a scene's opaque surfaces."""
    table, lookup = loaded.surfaces, lookup_of(cache.points)
    moments = mi.Float(np.ascontiguousarray(cache.moments, np.float32).ravel())
    dr.make_opaque(moments)
    return CachedShader(loaded, table, lookup, moments, material_columns(loaded), emission, traced)


def material_columns(loaded: LoadedScene) -> MaterialColumns:
    """Return roughness and metallic of the opaque surfaces, by registry id, and their maps."""
    parameters = np.zeros((dr.width(loaded.surfaces.instance), 2), np.float32)
    for body in loaded.opaque_bodies:
        parameters[body.row] = body.roughness, body.metallic
    roughness, metallic = mi.Float(parameters[:, 0].copy()), mi.Float(parameters[:, 1].copy())
    dr.make_opaque(roughness, metallic)
    return MaterialColumns(roughness, metallic, loaded.surfaces.maps)


def normalised(moments: np.ndarray) -> np.ndarray:
    """Return moments whose sums of directions, weighted by luminance, are divided by the luminance: mean directions.

    A mean of unit vectors is no longer than one. Filtered sums may be: where hardly any light grazes the surface, what
    a filter leaves of the light may be a billionth of what it leaves of the directions.
    """
    result = moments.copy()
    for colour, vector in DIRECTIONS:
        weight = luminance(moments[:, colour])[:, None]
        mean = np.divide(moments[:, vector], weight, out=np.zeros((len(moments), 3)), where=weight > 0.0)
        result[:, vector] = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1.0)
    return result


def shading_point(si: mi.SurfaceInteraction3f, eye: mi.Vector3f, columns: MaterialColumns) -> ShadingPoint:
    """Return points on opaque surfaces as seen from the eye, with `material_columns` of the scene."""
    row = registry_id(si.shape)
    material = OpaqueParameters(
        mi.Color3f(si.bsdf().eval_diffuse_reflectance(si)),
        dr.gather(mi.Float, columns.roughness, row),
        dr.gather(mi.Float, columns.metallic, row),
    )
    n = mi.Normal3f(dr.select(dr.dot(si.sh_frame.n, eye) < 0.0, -si.sh_frame.n, si.sh_frame.n))
    tilt = None
    if columns.maps is not None:
        values = values_at(columns.maps, si, row)
        tilt = Tilt(values, n, eye)
        material.roughness = dr.select(values.mapped, values.roughness, material.roughness)
        material.metallic = dr.select(values.mapped, values.metallic, material.metallic)
        n = mapped_normal(values, si, n, eye)
    frame = mi.Frame3f(n)
    return ShadingPoint(si, frame, frame.to_local(eye), material, tilt)


def shade(
    shader: CachedShader,
    si: mi.SurfaceInteraction3f,
    barycentric: mi.Point2f,
    ray: mi.Ray3f,
    offset: mi.Float,
    u: PathDimensions,
    direct: mi.Bool,
) -> Bounce:
    """Return the radiance of opaque surfaces towards the eye, and a glossy bounce by BSDF sampling.

    Russian roulette decides about the bounce. Bounces towards bright emitters survive more often: a window reflected in
    a polished table is most of its noise. Whether the eye sees the surface `direct` decides about the number of
    candidates (`candidates_of`).
    """
    table, row, eye = shader.table, registry_id(si.shape), -ray.d
    instance = dr.gather(mi.UInt32, table.instance, row)
    on_table, is_light = instance == TABLE_ID, instance == 0  # area lights emit and are black
    point = shading_point(si, eye, shader.materials)
    frame, material = point.frame, point.material
    index, weight = interpolation_weights(shader.lookup, si, barycentric, eye, on_table)
    radiance = diffuse(material, point.wi, eye, moments_at(shader.moments, index, weight, point))
    level = dr.max(radiance)
    count = candidates_of(table.candidates, row, direct)
    found, u_emitter = _glossy_emitter(shader.loaded, point, offset, u, _FAINT * level, count)
    radiance += found

    wo = sample_glossy(material, point.wi, u.u_bsdf)
    value, pdf = eval_glossy(material, point.wi, wo)
    factor = dr.select(pdf > 0.0, value / pdf, 0.0)
    direction = frame.to_world(wo)
    if point.tilt is not None:
        factor = dr.select(point.tilt.above(point, direction), factor, 0.0)
    expected = emission_along(shader.emission, si.p, direction)
    expected_radiance = dr.select(level > 0.0, expected / level, dr.inf)
    survival = dr.clip(_SURVIVAL * dr.max(factor) * dr.maximum(expected_radiance, 1.0), _MIN_SURVIVAL, 1.0)
    factor = dr.select(u.u_lobe < survival, factor / survival, 0.0)
    radiance, factor = (dr.select(is_light, 0.0, x) for x in (radiance, factor))
    return Bounce(radiance, direction, factor, pdf, mi.Bool(False), u_emitter, count)


def interpolated(moments: mi.Float, index: list[mi.UInt32], weight: list[mi.Float]) -> Moments:
    """Return the moments interpolated between cache points."""
    parts = [dr.zeros(mi.Vector4f) for _ in range(3)]
    for point, w in zip(index, weight, strict=True):
        for k in range(3):
            parts[k] += w * dr.gather(mi.Vector4f, moments, 3 * point + k)
    a, b, c = parts
    E, E_f = mi.Color3f(a.x, a.y, a.z), mi.Color3f(a.w, b.x, b.y)
    return Moments(E, E_f, mi.Vector3f(b.z, b.w, c.x), mi.Vector3f(c.y, c.z, c.w))


def moments_at(moments: mi.Float, index: list[mi.UInt32], weight: list[mi.Float], point: ShadingPoint) -> Moments:
    """Return the moments interpolated between cache points, for the shading normals of the points."""
    found = interpolated(moments, index, weight)
    if point.tilt is None:
        return found
    smooth, n = point.tilt.smooth, point.frame.n
    E, E_f = found.E * tilted_irradiance(found.mean, smooth, n), found.E_f * tilted_irradiance(found.mean_f, smooth, n)
    return Moments(E, E_f, found.mean, found.mean_f)


def tilted_irradiance(mean: mi.Vector3f, smooth: mi.Normal3f, n: mi.Normal3f) -> mi.Float:
    """Return the irradiance of a facet with the normal `n` over that of the surface that it lies on.

    The mean direction m of the light, weighted with the cosine, has the length 1 where all light comes from one
    direction l, and 2/3 under an even sky. For one direction the irradiance goes with n . l = n . m. An even sky gives
    a tilted facet (1 + cos) / 2, as the surface itself hides the rest; where radiance a + b . w varies slowly,
    integrals over the hemisphere give m_t = 3 b_t / (8 a) along the surface and the relative change 2 b_t / (3 a) for
    each unit of slope, 16/9 times m_t over the normal part. Between the two limits, in which small slopes are exact,
    the length of m interpolates. What error is left shows in the check against path tracing (`light_check`).
    """
    normal_part = dr.maximum(dr.dot(mean, smooth), _MIN_NORMAL_PART)
    spread = dr.clip(3.0 * (1.0 - dr.norm(mean)), 0.0, 1.0)
    cos = dr.dot(smooth, n)
    along = dr.dot(mean, n) - dr.dot(mean, smooth) * cos
    level = cos + 0.5 * spread * (1.0 - cos)
    return dr.maximum(level + (1.0 + _EVEN_LIGHT * spread) * along / normal_part, 0.0)


def diffuse(material: OpaqueParameters, wi: mi.Vector3f, eye: mi.Vector3f, moments: Moments) -> mi.Color3f:
    """Return the radiance of the diffuse lobe towards the eye.

    `wi` and `eye` are the same direction, in the frame of the shading normal and in that of the mean directions.
    """
    E, E_f = moments.E, moments.E_f
    F, r = schlick(wi.z), material.roughness
    R, R_f = r * (1.0 + dr.dot(moments.mean, eye)), r * (1.0 + dr.dot(moments.mean_f, eye))
    reflected = (E - 0.5 * E_f) * (1.0 - 0.5 * F) + R * F * E + R_f * E_f + R_f * (R_f - 1.0) * F * E_f
    return dr.maximum((1.0 - material.metallic) * dr.inv_pi * material.colour * reflected, 0.0) & (wi.z > 0.0)


def _glossy_emitter(
    loaded: LoadedScene,
    point: ShadingPoint,
    offset: mi.Float,
    u: PathDimensions,
    faint: mi.Float,
    count: mi.UInt32 | None,
) -> tuple[mi.Color3f, mi.Point2f]:
    """Return the radiance of the glossy lobe by emitter sampling (next-event estimation), and its sample point.

    It is MIS-weighted, and chosen from a number of candidates. Below the radiance `faint`, Russian roulette decides
    whether a shadow ray is traced.
    """

    def sampled(at: mi.Point2f) -> tuple[mi.DirectionSample3f, mi.Color3f, mi.Color3f]:
        ds, arriving = sample_emitter(loaded.emitters, point.si, at)
        value, pdf = eval_glossy(point.material, point.wi, point.frame.to_local(ds.d))
        if point.tilt is not None:
            value = dr.select(point.tilt.above(point, ds.d), value, 0.0)
        return ds, arriving, dr.select(ds.pdf > 0.0, emitter_weight(ds, pdf, count) * value, 0.0)

    def reflected(at: mi.Point2f) -> mi.Float:
        _, arriving, weight = sampled(at)
        return dr.max(weight * arriving)

    chosen = chosen_candidate(u.u_emitter, u.u_rr, count, reflected)
    ds, arriving, weight = sampled(chosen.u)
    weight *= chosen.weight
    survival = dr.minimum(dr.max(weight * arriving) / faint, 1.0)
    lit = (ds.pdf > 0.0) & (chosen.left < survival)
    arriving = unoccluded(loaded.emitters, point.si, (ds, arriving), offset, lit)
    return dr.select(lit, weight * arriving / survival, 0.0), chosen.u
