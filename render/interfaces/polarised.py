"""Scattering at a dielectric interface in polarised variants: `dielectric.scatter` with Mueller matrices.

Mitsuba's convention for a ray: the Stokes frame of its light has the x axis ``mi.mueller.stokes_basis(f)``, where f,
the direction in which the light travels, is opposite to the ray's. All matrices that leave this module are in these
frames.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi, syntax
from .dielectric import InterfaceHit, Scattered, consistent_normal, refracted
from .microsurface import MAX_FACETS, WalkEnd, next_height, visible_facet
from .mueller import Mueller, as_matrix, fresnel_mueller, identity, rotated_basis, s_axis, sampled_event


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class StokesFrame:
    """The Mueller matrix of a path so far, and the frame of the light that it takes."""

    M: Mueller
    axis: mi.Vector3f  #: x axis of the frame, unit, perpendicular to the path's last segment


@syntax
def scatter_polarised(hit: InterfaceHit, analyser: mi.Vector4f) -> Scattered:
    """Sample a scattering event at an interface as `dielectric.scatter` does.

    Parameters
    ----------
    hit : InterfaceHit
        The ray at the interface; `u_facet` is not used.
    analyser : mi.Vector4f
        First row of the path's Mueller matrix over its first element (see `analyser_of`). Events are importance sampled
        by it.

    Returns
    -------
    Scattered
        Its `weight` is a Mueller matrix (mi.Matrix4f) that maps light which travels along ``-direction`` to light which
        travels along `wi`.
    """
    wi, n, eta, alpha, seed = hit.wi, hit.n, hit.eta, hit.alpha, hit.seed
    facet, axis = consistent_normal(wi, n, hit.ns, eta), mi.mueller.stokes_basis(wi)
    frame = StokesFrame(identity(), axis)
    direction, reflected, frame = polarised_facet_event(frame, wi, facet, eta, hit.u_lobe, analyser)
    M, axis = frame.M, frame.axis
    transmitted, alive = ~reflected, mi.Bool(True)

    if alpha > 0.0:
        local = mi.Frame3f(facet)
        first = local.to_local(mi.mueller.stokes_basis(wi))
        end, last = walk_polarised(local.to_local(wi), first, alpha, eta, seed, analyser)
        transmitted, alive, M = end.transmitted, end.alive, last.M
        direction, axis = local.to_world(end.direction), local.to_world(last.axis)
        # As in `dielectric.scatter`; the frame is reflected with the ray.
        wrong = (dr.dot(direction, n) < 0.0) != transmitted
        direction = dr.select(wrong, direction - 2.0 * dr.dot(direction, n) * n, direction)
        axis = dr.select(wrong, axis - 2.0 * dr.dot(axis, n) * n, axis)

    direction = dr.normalize(direction)
    M = rotated_basis(M, axis, mi.mueller.stokes_basis(-direction), -direction)
    eta_squared = dr.select(transmitted, dr.square(eta), 1.0)
    weight = dr.select(alive, dr.rcp(eta_squared), 0.0)
    return Scattered(direction, as_matrix(M) * mi.Matrix4f(weight), transmitted, eta_squared, mi.Float(1.0))


@syntax
def walk_polarised(
    wi: mi.Vector3f, axis: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32, analyser: mi.Vector4f
) -> tuple[WalkEnd, StokesFrame]:
    """Follow a ray over the microsurface as `microsurface.walk` does.

    Parameters
    ----------
    wi, alpha, eta, seed
        As for `microsurface.walk`.
    axis : mi.Vector3f
        The x axis of the Stokes frame of light that leaves along `wi`.
    analyser : mi.Vector4f
        As for `scatter_polarised`, in that frame.

    Returns
    -------
    end : WalkEnd
        As `microsurface.walk` returns.
    frame : StokesFrame
        The matrix that maps light arriving against the end's direction to light that leaves along `wi`, over the
        probability of the walk, and the frame of the arriving light.
    """
    random = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height, axis, M = mi.Vector3f(-wi), mi.Float(1.0), mi.Vector3f(axis), identity()
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while dr.hint(walking, exclude=[analyser]):
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        reached, leaves = next_height(sign * direction, sign * height, alpha, random.next_float32())
        height = sign * reached
        walking &= ~leaves
        u_normal = mi.Point2f(random.next_float32(), random.next_float32())
        u_lobe = random.next_float32()
        if dr.hint(walking, exclude=[analyser]):
            # The event itself is not reflected to the upper side: that would reflect the Stokes frames.
            facet = sign * visible_facet(-sign * direction, alpha, u_normal)
            ratio = dr.select(above, eta, dr.rcp(eta))
            frame = StokesFrame(M, axis)
            direction, reflected, frame = polarised_facet_event(frame, -direction, facet, ratio, u_lobe, analyser)
            M, axis = frame.M, frame.axis
            above = above == reflected
        facets += 1
        walking &= facets < MAX_FACETS

    return WalkEnd(direction, ~above, facets < MAX_FACETS), StokesFrame(M, axis)


def polarised_facet_event(
    frame: StokesFrame,
    towards: mi.Vector3f,
    facet: mi.Vector3f,
    eta: mi.Float,
    u_lobe: mi.Float,
    analyser: mi.Vector4f,
) -> tuple[mi.Vector3f, mi.Bool, StokesFrame]:
    """Sample reflection or refraction at a facet.

    Returns
    -------
    direction : mi.Vector3f
        Unit direction after the event.
    reflected : mi.Bool
        Whether the ray is reflected.
    frame : StokesFrame
        The path's matrix including the event, for light that arrives against `direction`.
    """
    cos_i = dr.dot(towards, facet)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    s = s_axis(facet, towards, frame.axis)
    M = rotated_basis(frame.M, frame.axis, s, towards)
    reflection, transmission = fresnel_mueller(cos_i, -cos_t, eta)
    M, reflects = sampled_event(M, analyser, reflection, transmission, cos_t == 0.0, u_lobe)
    direction = dr.select(reflects, mi.reflect(towards, facet), refracted(towards, facet, cos_i, cos_t, eta_ti))
    return dr.normalize(direction), reflects, StokesFrame(M, s)


def analyser_of(throughput: mi.Spectrum) -> mi.Vector4f:
    """Return the first row of a path's Mueller matrix over its first element, one for all its wavelengths."""
    first, *others = (dr.sum(throughput[0, column]) for column in range(4))
    scale = dr.select(first > 0.0, dr.rcp(first), 0.0)
    return mi.Vector4f(1.0, *(scale * value for value in others))


def mueller_to_world(
    value: mi.Spectrum, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, direction: mi.Vector3f, ray: mi.Ray3f
) -> mi.Spectrum:
    """Return a BSDF's Mueller matrix in the Stokes frames of the world's directions instead of the local ones.

    Mitsuba's own `si.to_world_mueller` computes the world's directions from the local ones. Stokes frames are
    discontinuous where a direction is horizontal: they must be computed from the ray itself, not from a copy with
    rounding errors.

    Parameters
    ----------
    value : mi.Spectrum
        The BSDF's value or weight.
    si : mi.SurfaceInteraction3f
        Where the ray arrives.
    wo, direction : mi.Vector3f
        Direction in which the path goes on, in the local and in the world frame.
    ray : mi.Ray3f
        The ray that arrives.
    """
    local = mi.mueller.stokes_basis
    into, out = si.to_world(local(-wo)), si.to_world(local(si.wi))
    return mi.mueller.rotate_mueller_basis(value, -direction, into, local(-direction), -ray.d, out, local(-ray.d))
