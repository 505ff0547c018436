"""The stored light, and what opaque surfaces make of it: a diffuse part that is read, a glossy part that is sampled.

What a diffuse surface sends out depends a little on the eye's direction v. With f = (1 - cos)^5 for the light and F for
the eye, roughness r, and n, l the normal and the direction of light, Burley's diffuse lobe (2012, section 5.3) is

    (1 - f/2)(1 - F/2) + R (F + f + F f (R - 1)),    R = 2 r cos^2(half angle) = r (1 + l v),

a polynomial in v. So it follows from moments of the arriving light: E (weight 1), its part weighted with f, and the
mean directions of both. The one square, in the term with F f, is taken at the mean direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import TABLE_ID
from .._mitsuba import dr, mi
from ..pictures.integrator import numbers_of, unshadowed
from ..pictures.sampler import Samples
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import registry_id
from .cache_points import Nodes, lookup_of, nodes_round
from .guiding import Bright, light_along
from .lobes import Gloss, glossy, sampled_gloss, schlick

#: Moments of a node: E (3), E weighted with f (3), mean direction of both (3 each, by luminance).
MOMENTS = 12
#: Roulette follows a glossy bounce with this many times its weight, times what it is likely to find over the diffuse
#: part where that is more than 1, and never with less than `_FOLLOWED`. The mean stays.
_FOLLOW, _FOLLOWED = 3.0, 0.2
#: Lamps in the gloss that add less than this share of the diffuse part are looked at by roulette.
_FAINT = 0.25


@dataclass(frozen=True, eq=False)
class StoredLight:
    """The light that arrives at a scene's opaque surfaces."""

    nodes: Nodes
    moments: np.ndarray  #: (count, 12) float32, irradiance [radiance unit * sr] and unitless mean directions
    samples: np.ndarray  #: (count,) paths that each node is the mean of


def opaque_light(kernel: LoadedScene, stored: StoredLight, bright: Bright) -> Callable[..., tuple]:
    """Return what opaque surfaces do: the radiance towards the eye, and a glossy bounce with its weight and density.

    Bounces towards what is bright are seldom left out: a window that a polished table mirrors is most of its noise.
    """
    table, lookup = kernel.surfaces, lookup_of(stored.nodes)
    values = mi.Float(np.ascontiguousarray(stored.moments, np.float32).ravel())
    look = np.zeros((dr.width(table.instance), 2), np.float32)
    for body in kernel.opaque_bodies:
        look[body.row] = body.roughness, body.metallic
    roughness, metallic = mi.Float(look[:, 0].copy()), mi.Float(look[:, 1].copy())
    dr.make_opaque(values, roughness, metallic)

    def event(
        scene: mi.Scene,
        si: mi.SurfaceInteraction3f,
        corner: mi.Point2f,
        ray: mi.Ray3f,
        offset: mi.Float,
        points: Samples,
        depth: mi.UInt32,
    ) -> tuple[mi.Color3f, mi.Vector3f, mi.Color3f, mi.Float]:
        light, bounce, lobe, gamble = numbers_of(points, depth)
        row, eye = registry_id(si.shape), -ray.d
        instance = dr.gather(mi.UInt32, table.instance, row)
        on_table, lamp = instance == TABLE_ID, instance == 0  # a lamp shines and is black
        gloss = Gloss(
            mi.Color3f(si.bsdf().eval_diffuse_reflectance(si)),
            dr.gather(mi.Float, roughness, row),
            dr.gather(mi.Float, metallic, row),
        )
        frame = mi.Frame3f(dr.select(dr.dot(si.sh_frame.n, eye) < 0.0, -si.sh_frame.n, si.sh_frame.n))
        wi = frame.to_local(eye)
        index, weight = nodes_round(lookup, si, corner, eye, on_table)
        radiance = diffuse(gloss, wi, eye, _moments(values, index, weight))
        plain = dr.max(radiance)
        radiance += _lamp_in_gloss(scene, si, frame, gloss, wi, offset, light, gamble, _FAINT * plain)

        wo = sampled_gloss(gloss, wi, bounce)
        value, pdf = glossy(gloss, wi, wo)
        factor = dr.select(pdf > 0.0, value / pdf, 0.0)
        direction = frame.to_world(wo)
        hope = dr.select(plain > 0.0, light_along(bright, si.p, direction) / plain, dr.inf)
        follow = dr.clip(_FOLLOW * dr.max(factor) * dr.maximum(hope, 1.0), _FOLLOWED, 1.0)
        factor = dr.select(lobe < follow, factor / follow, 0.0)
        radiance, factor = (dr.select(lamp, 0.0, x) for x in (radiance, factor))
        return radiance, direction, factor, pdf

    return event


def _moments(values: mi.Float, index: list[mi.UInt32], weight: list[mi.Float]) -> tuple:
    """Return E, E weighted with f, and their mean directions, interpolated."""
    parts = [dr.zeros(mi.Vector4f) for _ in range(3)]
    for node, share in zip(index, weight, strict=True):
        for k in range(3):
            parts[k] += share * dr.gather(mi.Vector4f, values, 3 * node + k)
    a, b, c = parts
    return mi.Color3f(a.x, a.y, a.z), mi.Color3f(a.w, b.x, b.y), mi.Vector3f(b.z, b.w, c.x), mi.Vector3f(c.y, c.z, c.w)


def diffuse(gloss: Gloss, wi: mi.Vector3f, eye: mi.Vector3f, moments: tuple) -> mi.Color3f:
    """Return what the diffuse part sends to the eye.

    `wi` and `eye` are the same direction, in the frame of the shading normal and in that of the mean directions.
    """
    E, E_f, towards, towards_f = moments
    F, r = schlick(wi.z), gloss.roughness
    R, R_f = r * (1.0 + dr.dot(towards, eye)), r * (1.0 + dr.dot(towards_f, eye))
    seen = (E - 0.5 * E_f) * (1.0 - 0.5 * F) + R * F * E + R_f * E_f + R_f * (R_f - 1.0) * F * E_f
    return dr.maximum((1.0 - gloss.metallic) * dr.inv_pi * gloss.colour * seen, 0.0) & (wi.z > 0.0)


def _lamp_in_gloss(
    scene: mi.Scene,
    si: mi.SurfaceInteraction3f,
    frame: mi.Frame3f,
    gloss: Gloss,
    wi: mi.Vector3f,
    offset: mi.Float,
    sample: mi.Point2f,
    gamble: mi.Float,
    faint: mi.Float,
) -> mi.Color3f:
    """Return the light of a sampled lamp or piece of sky that the surface mirrors.

    Below the radiance `faint` roulette decides whether it is worth a shadow ray.
    """
    ds, arriving = scene.sample_emitter_direction(si, sample, False)
    value, pdf = glossy(gloss, wi, frame.to_local(ds.d))
    share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + pdf))
    radiance = share * value * arriving
    survive = dr.minimum(dr.max(radiance) / faint, 1.0)
    lit = (ds.pdf > 0.0) & (gamble < survive)
    lit = unshadowed(scene, si, ds, offset, lit)
    return dr.select(lit, radiance / survive, 0.0)
