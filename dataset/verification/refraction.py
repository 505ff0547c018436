"""Refracted rays of some pixels, traced again through the stored interfaces, in float64 NumPy.

A ray keeps its own account of the medium that it is in: it starts in air, and an interface leads from the one of its
two media that the ray is in to the other one. That finds interfaces whose sides are named wrongly.
"""

from __future__ import annotations

import numpy as np

from ...render.frame import HIT, LOST, SURROUNDINGS, Refraction
from .fault import Fault, at_pixels
from .pinhole import Pinhole, image_of, pixel_centres, rays_of, seen_from
from .triangles import LAMP, Triangles

#: Pixels on glass whose rays are traced again, and the most interfaces of a ray that is.
SAMPLED, MOST = 48, 24
#: A hit nearer than this is the surface that the ray starts from [m]: below any wall, above float32 positions.
NEAREST = 2e-6
#: How far the end of a ray may be off [m], and its direction of leaving [rad]: interfaces magnify float32 rounding.
END, DIRECTION = 1e-3, 1e-2
#: Fraction of the sampled rays that may end elsewhere: at grazing angles and rims rounding decides (docs/format.md).
OUTLIERS = 0.15
#: Image coordinates of a point by float32 [px].
FLOW = 0.05


def refraction_contradictions(refraction: Refraction, camera: Pinhole, opaque: list[int], file: str) -> list[Fault]:
    """Check that points, depths, ids and flow of refracted rays agree with each other."""
    state, hit = refraction.state, refraction.hit.astype(np.float64)
    on = state == HIT
    local = seen_from(camera, hit)
    flow = image_of(camera, local)
    flow[..., 0] -= np.arange(state.shape[1])
    flow[..., 1] -= np.arange(state.shape[0])[:, None]
    shown = on & np.isfinite(flow[..., 0]) & np.isfinite(flow[..., 1])
    off = np.abs(np.where(shown[..., None], refraction.flow - flow, 0.0))
    apart = np.maximum(off[..., 0], off[..., 1])
    length = np.sqrt(np.einsum("hwi,hwi->hw", hit, hit))
    depth = np.where(on & (local[..., 2] > 0), local[..., 2], np.nan)
    away = np.abs(np.where(on, refraction.Z, 0.0) - np.where(on, local[..., 2], 0.0))
    return [
        *at_pixels("refraction id", file, on != np.isin(refraction.id, opaque), "an opaque body where hit", state),
        *at_pixels("refraction Z", file, on & ~(away < 1e-5), depth, refraction.Z),
        *at_pixels("refraction flow", file, shown & ~(apart < FLOW), flow, refraction.flow),
        *at_pixels("refraction hit", file, (state == SURROUNDINGS) & (np.abs(length - 1) > 1e-5), "a direction", hit),
    ]


def refraction_faults(
    refraction: Refraction, camera: Pinhole, triangles: Triangles, rng: np.random.Generator, file: str
) -> list[Fault]:
    """Trace the rays of random pixels again."""
    shape = refraction.state.shape
    glass = np.flatnonzero((refraction.bounces.ravel() > 0) & (refraction.bounces.ravel() <= MOST))
    clear = np.flatnonzero((refraction.bounces.ravel() == 0) & (refraction.state.ravel() != LOST))
    picked = np.concatenate([rng.permutation(glass)[:SAMPLED], rng.permutation(clear)[: SAMPLED // 4]])
    if not len(picked):
        return []
    directions = rays_of(camera, pixel_centres(camera)[picked]) @ camera.axes
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points, leaving, ids, bounces = trace(triangles, camera.origin, directions)
    state, hit = refraction.state.ravel()[picked], refraction.hit.reshape(-1, 3)[picked]
    ended = np.where(ids > 0, HIT, np.where(ids == 0, SURROUNDINGS, LOST))
    off = np.where(ids > 0, np.linalg.norm(hit - points, axis=1), np.linalg.norm(hit - leaving, axis=1))
    same = (ended == state) & (off <= np.where(ids > 0, END, DIRECTION))
    same &= (bounces == refraction.bounces.ravel()[picked]) & ((ids <= 0) | (ids == refraction.id.ravel()[picked]))
    if (~same).sum() <= OUTLIERS * len(picked):
        return []
    wrong = np.zeros(refraction.state.size, bool)
    wrong[picked[~same]] = True
    text = f"the ends of {len(picked)} rays traced again, but for {OUTLIERS:.0%}"
    return at_pixels("refraction", file, wrong.reshape(shape), text, refraction.hit)


def trace(triangles: Triangles, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, ...]:
    """Follow rays from air to the first opaque surface.

    Parameters
    ----------
    triangles : Triangles
        The scene.
    origin : (3,) float
        Where all rays start [m].
    directions : (n, 3) float
        Unit vectors.

    Returns
    -------
    points, directions, ids, bounces : (n, 3), (n, 3), (n,), (n,)
        Where each ray ends, or leaves to; the id of what it hits, 0 for the surroundings, -1 for rays still under way
        and those that meet an interface from a medium that is none of its two.
    """
    n = len(directions)
    o, d = np.tile(origin, (n, 1)).astype(np.float64), directions.astype(np.float64).copy()
    air = next((number for number, medium in enumerate(triangles.media) if medium.name == "air"), 0)
    medium, ids, bounces, active = np.full(n, air), np.full(n, -1), np.zeros(n, int), np.ones(n, bool)
    finder = _Finder(triangles)
    for _ in range(MOST + 1):
        lanes = np.flatnonzero(active)
        if not len(lanes):
            break
        t, index, weights = finder.nearest(o[lanes], d[lanes])
        gone = ~np.isfinite(t)
        gone[~gone] = triangles.kind[index[~gone]] == LAMP
        ids[lanes[gone]], active[lanes[gone]] = 0, False
        lanes, t, index, weights = lanes[~gone], t[~gone], index[~gone], weights[~gone]
        o[lanes] += t[:, None] * d[lanes]
        solid = triangles.opaque[index]
        ids[lanes[solid]], active[lanes[solid]] = triangles.id[index[solid]], False
        lanes, index, weights = lanes[~solid], index[~solid], weights[~solid]
        sides = triangles.medium[index]
        known = (sides == medium[lanes, None]).any(axis=1)
        active[lanes[~known]] = False
        lanes, index, weights, sides = lanes[known], index[known], weights[known], sides[known]
        beyond = np.where(sides[:, 0] == medium[lanes], sides[:, 1], sides[:, 0])
        eta = np.array([one.eta for one in triangles.media])
        corners = triangles.corners[index]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        smooth = np.einsum("ki,kij->kj", weights, triangles.normals[index])
        d[lanes], crossed = bent(d[lanes], flat, smooth, eta[medium[lanes]] / eta[beyond])
        medium[lanes] = np.where(crossed, beyond, medium[lanes])
        bounces[lanes] += 1
    return o, d, ids, bounces


def bent(d: np.ndarray, flat: np.ndarray, smooth: np.ndarray, ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return directions after interfaces by Snell's law or total reflection, and whether they cross.

    By the smooth normals; where these send a ray to the wrong side of the triangle, by the triangle's own.

    Parameters
    ----------
    d : (n, 3) float
        Unit directions.
    flat, smooth : (n, 3) float
        The triangles' normals and the interpolated ones, of any length and side.
    ratio : (n,) float
        Index before over index behind.
    """
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    flat *= -np.sign(_dot(flat, d))[:, None]
    smooth = smooth / np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-12)
    smooth *= np.where(_dot(smooth, flat) < 0.0, -1.0, 1.0)[:, None]
    mirrored, through, crosses = _snell(d, smooth, ratio)
    usable = (_dot(smooth, d) < 0.0) & (_dot(mirrored, flat) > 0.0) & (~crosses | (_dot(through, flat) < 0.0))
    other, passed, also = _snell(d, flat, ratio)
    mirrored, through = (np.where(usable[:, None], a, b) for a, b in ((mirrored, other), (through, passed)))
    crosses = np.where(usable, crosses, also)
    after = np.where(crosses[:, None], through, mirrored)
    return after / np.linalg.norm(after, axis=1, keepdims=True), crosses


def _snell(d: np.ndarray, normal: np.ndarray, ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    cos = -_dot(d, normal)
    sin2 = ratio**2 * (1.0 - cos**2)
    crosses = sin2 < 1.0
    mirrored = d + 2.0 * cos[:, None] * normal
    inner = np.sqrt(np.maximum(1.0 - sin2, 0.0))
    through = ratio[:, None] * d + (ratio * cos - inner)[:, None] * normal
    return mirrored, through, crosses


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("kj,kj->k", a, b)


class _Finder:
    """Nearest hits by bounding balls of the triangles, then exactly."""

    def __init__(self, triangles: Triangles) -> None:
        self._corners = triangles.corners
        self._centre = triangles.corners.mean(axis=1)
        self._radius = np.linalg.norm(triangles.corners - self._centre[:, None], axis=-1).max(axis=1) * (1.0 + 1e-9)

    def nearest(self, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return distance, triangle and weights of the first hit of each ray; +inf and -1 for none."""
        n = len(o)
        t, index, weights = np.full(n, np.inf), np.full(n, -1), np.zeros((n, 3))
        for lane in range(n):
            to = self._centre - o[lane]
            along = to @ d[lane]
            near = np.flatnonzero(
                (np.einsum("kj,kj->k", to, to) - along * along <= self._radius**2) & (along > -self._radius)
            )
            distance, inner = _moeller_trumbore(self._corners[near], o[lane], d[lane])
            if len(near) and np.isfinite(distance.min()):
                best = int(distance.argmin())
                t[lane], index[lane], weights[lane] = distance[best], near[best], inner[best]
        return t, index, weights


def _moeller_trumbore(corners: np.ndarray, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return distances to triangles, +inf for none, and the weights of the points (Moeller and Trumbore 1997)."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(d, e2)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1.0 / _dot(e1, p)
        s = o - a
        u = _dot(s, p) * scale
        q = np.cross(s, e1)
        v = (q @ d) * scale
        t = _dot(e2, q) * scale
        inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (t > NEAREST)
    return np.where(inside, t, np.inf), np.stack([1.0 - u - v, u, v], axis=1)
