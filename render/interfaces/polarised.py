"""What one interface does to a ray in polarised variants: `dielectric.scatter` with Mueller matrices.

Mitsuba's convention for a ray: the frame of its light has the x axis ``mi.mueller.stokes_basis(f)``, where f, the
direction in which the light travels, is opposite to the ray's. All matrices that leave this module are in these frames.
"""

from __future__ import annotations

from .._mitsuba import dr, mi, syntax
from .dielectric import Scattered, refracted, upright_normal
from .microsurface import MAX_FACETS, next_height, visible_facet
from .mueller import Mueller, across, as_matrix, drawn, fresnel_shares, identity, turned


@syntax
def scatter_polarised(
    wi: mi.Vector3f,
    n: mi.Normal3f,
    ns: mi.Normal3f,
    eta: mi.Float,
    alpha: mi.Float,
    coin: mi.Float,
    seed: mi.UInt32,
    analyser: mi.Vector4f,
) -> Scattered:
    """Scatter at an interface as `dielectric.scatter` does.

    Parameters
    ----------
    wi, n, ns, eta, alpha, coin, seed
        What `dielectric.scatter` is given.
    analyser : mi.Vector4f
        First row of the path's Mueller matrix over its first entry: what the camera sees of light that leaves the
        interface along `wi`. Outcomes are drawn by it.

    Returns
    -------
    Scattered
        Its `weight` is a Mueller matrix (mi.Matrix4f) that takes light which travels along ``-direction`` to light
        which travels along `wi`.
    """
    facet, axis = upright_normal(wi, n, ns, eta), mi.mueller.stokes_basis(wi)
    direction, mirrored, M, axis = facet_event(identity(), axis, wi, facet, eta, coin, analyser)
    transmitted, alive = ~mirrored, mi.Bool(True)

    if alpha > 0.0:
        frame = mi.Frame3f(facet)
        first = frame.to_local(mi.mueller.stokes_basis(wi))
        local, transmitted, alive, M, axis = walk_polarised(frame.to_local(wi), first, alpha, eta, seed, analyser)
        direction, axis = frame.to_world(local), frame.to_world(axis)
        # As in `dielectric.scatter`; the frame is mirrored with the ray.
        wrong = (dr.dot(direction, n) < 0.0) != transmitted
        direction = dr.select(wrong, direction - 2.0 * dr.dot(direction, n) * n, direction)
        axis = dr.select(wrong, axis - 2.0 * dr.dot(axis, n) * n, axis)

    direction = dr.normalize(direction)
    M = turned(M, axis, mi.mueller.stokes_basis(-direction), -direction)
    eta_squared = dr.select(transmitted, dr.square(eta), 1.0)
    weight = dr.select(alive, dr.rcp(eta_squared), 0.0)
    return Scattered(direction, as_matrix(M) * mi.Matrix4f(weight), transmitted, eta_squared, mi.Float(1.0))


@syntax
def walk_polarised(
    wi: mi.Vector3f, axis: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32, analyser: mi.Vector4f
) -> tuple[mi.Vector3f, mi.Bool, mi.Bool, Mueller, mi.Vector3f]:
    """Follow a ray over the microsurface as `microsurface.walk` does, facet by facet.

    Parameters
    ----------
    wi, alpha, eta, seed
        What `microsurface.walk` is given.
    axis : mi.Vector3f
        The x axis of the frame of light that leaves along `wi`.
    analyser : mi.Vector4f
        As for `scatter_polarised`, in that frame.

    Returns
    -------
    direction, transmitted, alive
        What `microsurface.walk` returns.
    M : Mueller
        Takes light that arrives against `direction` to light that leaves along `wi`, over the probability of the walk.
    axis : mi.Vector3f
        The x axis of the frame of light that arrives against `direction`.
    """
    numbers = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height, axis, M = mi.Vector3f(-wi), mi.Float(1.0), mi.Vector3f(axis), identity()
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while dr.hint(walking, exclude=[analyser]):
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        reached, leaves = next_height(sign * direction, sign * height, alpha, numbers.next_float32())
        height = sign * reached
        walking &= ~leaves
        facet_at = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        coin = numbers.next_float32()
        if dr.hint(walking, exclude=[analyser]):
            # The event itself is not turned upside down: that would mirror the frames.
            facet = sign * visible_facet(-sign * direction, alpha, facet_at)
            ratio = dr.select(above, eta, dr.rcp(eta))
            direction, mirrored, M, axis = facet_event(M, axis, -direction, facet, ratio, coin, analyser)
            above = above == mirrored
        facets += 1
        walking &= facets < MAX_FACETS

    return direction, ~above, facets < MAX_FACETS, M, axis


def facet_event(
    M: Mueller,
    axis: mi.Vector3f,
    towards: mi.Vector3f,
    facet: mi.Vector3f,
    eta: mi.Float,
    coin: mi.Float,
    analyser: mi.Vector4f,
) -> tuple[mi.Vector3f, mi.Bool, Mueller, mi.Vector3f]:
    """Return where a facet sends a ray, whether it mirrors it, and the matrix and its frame's x axis from there on."""
    cos_i = dr.dot(towards, facet)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    s = across(facet, towards, axis)
    M = turned(M, axis, s, towards)
    mirrored, passed = fresnel_shares(cos_i, -cos_t, eta)
    M, mirrors = drawn(M, analyser, mirrored, passed, cos_t == 0.0, coin)
    direction = dr.select(mirrors, mi.reflect(towards, facet), refracted(towards, facet, cos_i, cos_t, eta_ti))
    return dr.normalize(direction), mirrors, M, s


def analyser_of(throughput: mi.Spectrum) -> mi.Vector4f:
    """Return the first row of a path's Mueller matrix over its first entry, as one for all its wavelengths."""
    first, *others = (dr.sum(throughput[0, column]) for column in range(4))
    scale = dr.select(first > 0.0, dr.rcp(first), 0.0)
    return mi.Vector4f(1.0, *(scale * value for value in others))


def in_world(
    value: mi.Spectrum, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, direction: mi.Vector3f, ray: mi.Ray3f
) -> mi.Spectrum:
    """Return what a BSDF gave, turned from the frames of local directions to those of the world's.

    Mitsuba's own `si.to_world_mueller` takes the world's directions from the local ones. Frames jump where a direction
    is level: they must come from the very ray, not from one that is a rounding away.

    Parameters
    ----------
    value : mi.Spectrum
        The BSDF's value or weight.
    si : mi.SurfaceInteraction3f
        Where the ray arrives.
    wo, direction : mi.Vector3f
        Where the path goes on, in the local frame and in the world.
    ray : mi.Ray3f
        The ray that arrives.
    """
    local = mi.mueller.stokes_basis
    into, out = si.to_world(local(-wo)), si.to_world(local(si.wi))
    return mi.mueller.rotate_mueller_basis(value, -direction, into, local(-direction), -ray.d, out, local(-ray.d))
