"""Ray loop of the infrared pictures: paths refract through glass, and see the projector's light on what is behind.

Camera paths choose reflection or refraction at each interface as those of pictures do. Each interface adds the image of
the projector that it mirrors, and each opaque surface what it scatters of the projector's light. Polished surfaces pass
the path on. Light that goes by more than one diffuse surface is left out.
"""

from __future__ import annotations

from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import InterfaceHit, scatter
from ..pictures.integrator import Radiance, mapped_frame, path_dimensions, two_sided
from ..pictures.sampler import SobolSampler, hashed_seed
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import unpolarised
from ..scene.surface_maps import values_at
from ..scene.surfaces import (
    AIR_INDEX,
    SurfaceMedia,
    SurfaceTable,
    broken_continuity,
    medium_after_bounce,
    medium_after_interface,
    medium_at_end,
    registry_id,
    relative_index_d,
    surface_media,
    transmittance_rgb,
)
from .projected_light import ProjectedLight, arriving

#: Surfaces that a path meets at most [1].
_MAX_SURFACES = 48
#: Least GGX roughness of the lobe by which interfaces mirror the projector [1]. A point of light in a mirror would be
#: met by chance alone; on a glass of 35 mm radius the image of this lobe is half a millimetre wide, less than a pixel.
_HIGHLIGHT = 0.006
#: Part of the lobe below which no shadow ray is traced [1].
_FAINT = 1e-3


@syntax
def trace_pattern(loaded: LoadedScene, ray: mi.Ray3f, sampler: SobolSampler, light: ProjectedLight) -> Radiance:
    """Trace one path for every camera ray, which starts in air, and return the projector's radiance [W/(m^2 sr)].

    The columns `eta_d` and `sigma_a_rgb` of the surface table say what media are like at the projector's wavelength.
    """
    scene, table, offset = loaded.mi_scene, loaded.surfaces, dr.opaque(mi.Float, loaded.offset)
    ray, depth, medium = mi.Ray3f(ray), mi.UInt32(0), mi.UInt32(AIR_INDEX)
    L, beta, active = mi.Float(0.0), mi.Float(1.0), mi.Bool(True)
    violations, segments = mi.UInt32(0), mi.UInt32(0)

    while dr.hint(active, exclude=[loaded, table, scene, sampler, light]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        segments += 1
        violations += broken_continuity(surface, medium)
        beta *= transmittance_rgb(table.sigma_a_rgb, surface, hit).x
        medium = medium_at_end(surface, medium)
        u, direction, factor = path_dimensions(sampler, depth), mi.Vector3f(0.0, 0.0, 1.0), mi.Float(0.0)

        mirrored = interface_lobe(table, surface, -ray.d, dr.normalize(light.origin - si.p))
        lobe = dr.select(hit & ~surface.opaque, mirrored, 0.0)
        wanted = hit & (surface.opaque | (lobe > _FAINT))
        to_light, irradiance = arriving(loaded, light, si, offset, wanted)
        if dr.hint(hit & surface.opaque, exclude=[loaded, table, scene, sampler, light]):
            value, direction, weight = opaque_lobe(loaded, si, ray, to_light, u.u_lobe, u.u_bsdf)
            L += beta * value * irradiance
            polished = dr.gather(mi.Bool, table.polished, surface.row)
            factor = dr.select(polished, weight, 0.0)
            medium = medium_after_bounce(medium, si, direction)
        if dr.hint(hit & ~surface.opaque, exclude=[loaded, table, scene, sampler, light]):
            L += beta * lobe * irradiance
            alpha = dr.gather(mi.Float, table.alpha, surface.row)
            eta = relative_index_d(table.eta_d, surface)
            interface = InterfaceHit(-ray.d, surface.n, surface.ns, eta, alpha, u.u_lobe, hashed_seed(sampler, depth))
            event = scatter(interface)
            direction, factor = mi.Vector3f(event.direction), mi.Float(event.weight)
            medium = medium_after_interface(medium, surface, event.transmitted)
        beta *= factor
        ray = leave(si, direction, offset)
        depth += 1
        active = hit & (beta > 0.0) & (depth < _MAX_SURFACES)

    return Radiance(mi.Color3f(L), dr.minimum(violations, 1), segments)


def opaque_lobe(
    loaded: LoadedScene,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    to_light: mi.Vector3f,
    u_lobe: mi.Float,
    u_bsdf: mi.Point2f,
) -> tuple[mi.Float, mi.Vector3f, mi.Float]:
    """Return BSDF times cosine towards the projector [1/sr], and a direction by BSDF sampling with its weight.

    All channels are alike while surfaces have their reflectances in the infrared (`reflectances`).
    """
    bsdf, point = si.bsdf(ray), two_sided(si, ray)
    if loaded.surfaces.maps is not None:
        point = mapped_frame(point, values_at(loaded.surfaces.maps, point, registry_id(si.shape)), ray)
    local = point.to_local(to_light)
    value, _, sampled, weight = bsdf.eval_pdf_sample(mi.BSDFContext(), point, local, u_lobe, u_bsdf)
    return dr.max(unpolarised(value)), point.to_world(sampled.wo), dr.max(unpolarised(weight))


def interface_lobe(table: SurfaceTable, surface: SurfaceMedia, wi: mi.Vector3f, wo: mi.Vector3f) -> mi.Float:
    """Return what an interface mirrors from one direction to another: a lobe times the cosine [1/sr].

    The lobe is GGX (Walter et al. 2007, eq. 20).
    """
    n = surface.ns
    h = dr.normalize(wi + wo)
    cos_i, cos_o, cos_h = dr.dot(wi, n), dr.dot(wo, n), dr.dot(h, n)
    alpha = dr.maximum(dr.gather(mi.Float, table.alpha, surface.row), _HIGHLIGHT)
    reflectance, *_ = mi.fresnel(dr.dot(wi, h), relative_index_d(table.eta_d, surface))
    a2 = dr.square(alpha)
    density = a2 / (dr.pi * dr.square(dr.square(cos_h) * (a2 - 1.0) + 1.0))
    shadowing = _smith(cos_i, a2) * _smith(cos_o, a2)
    lit = (cos_i > 1e-3) & (cos_o > 1e-3)
    return dr.select(lit, reflectance * density * shadowing / (4.0 * cos_i), 0.0)


def _smith(cos: mi.Float, a2: mi.Float) -> mi.Float:
    """Return Smith's masking of GGX (Walter et al. 2007, eq. 34)."""
    return 2.0 / (1.0 + dr.sqrt(1.0 + a2 * (dr.rcp(dr.square(cos)) - 1.0)))
