"""A second refractive ray tracer that shares nothing with the product but the triangles: float64 NumPy, brute force.

It keeps its own account of the medium that each ray is in: it starts in air, and each interface leads from the one of
its two media that the ray is in to the other one. It never looks at which side of a surface is which.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glassware.core.mesh import Mesh
from glassware.procedural.description.scene import Prop, Scene

AIR, GLASS, LIQUID = 0, 1, 2
#: The two media that each kind of interface parts.
PAIRS = {"outside": (AIR, GLASS), "wet_wall": (GLASS, LIQUID), "liquid_surface": (LIQUID, AIR)}
#: A hit nearer than this is the surface that the ray starts from [m]; far below any wall, far above float64 rounding.
NEAREST = 1e-9


@dataclass
class Soup:
    """All triangles of a scene: corners and shading normals (n, 3, 3), and which surface each belongs to."""

    corners: np.ndarray
    normals: np.ndarray
    surface: np.ndarray


@dataclass
class Trace:
    """What became of n rays."""

    point: np.ndarray  # (n, 3), NaN where nothing opaque was hit
    direction: np.ndarray
    bounces: np.ndarray
    transmittance: np.ndarray  # (n, 3)
    id: np.ndarray  # 0 for the surroundings, -1 for rays still under way
    contradictions: int  # interfaces met from a medium that is none of their two


def trace(scene: Scene, origin: np.ndarray, direction: np.ndarray, most: int) -> Trace:
    """Trace rays that start in air; each vessel has its own glass and liquid."""
    soup, surfaces = _soup(scene)
    n = len(direction)
    o, d = np.broadcast_to(origin, (n, 3)).astype(float).copy(), direction.astype(float).copy()
    medium = np.zeros(n, int)
    found = Trace(np.full((n, 3), np.nan), d.copy(), np.zeros(n, int), np.ones((n, 3)), np.full(n, -1), 0)
    active = np.ones(n, bool)
    owner = np.full(n, -1)  # the vessel whose glass or liquid the ray is in
    for _ in range(most + 1):
        lanes = np.flatnonzero(active)
        if not len(lanes):
            break
        t, triangle, u, v = _nearest(soup, o[lanes], d[lanes])
        for lane, distance, index, b1, b2 in zip(lanes, t, triangle, u, v, strict=True):
            if not np.isfinite(distance):
                found.id[lane], active[lane] = 0, False
                continue
            kind, vessel, number = surfaces[soup.surface[index]]
            inside = scene.vessels[owner[lane]] if medium[lane] != AIR else None
            found.transmittance[lane] *= np.exp(-np.array(_sigma(inside, medium[lane])) * distance)
            point = o[lane] + distance * d[lane]
            if kind == "opaque":
                found.id[lane], found.point[lane], active[lane] = number, point, False
                continue
            if medium[lane] not in PAIRS[kind]:
                found.contradictions += 1
                active[lane] = False
                continue
            beyond = PAIRS[kind][1] if medium[lane] == PAIRS[kind][0] else PAIRS[kind][0]
            eta = _eta(scene.vessels[vessel], medium[lane]), _eta(scene.vessels[vessel], beyond)
            flat = np.cross(*(soup.corners[index][1:] - soup.corners[index][0]))
            smooth = (1 - b1 - b2) * soup.normals[index][0] + b1 * soup.normals[index][1] + b2 * soup.normals[index][2]
            d[lane], share, crossed = _interface(d[lane], flat, smooth, *eta)
            found.transmittance[lane] *= share
            if crossed:
                medium[lane], owner[lane] = beyond, vessel
            o[lane] = point
            found.bounces[lane] += 1
    found.direction = d
    return found


def _interface(d: np.ndarray, flat: np.ndarray, smooth: np.ndarray, before: float, behind: float):
    """The direction after an interface, the share of light that takes it, and whether it crosses."""
    flat = _unit(flat) * -np.sign(flat @ d)
    smooth = _unit(smooth) * np.sign(smooth @ flat)
    for normal in (smooth, flat):
        cos = -(d @ normal)
        mirrored, bent = d + 2 * cos * normal, _snell(d, normal, before / behind)
        if cos > 0 and mirrored @ flat > 0 and (bent is None or bent @ flat < 0):
            break
    if bent is None:
        return _unit(mirrored), 1.0, False
    inside = -(bent @ normal)
    parallel = (behind * cos - before * inside) / (behind * cos + before * inside)
    across = (before * cos - behind * inside) / (before * cos + behind * inside)
    return _unit(bent), 1.0 - 0.5 * (parallel**2 + across**2), True


def _snell(d: np.ndarray, normal: np.ndarray, ratio: float) -> np.ndarray | None:
    """The refracted direction: its part along the surface grows by the ratio. None for total reflection."""
    along = ratio * (d - (d @ normal) * normal)
    rest = 1.0 - along @ along
    return None if rest <= 0 else along - np.sqrt(rest) * normal


def _nearest(soup: Soup, o: np.ndarray, d: np.ndarray, chunk: int = 32):
    """Nearest triangle of each ray (Moeller and Trumbore 1997): distance, index, barycentric coordinates."""
    a = soup.corners[:, 0]
    e1, e2 = soup.corners[:, 1] - a, soup.corners[:, 2] - a
    results = []
    for start in range(0, len(o), chunk):
        oo, dd = o[start : start + chunk, None], d[start : start + chunk, None]
        p = np.cross(dd, e2)
        det = np.einsum("kj,rkj->rk", e1, p)
        s = oo - a
        q = np.cross(s, e1)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("rkj,rkj->rk", s, p) / det
            v = np.einsum("rj,rkj->rk", dd[:, 0], q) / det
            t = np.einsum("kj,rkj->rk", e2, q) / det
        t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > NEAREST) & (det != 0), t, np.inf)
        best = t.argmin(axis=1)
        rows = np.arange(len(best))
        results.append((t[rows, best], best, u[rows, best], v[rows, best]))
    return tuple(np.concatenate(column) for column in zip(*results, strict=True))


def _soup(scene: Scene) -> tuple[Soup, list[tuple[str, int, int]]]:
    parts = [(scene.table.mesh, np.eye(4), ("opaque", -1, 1))]
    for item in scene.objects:
        if isinstance(item, Prop):
            parts.append((item.mesh, item.world_T_object, ("opaque", -1, item.id)))
        else:
            index = scene.vessels.index(item)
            parts += [(face.mesh, item.world_T_object, (face.part, index, item.id)) for face in item.interfaces]
    corners, normals, surface = [], [], []
    for number, (mesh, pose, _) in enumerate(parts):
        one, two = _triangles(mesh, pose)
        corners.append(one)
        normals.append(two)
        surface.append(np.full(len(one), number))
    return Soup(*(np.concatenate(column) for column in (corners, normals, surface))), [record for *_, record in parts]


def _triangles(mesh: Mesh, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    corners = (mesh.vertices.astype(float) @ pose[:3, :3].T + pose[:3, 3])[mesh.faces]
    if mesh.normals is None:
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return corners, np.repeat(flat[:, None], 3, axis=1)
    return corners, (mesh.normals.astype(float) @ pose[:3, :3].T)[mesh.faces]


def _eta(vessel, medium: int) -> float:
    return (1.0, vessel.glass.eta, vessel.liquid.medium.eta if vessel.liquid else 1.0)[medium]


def _sigma(vessel, medium: int):
    if medium == AIR:
        return (0.0, 0.0, 0.0)
    return vessel.glass.sigma_a if medium == GLASS else vessel.liquid.medium.sigma_a


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
