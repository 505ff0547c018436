"""A room in its place: surfaces with stored light, at which rays end, and a view outside behind the windows.

What a surface of the room sends out was worked out before (`room_light_map`), so a path that meets it reads it and
ends, as at an environment map. Emitters are sampled by the room's map from the table's centre, which serves as a
density alone: its direction chooses a point of the room's six faces (the shell), and the ray goes to that point from
wherever it starts. For points inside the shell this maps directions to directions one to one, so the density is exact
(`from_shell`, `to_shell`), and the radiance is that of the surface or the view that the ray meets.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.surroundings import RoomEnvironment
from .._mitsuba import dr, mi
from .spectrum import unpolarised
from .surfaces import registry_id

#: Smallest cosine and distance that are divided by [1], [m].
_TINY = 1e-6


@dataclass(frozen=True, eq=False)
class RoomEmitter:
    """The room's surfaces as opaque Dr.Jit arrays."""

    is_room: mi.Bool  #: by registry id: whether the shape is a surface of the room
    first_face: mi.UInt32  #: by registry id: number of the shape's first face in `irradiance`
    irradiance: mi.Float  #: by face: three of each corner, radiance times steradians
    outside: mi.Float  #: (rows, 2 * rows, 3) radiance by direction behind the windows, in the room's frame
    outside_rows: mi.UInt32
    environment: mi.EmitterPtr  #: the map from the table's centre
    cos: mi.Float  #: of the room's rotation
    sin: mi.Float
    eye: mi.Point3f  #: the world's origin in the room [m]
    size: mi.Vector3f  #: of the room [m]
    surfaces: mi.Scene  #: the room's surfaces alone

    def to_room(self, v: mi.Vector3f) -> mi.Vector3f:
        """Return a direction in the room's frame."""
        return mi.Vector3f(self.cos * v.x + self.sin * v.y, self.cos * v.y - self.sin * v.x, v.z)

    def to_world(self, v: mi.Vector3f) -> mi.Vector3f:
        """Return a direction of the room's frame in the world."""
        return mi.Vector3f(self.cos * v.x - self.sin * v.y, self.sin * v.x + self.cos * v.y, v.z)


def room_emitter(
    room: RoomEnvironment,
    mi_scene: mi.Scene,
    surfaces: mi.Scene,
    rows: dict[int, np.ndarray],
    outside: np.ndarray,
) -> RoomEmitter:
    """Return the emitter of a room.

    Parameters
    ----------
    room : RoomEnvironment
        The room.
    mi_scene, surfaces : mi.Scene
        The whole scene, and the room's surfaces alone.
    rows : dict of int to (n, 3, 3) float
        By registry id of each surface: the irradiance of its faces' corners.
    outside : (h, 2 * h, 3) float32
        The view outside.
    """
    count = max(int(registry_id(mi.ShapePtr(shape))[0]) for shape in mi_scene.shapes()) + 1
    is_room, first, parts, total = np.zeros(count, bool), np.zeros(count, np.uint32), [], 0
    for row, corners in rows.items():
        is_room[row], first[row] = True, total
        parts.append(corners.astype(np.float32).ravel())
        total += len(corners)
    found = RoomEmitter(
        is_room=mi.Bool(is_room),
        first_face=mi.UInt32(first),
        irradiance=mi.Float(np.concatenate(parts)),
        outside=mi.Float(np.ascontiguousarray(outside, np.float32).ravel()),
        outside_rows=mi.UInt32(len(outside)),
        environment=mi.EmitterPtr(mi_scene.environment()),
        cos=mi.Float(float(np.cos(room.rotation))),
        sin=mi.Float(float(np.sin(room.rotation))),
        eye=mi.Point3f(*map(float, room.eye)),
        size=mi.Vector3f(*map(float, room.size)),
        surfaces=surfaces,
    )
    arrays = (found.is_room, found.first_face, found.irradiance, found.outside, found.outside_rows)
    dr.make_opaque(*arrays, found.environment, found.cos, found.sin, found.eye, found.size)
    return found


def is_of_room(room: RoomEmitter, si: mi.SurfaceInteraction3f, active: mi.Bool) -> mi.Bool:
    """Return where rays met a surface of the room."""
    valid = active & si.is_valid()
    return valid & dr.gather(mi.Bool, room.is_room, registry_id(si.shape), valid)


def room_radiance(
    room: RoomEmitter, pi: mi.PreliminaryIntersection3f, si: mi.SurfaceInteraction3f, d: mi.Vector3f, active: mi.Bool
) -> mi.Spectrum:
    """Return what the room sends against rays of direction `d` that met its surfaces, or nothing; else 0."""
    met = is_of_room(room, si, active)
    E = corner_irradiance(room, registry_id(si.shape), pi, met)
    reflectance = unpolarised(si.bsdf().eval_diffuse_reflectance(si, met))
    albedo = mi.Color3f(reflectance if mi.is_rgb else reflectance[0])
    light = dr.select(met, albedo * E * dr.inv_pi, dr.select(active & ~si.is_valid(), outside_along(room, d), 0.0))
    # In variants of one channel all three are the same.
    return light if mi.is_rgb else mi.Spectrum(mi.UnpolarizedSpectrum(light.x))


def corner_irradiance(
    room: RoomEmitter, row: mi.UInt32, pi: mi.PreliminaryIntersection3f, active: mi.Bool
) -> mi.Color3f:
    """Return the irradiance interpolated between the corners of a face."""
    face = 3 * (dr.gather(mi.UInt32, room.first_face, row, active) + pi.prim_index)
    b, c = pi.prim_uv
    corners = (dr.gather(mi.Color3f, room.irradiance, face + k, active) for k in range(3))
    return sum((w * E for w, E in zip((1.0 - b - c, b, c), corners, strict=True)), mi.Color3f(0.0))


def outside_along(room: RoomEmitter, d: mi.Vector3f) -> mi.Color3f:
    """Return the radiance outside along a direction, by bilinear lookup."""
    d = room.to_room(d)
    rows, columns = mi.Float(room.outside_rows), mi.Float(2 * room.outside_rows)
    v = dr.clip(dr.safe_acos(d.z) * dr.inv_pi * rows - 0.5, 0.0, rows - 1.001)
    u = dr.atan2(d.y, d.x) * dr.inv_two_pi
    u = dr.clip((u - dr.floor(u)) * columns - 0.5, -0.5, columns)
    row, column = mi.UInt32(v), mi.Int32(dr.floor(u))
    fv, fu, width = v - mi.Float(row), u - mi.Float(column), mi.Int32(2 * room.outside_rows)
    left, right = mi.UInt32((column + width) % width), mi.UInt32((column + 1) % width)

    def texel(r: mi.UInt32, c: mi.UInt32) -> mi.Color3f:
        return dr.gather(mi.Color3f, room.outside, r * mi.UInt32(width) + c)

    top = dr.lerp(texel(row, left), texel(row, right), fu)
    return dr.lerp(top, dr.lerp(texel(row + 1, left), texel(row + 1, right), fu), fv)


def _exit(room: RoomEmitter, p: mi.Vector3f, d: mi.Vector3f) -> tuple[mi.Float, mi.Float]:
    """Return how far it is from a point of the room's frame to the shell, and the cosine there."""
    best, cos = mi.Float(dr.inf), mi.Float(1.0)
    for k in range(3):
        slope = dr.select(dr.abs(d[k]) < _TINY, _TINY, d[k])
        t = (dr.select(slope > 0.0, room.size[k], 0.0) - p[k]) / slope
        cos = dr.select(t < best, dr.abs(slope), cos)
        best = dr.minimum(t, best)
    return best, cos


def _inside(room: RoomEmitter, p: mi.Vector3f) -> mi.Bool:
    within = mi.Bool(True)
    for k in range(3):
        within &= (p[k] > 0.0) & (p[k] < room.size[k])
    return within


def _place(room: RoomEmitter, p: mi.Point3f) -> mi.Vector3f:
    return room.to_room(mi.Vector3f(p)) + mi.Vector3f(room.eye)


def shell_point(room: RoomEmitter, d: mi.Vector3f) -> tuple[mi.Point3f, mi.Normal3f, mi.Float]:
    """Return where directions from the table's centre meet the shell, its normal there, and its area per solid angle.

    The normal points outwards; the area is r^2 / cos [m^2/sr].
    """
    centre, local = mi.Vector3f(room.eye), room.to_room(d)
    r, cos = _exit(room, centre, local)
    end, normal = centre + r * local, mi.Vector3f(0.0)
    for k in range(3):
        middle = end[k] - 0.5 * room.size[k]
        normal[k] = dr.select(dr.abs(dr.abs(local[k]) - cos) < _TINY, dr.sign(middle), 0.0)
    return mi.Point3f(r * d), mi.Normal3f(dr.normalize(room.to_world(normal))), dr.square(r) / cos


def radiance_towards(room: RoomEmitter, p: mi.Point3f, d: mi.Vector3f) -> tuple[mi.Spectrum, mi.Float]:
    """Return what the room alone sends to a point against a direction, and how far away that is [m]; +inf outside."""
    ray = mi.Ray3f(p, d)
    pi = room.surfaces.ray_intersect_preliminary(ray, False, True)
    si = pi.compute_surface_interaction(ray, mi.RayFlags.All, True)
    return room_radiance(room, pi, si, d, mi.Bool(True)), dr.select(si.is_valid(), si.t, dr.inf)


def from_shell(room: RoomEmitter, p: mi.Point3f, d: mi.Vector3f) -> tuple[mi.Vector3f, mi.Float]:
    """Return the direction from a point to where a direction from the table's centre meets the shell.

    The second value is the density of that direction over that of the direction from the centre: areas of the shell
    are seen under solid angles that go with cos / r^2. It is 0 for points outside the shell.
    """
    centre, local, place = mi.Vector3f(room.eye), room.to_room(d), _place(room, p)
    r, cos = _exit(room, centre, local)
    away = centre + r * local - place
    distance = dr.maximum(dr.norm(away), _TINY)
    direction = away / distance
    _, cos_p = _exit(room, place, direction)
    factor = cos * dr.square(distance) / (dr.square(r) * cos_p)
    return room.to_world(direction), dr.select(_inside(room, place), factor, 0.0)


def to_shell(room: RoomEmitter, p: mi.Point3f, d: mi.Vector3f) -> tuple[mi.Vector3f, mi.Float]:
    """Return the direction from the table's centre to where a ray meets the shell, and the factor of `from_shell`."""
    centre, local, place = mi.Vector3f(room.eye), room.to_room(d), _place(room, p)
    distance, cos_p = _exit(room, place, local)
    away = place + distance * local - centre
    r = dr.maximum(dr.norm(away), _TINY)
    direction = away / r
    _, cos = _exit(room, centre, direction)
    factor = cos * dr.square(distance) / (dr.square(r) * cos_p)
    return room.to_world(direction), dr.select(_inside(room, place), factor, 0.0)
