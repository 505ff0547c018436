"""Light of a room in its place: gathered at the vertices of its surfaces, with all its small bodies and the table.

The estimate of `room_bodies` comes from radiosity on cells of 25 cm without small bodies. Here rays from every vertex
find what arrives there: by emitter sampling and by cosine-distributed directions, combined by multiple importance
sampling. What they meet sends out the light of the previous round (final gathering). All vertices use the same sample
points, so that the light is smooth over a surface. The objects on the table are left out: they are centimetres large.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.mesh import Mesh
from ...procedural.surroundings.room_bodies import RoomBody
from .._mitsuba import dr, mi
from .emitters import Emitters, emitted, emitter_pdf, sample_emitter, unoccluded
from .rays import leave
from .room_emitter import RoomEmitter, is_of_room

#: Rays of each vertex by each strategy [1]: in the first round, which spreads the light to small bodies, and of these
#: in the last one; and in the last round of walls, floor and ceiling, where shadows fall. (A third number would compile
#: another kernel.)
FEW_RAYS, RAYS = 32, 128
#: Points of the rays start this far off their surface, and at most this far from its edge towards its middle [m], and
#: this share of the way: vertices on an edge would lie in the neighbouring surface.
_LIFT, _INSET, _INSET_FRACTION = 2e-3, 0.012, 0.25
_SHELL = ("wall", "floor", "ceiling", "table-leg")
#: Passes that smooth the light of walls, floor and ceiling, whose shadows are soft: what the few sample points leave
#: are steps in penumbras, that look like stains.
_SMOOTHED, _SMOOTHINGS = ("wall", "floor", "ceiling"), 4
#: Share of rays that meet a surface from behind above which a vertex is taken to be inside a body [1].
_BURIED = 0.3
#: Passes that give vertices inside bodies the light of their neighbours [1], and vertices traced at once.
_SPREADS, _VERTICES_PER_PASS = 8, 1 << 14
#: Offset of the rays from the points [m]: these are above their surface already.
_OFFSET = 1e-5


def lit_room(bake: Emitters, bodies: list[tuple[int, RoomBody, np.ndarray]], table_irradiance: float) -> RoomEmitter:
    """Return the emitter of a room with gathered light.

    Parameters
    ----------
    bake : Emitters
        A scene of room, table and lamps, and the estimate as ``bake.room``.
    bodies : list of (int, RoomBody, (4, 4) float)
        Registry id, surfaces, and ``world_T_room`` of each.
    table_irradiance : float
        Irradiance of the table's top, which reflects light to the ceiling.
    """
    lit = [(body, pose) for _, body, pose in bodies if body.radiance is None]
    points, normals = (np.concatenate(found) for found in zip(*(_origins(*one) for one in lit), strict=True))
    assert bake.room is not None
    large = np.concatenate([np.full(len(body.mesh.vertices), body.part in _SHELL) for body, _ in lit])
    for last in (False, True):
        light, buried = np.empty((len(points), 3)), np.empty(len(points))
        for some, rays in ((large & last, RAYS), (~(large & last), FEW_RAYS)):
            light[some], buried[some] = _all_gathered(bake, points[some], normals[some], rays, table_irradiance)
        corners, first = [], 0
        for _, body, _ in bodies:
            if body.radiance is not None:
                corners.append(first_corners(body))
                continue
            part = slice(first, first + len(body.mesh.vertices))
            found = _spread(body.mesh, light[part], buried[part] > _BURIED)
            passes = _SMOOTHINGS if body.part in _SMOOTHED and len(body.pixels) > 1 else 0
            corners.append(_smoothed(body.mesh, found, passes)[body.mesh.faces])
            first = part.stop
        irradiance = mi.Float(np.concatenate([found.astype(np.float32).ravel() for found in corners]))
        dr.make_opaque(irradiance)
        assert bake.room is not None
        bake = replace(bake, room=replace(bake.room, irradiance=irradiance))
    assert bake.room is not None
    return bake.room


def _origins(body: RoomBody, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where the rays of a body's vertices start, and the normals there, in the world."""
    # Along the surface alone: a cylinder's middle is inside it.
    inward = body.inward - (body.inward * body.normals).sum(axis=1, keepdims=True) * body.normals
    length = np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-9)
    inset = inward * np.minimum(_INSET_FRACTION, _INSET / length)
    points = body.mesh.vertices + inset + _LIFT * body.normals
    return points @ pose[:3, :3].T + pose[:3, 3], body.normals @ pose[:3, :3].T


def _all_gathered(
    bake: Emitters, points: np.ndarray, normals: np.ndarray, rays: int, table: float
) -> tuple[np.ndarray, np.ndarray]:
    if not len(points):
        return np.zeros((0, 3)), np.zeros(0)
    parts = [
        _gathered(bake, points[k : k + _VERTICES_PER_PASS], normals[k : k + _VERTICES_PER_PASS], rays, table)
        for k in range(0, len(points), _VERTICES_PER_PASS)
    ]
    light, buried = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return light, buried


def first_corners(body: RoomBody) -> np.ndarray:
    """Return the estimate at the corners of a body's faces, (m, 3, 3); of a lamp what makes it shine."""
    if body.radiance is not None:
        return np.tile(np.pi * np.array(body.radiance), (len(body.mesh.faces), 3, 1))
    return body.irradiance[body.mesh.faces]


def _spread(mesh: Mesh, light: np.ndarray, buried: np.ndarray) -> np.ndarray:
    """Return the light with that of vertices inside bodies taken from their neighbours, ring by ring."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    light, known = light.copy(), ~buried
    for _ in range(_SPREADS):
        into = edges[~known[edges[:, 0]] & known[edges[:, 1]]]
        if not len(into):
            break
        count = np.bincount(into[:, 0], minlength=len(light))
        total = np.stack([np.bincount(into[:, 0], light[into[:, 1], k], len(light)) for k in range(3)], axis=1)
        found = count > 0
        light[found] = total[found] / count[found, None]
        known = known | found
    light[~known] = 0.0
    return light


def _smoothed(mesh: Mesh, light: np.ndarray, passes: int) -> np.ndarray:
    """Return the light averaged with that of neighbouring vertices, each pass half and half."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    count = np.maximum(np.bincount(edges[:, 0], minlength=len(light)), 1)
    for _ in range(passes):
        sums = [np.bincount(edges[:, 0], light[edges[:, 1], k], len(light)) for k in range(3)]
        light = 0.5 * light + 0.5 * np.stack(sums, axis=1) / count[:, None]
    return light


def _gathered(
    bake: Emitters, points: np.ndarray, normals: np.ndarray, rays: int, table: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the irradiance at points, (n, 3), and the share of their rays that meet a surface from behind, (n,)."""
    count = len(points)
    lane = dr.arange(mi.UInt32, count * rays)
    size = dr.opaque(mi.UInt32, rays)
    vertex = lane // size
    numbers = mi.Float(_sample_points(rays).ravel())
    places, normal = (mi.Float(np.ascontiguousarray(x, np.float32).ravel()) for x in (points, normals))
    dr.make_opaque(numbers, places, normal)
    a, b, c, d = dr.gather(mi.Vector4f, numbers, lane - vertex * size)
    si = dr.zeros(mi.SurfaceInteraction3f, count * rays)
    si.p, si.n = dr.gather(mi.Point3f, places, vertex), dr.gather(mi.Normal3f, normal, vertex)
    offset = dr.opaque(mi.Float, _OFFSET)
    ds, arriving = sample_emitter(bake, si, mi.Point2f(a, b))
    cos = dr.dot(si.n, ds.d)
    arriving = unoccluded(bake, si, (ds, arriving), offset, (ds.pdf > 0.0) & (cos > 0.0))
    weight = ds.pdf / (ds.pdf + dr.maximum(cos, 0.0) * dr.inv_pi)
    direct = dr.select(cos > 0.0, weight * cos * arriving, 0.0)

    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(c, d))
    direction = mi.Frame3f(si.n).to_world(local)
    ray = leave(si, direction, offset)
    pi = bake.scene.ray_intersect_preliminary(ray, False, True)
    met = pi.compute_surface_interaction(ray, mi.RayFlags.All, True)
    pdf = dr.maximum(local.z, 1e-6) * dr.inv_pi
    other = emitter_pdf(bake, si, met, ray, mi.Bool(True))
    radiance = pdf / (pdf + other) * emitted(bake, pi, met, ray, mi.Bool(True))
    behind = met.is_valid() & (dr.dot(met.n, direction) > 0.0)
    radiance = dr.select(behind, 0.0, radiance) + _from_table(bake, met, table)
    values = [*(direct + dr.pi * radiance), dr.select(behind, mi.Float(1.0), 0.0)]
    dr.eval(values)
    means = [np.array(dr.block_sum(value, rays), np.float64) / rays for value in values]
    return np.stack(means[:3], axis=1), means[3]


def _sample_points(count: int) -> np.ndarray:
    """Return two sets of Hammersley points in the unit square, (count, 4) float32: bases 2 and 3 beside the index."""
    index = np.arange(count)
    columns = [(index + 0.5) / count, _radical_inverse(index, 2), (index + 0.5) / count, _radical_inverse(index, 3)]
    return np.stack(columns, axis=1).astype(np.float32)


def _radical_inverse(index: np.ndarray, base: int) -> np.ndarray:
    result, scale, left = np.zeros(len(index)), 1.0 / base, index.copy()
    while left.any():
        left, digit = np.divmod(left, base)
        result, scale = result + digit * scale, scale / base
    return result


def _from_table(bake: Emitters, met: mi.SurfaceInteraction3f, table: float) -> mi.Color3f:
    """Return the radiance of the table's top, which rays met."""
    assert bake.room is not None
    lamp = met.emitter(bake.scene, met.is_valid()) != mi.EmitterPtr(None)
    top = met.is_valid() & ~is_of_room(bake.room, met, mi.Bool(True)) & ~lamp & (met.n.z > 0.5)
    level = dr.opaque(mi.Float, table) * dr.inv_pi
    return dr.select(top, level * mi.Color3f(met.bsdf().eval_diffuse_reflectance(met, top)), 0.0)
