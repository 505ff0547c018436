"""Camera rays through glass to the light that is stored: the loop behind pictures from stored light.

It finds what `integrator.trace` finds, in three ways faster. Opaque surfaces answer with stored light, so paths end
early. Fresnel's coin is steered towards bright light (`bright`), and one number per path, spread evenly over the
samples of a pixel together with the place in the pixel, decides all its coins. And lanes do not wait for each other:
the loop knows glass alone, what rays meet behind it is shaded once for all of them, and the few that stay in the glass
for long, or are mirrored by a glossy surface, are gathered for another round.

RGB variants only: no polarisation, no dispersion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

from ...procedural.description.scene import Picture
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import scatter
from ..pictures.integrator import SURVIVE, Radiance, ran_into, relative_index
from ..pictures.picture import Tracer
from ..pictures.sample_weights import SampleWeights
from ..pictures.sampler import Samples, four, hashed, one
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import absorption_at
from ..scene.surfaces import AIR_INDEX, met, registry_id
from .guiding import Bright, bright_map, steered
from .irradiance_cache import StoredLight, opaque_light

#: Where samples pay: stored light leaves little noise but in glass and in what polish mirrors (docs/design.md).
WORTH = SampleWeights(glass=16.0, polished=6.0)
#: Surfaces that rays meet in the first round. Then those that are left are gathered, and go on to their ends. (More
#: rounds before that save as much as they cost.)
_FIRST_ROUND = 6
#: So few rays are followed to their ends at once: a round takes 10 ms, however few it follows, and polished surfaces
#: send rays to and fro for thirty.
_FEW = 1 << 17
#: Rays that have met so few surfaces are traced as neighbours with a common way through the scene: Embree is a third
#: faster on those of the first three surfaces, and slower on later ones.
_TOGETHER = 4
#: Once a path's coins have used up so much of its number, it gets another: a float32 has 24 bits.
_USED_UP = 2.0**-12


@dataclass(frozen=True, eq=False)
class Chain:
    """Rays on their way: the state of the loop."""

    origin: mi.Point3f
    direction: mi.Vector3f
    beta: mi.Color3f  #: throughput
    L: mi.Color3f  #: radiance so far
    eta_scale: mi.Float  #: product of eta^2, which roulette must not take for loss
    pdf: mi.Float  #: density of the last direction, and whether emitter sampling could not have found it
    delta: mi.Bool
    medium: mi.UInt32  #: the segment's, by the events so far
    chance: mi.Float  #: what is left of the path's number, in [0, 1), ...
    left: mi.Float  #: ... and the share of all numbers that led here
    depth: mi.UInt32
    violations: mi.UInt32
    active: mi.Bool
    pixel: mi.UInt32  #: which sample of which pixel the path is
    index: mi.UInt32
    lane: mi.UInt32  #: where its light goes


def reading(kernel: LoadedScene, stored: StoredLight) -> Tracer:
    """Return the tracer that reads stored light."""
    bright = bright_map(kernel.description)
    surface = opaque_light(kernel, stored, bright)

    def trace(
        kernel: LoadedScene, ray: mi.Ray3f, weight: mi.UnpolarizedSpectrum, points: Samples, picture: Picture
    ) -> Radiance:
        return follow(kernel, ray, points, picture, surface, bright)

    return Tracer(trace, WORTH)


def follow(
    kernel: LoadedScene, ray: mi.Ray3f, points: Samples, picture: Picture, surface: Callable[..., tuple], bright: Bright
) -> Radiance:
    """Follow camera rays; return what they bring back, evaluated.

    Parameters
    ----------
    kernel : LoadedScene
        The scene.
    ray, points
        From `picture.camera_paths`.
    picture : Picture
        How long paths may be.
    surface : callable
        What opaque surfaces do (`stored.opaque_light`).
    bright : Bright
        Where light comes from, roughly.
    """

    def advanced(chain: Chain, surfaces: int = picture.max_depth) -> Chain:
        return _advanced(kernel, chain, points, picture, surfaces, surface, bright)

    chain = advanced(_beginning(ray, points), _FIRST_ROUND)
    dr.eval(chain)
    found = chain.L, chain.violations, chain.depth
    which = dr.compress(chain.active)
    while dr.width(which) > 0:
        rest = _those(chain, which)
        chain = advanced(rest) if dr.width(which) > _FEW else _to_the_end(rest, advanced)
        dr.eval(chain)
        for into, value in zip(found, (chain.L, chain.violations, chain.depth), strict=True):
            dr.scatter(into, value, chain.lane, mode=dr.ReduceMode.Permute)
        which = dr.compress(chain.active)
    dr.eval(found)
    return Radiance(*found)


def _beginning(ray: mi.Ray3f, points: Samples) -> Chain:
    lanes = dr.width(points.index)
    none, air, first = mi.Color3f(0.0), mi.UInt32(AIR_INDEX), mi.UInt32(0)
    number = one(points, mi.UInt32(0), mi.UInt32(3))  # of the camera's set, beside the place in the pixel
    start = (mi.Color3f(1.0), none, mi.Float(1.0), mi.Float(1.0), mi.Bool(True), air, number, mi.Float(1.0))
    return Chain(
        ray.o, ray.d, *start, first, first, mi.Bool(True), points.pixel, points.index, dr.arange(mi.UInt32, lanes)
    )


def _those(chain: Chain, which: mi.UInt32) -> Chain:
    return Chain(*(dr.gather(type(value), value, which) for value in _values(chain)))


def _values(chain: Chain) -> tuple:
    return tuple(getattr(chain, field.name) for field in fields(chain))


@syntax
def _to_the_end(chain: Chain, advanced: Callable[[Chain], Chain]) -> Chain:
    """Follow rays until all have ended, in one kernel."""
    state, active = _values(chain), mi.Bool(chain.active)
    while dr.hint(active, exclude=[chain, advanced]):
        found = advanced(Chain(*state))
        state, active = _values(found), mi.Bool(found.active)
    return Chain(*state)


def _advanced(
    kernel: LoadedScene,
    chain: Chain,
    points: Samples,
    picture: Picture,
    surfaces: int,
    surface: Callable[..., tuple],
    bright: Bright,
) -> Chain:
    """Follow rays through so many surfaces at most, and shade what those meet that come out of the glass."""
    points = replace(points, pixel=chain.pixel, index=chain.index)
    inside = _through_glass(kernel, chain, points, picture, surfaces, bright)
    return _shaded(kernel, *inside, points, picture, surface)


@syntax
def _through_glass(
    kernel: LoadedScene, chain: Chain, points: Samples, picture: Picture, surfaces: int, bright: Bright
) -> tuple[Chain, mi.PreliminaryIntersection3f, mi.Bool]:
    """Follow rays until they meet something opaque or nothing, end, or have met `surfaces`.

    Returns the rays, with their last segment, what they met there, and which of them are outside the glass.
    """
    scene, table = kernel.mi_scene, kernel.surfaces
    offset, limit = dr.opaque(mi.Float, kernel.offset), chain.depth + dr.opaque(mi.UInt32, surfaces)
    rr_depth, last = dr.opaque(mi.UInt32, picture.rr_depth), dr.opaque(mi.UInt32, picture.max_depth)
    ray, beta = mi.Ray3f(chain.origin, chain.direction), mi.Color3f(chain.beta)
    # (Copies: the loop must not change what the caller holds.)
    eta_scale, pdf, chance, left = (mi.Float(x) for x in (chain.eta_scale, chain.pdf, chain.chance, chain.left))
    medium, depth, violations = (mi.UInt32(x) for x in (chain.medium, chain.depth, chain.violations))
    delta, active, outside = mi.Bool(chain.delta), mi.Bool(chain.active), mi.Bool(False)
    pi = dr.zeros(mi.PreliminaryIntersection3f)

    while dr.hint(active & (depth < limit), exclude=[table, scene, points, bright]):
        pi = scene.ray_intersect_preliminary(ray, depth < _TOGETHER, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
        hit = active & si.is_valid()
        opaque, facing, beyond, n, ns = met(table, si, ray, hit)
        violations += dr.select(facing != medium, mi.UInt32(1), mi.UInt32(0))
        sigma_a = absorption_at(table.absorption, facing, si.wavelengths, active)
        beta *= dr.exp(-sigma_a * dr.select(hit, si.t, 0.0))
        outside = ~hit | opaque
        active = hit & ~opaque
        medium = mi.UInt32(facing)

        if dr.hint(active, exclude=[table, scene, points, bright]):
            bits = hashed(points, depth)
            eta = relative_index(table, facing, beyond, si.wavelengths)
            alpha = dr.gather(mi.Float, table.alpha, registry_id(si.shape))
            odds = steered(bright, dr.gather(mi.Float, table.eta, facing), dr.max(beta) * eta_scale)
            event = scatter(-ray.d, n, ns, eta, alpha, chance, bits, odds, _first_facet(points, depth, alpha))
            beta *= event.weight
            eta_scale *= event.eta_squared
            medium = dr.select(event.transmitted, beyond, facing)
            chance, left = _remaining(chance, left, event.share, event.transmitted, bits)
            ray, pdf, delta = leave(si, event.direction, offset), mi.Float(1.0), mi.Bool(True)
            beta, active = _lucky(beta, eta_scale, depth + 1 >= rr_depth, bits)
        depth += 1
        active &= depth < last

    state = beta, chain.L, eta_scale, pdf, delta, medium, chance, left, depth, violations, active
    return Chain(ray.o, ray.d, *state, chain.pixel, chain.index, chain.lane), pi, outside


@syntax
def _first_facet(points: Samples, depth: mi.UInt32, alpha: mi.Float) -> mi.Point3f:
    """Return well-spread numbers for the first facet of rough interfaces: of the set that gloss has at this depth."""
    first = mi.Point3f(0.0)
    if dr.hint(alpha > 0.0, exclude=[points]):
        u, v, coin, _ = four(points, 2 + 2 * depth)
        first = mi.Point3f(u, v, coin)
    return first


@syntax
def _shaded(
    kernel: LoadedScene,
    chain: Chain,
    pi: mi.PreliminaryIntersection3f,
    outside: mi.Bool,
    points: Samples,
    picture: Picture,
    surface: Callable[..., tuple],
) -> Chain:
    """Add the light that rays find outside the glass, and turn those into the mirrored direction that go on."""
    scene, offset = kernel.mi_scene, dr.opaque(mi.Float, kernel.offset)
    rr_depth, last = dr.opaque(mi.UInt32, picture.rr_depth), dr.opaque(mi.UInt32, picture.max_depth)
    ray, beta, depth = mi.Ray3f(chain.origin, chain.direction), mi.Color3f(chain.beta), mi.UInt32(chain.depth)
    pdf, delta, active, eta_scale = mi.Float(chain.pdf), mi.Bool(chain.delta), mi.Bool(chain.active), chain.eta_scale
    si = pi.compute_surface_interaction(ray, mi.RayFlags.All, outside)
    previous = dr.zeros(mi.Interaction3f)
    previous.p = ray.o
    L = chain.L + beta * ran_into(scene, si, previous, pdf, delta, outside)

    if dr.hint(outside & si.is_valid(), exclude=[scene, points]):
        before = depth - 1  # as many surfaces were met before this one
        light, direction, factor, pdf = surface(scene, si, pi.prim_uv, ray, offset, points, before)
        L += beta * light
        beta *= factor
        ray, delta = leave(si, direction, offset), mi.Bool(False)
        beta, active = _lucky(beta, eta_scale, depth >= rr_depth, hashed(points, before))
        active &= depth < last

    state = beta, L, eta_scale, pdf, delta, chain.medium, chain.chance, chain.left, depth, chain.violations
    return Chain(ray.o, ray.d, *state, active, chain.pixel, chain.index, chain.lane)


def _lucky(beta: mi.Color3f, eta_scale: mi.Float, at_stake: mi.Bool, bits: mi.UInt32) -> tuple[mi.Color3f, mi.Bool]:
    """Play roulette where it is `at_stake`; return the throughput of those that survive, and which do."""
    survive = dr.select(at_stake, dr.minimum(dr.max(beta) * eta_scale, SURVIVE), 1.0)
    return beta * dr.rcp(survive), dr.any(beta > 0.0) & (_number(bits, 1) < survive)


def _remaining(
    chance: mi.Float, left: mi.Float, share: mi.Float, transmitted: mi.Bool, bits: mi.UInt32
) -> tuple[mi.Float, mi.Float]:
    """Return the number as it lies within the interval of the outcome that it chose: uniform again."""
    within = dr.select(transmitted, chance - (1.0 - share), chance) / share
    left = left * share
    fresh = left < _USED_UP
    within = dr.select(fresh, _number(bits, 2), dr.clip(within, 0.0, 1.0 - 2.0**-24))
    return within, dr.select(fresh, 1.0, left)


def _number(bits: mi.UInt32, which: int) -> mi.Float:
    """Return one of the numbers in [0, 1) that follow from a hash (Wellons' triple32 without its last round)."""
    x = bits + mi.UInt32(which * 0x9E3779B9 & 0xFFFFFFFF)
    x = (x ^ (x >> 17)) * 0xED5AD4BB
    x = (x ^ (x >> 11)) * 0xAC4C1B51
    return mi.Float((x ^ (x >> 15)) >> 8) * 2.0**-24
