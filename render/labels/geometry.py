"""Label rays: straight rays through exact pixel centres and all surfaces along them, without filter or noise.

One loop along each ray gives the first surface, the background, the silhouettes and, if requested, K layers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.camera import Camera
from ...procedural.description.surroundings import ROOM_IDS
from .._mitsuba import dr, mi, syntax
from ..frame import Eye, Geometry, Layers, LineOfSight, Transmission
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import pinhole, pixel_rays, straight_on, where_met, without_crack
from ..scene.surfaces import SurfaceMedia, SurfaceTable, registry_id, relative_index_d, seen_from_air, surface_media
from .layers import (
    LayerRecorder,
    RayHit,
    layer_recorder,
    recorded_layers,
    recorded_transmission,
    write_layer,
    write_transmission,
)

#: Maximum number of objects of a scene [1]: the silhouettes are bits of a 64-bit integer.
MAX_OBJECTS = 63
#: Maximum number of surfaces along a label ray [1]; more indicate a defect of the scene (a prop has tens at most).
MAX_SURFACES = 4096
#: Smallest ratio of cosines of the path length [1]: rays that graze a face within 0.06 degrees have no exact angle.
_MIN_COSINE = 1e-3
#: Ids of the outer surfaces of a room, next to each other.
_SHELL = tuple(ROOM_IDS[part] for part in ("wall", "floor", "ceiling"))


@dataclass(frozen=True, eq=False)
class StraightHits:
    """What straight rays hit, one entry a ray; distances are along the ray, +inf for nothing."""

    first: mi.Float
    first_id: mi.UInt32
    normal: mi.Normal3f
    background: mi.Float
    background_id: mi.UInt32
    transmittance: mi.Color3f
    crossed: mi.UInt64
    reached: mi.UInt64
    count: mi.UInt32  #: surfaces along the ray, area lights excluded


def trace_geometry(loaded: LoadedScene, camera: Camera, eye: Eye = "left") -> Geometry:
    """Return what the straight rays through the pixel centres of one eye hit (`trace_straight` without layers)."""
    return trace_straight(loaded, camera, 0, eye)[0]


def trace_straight(loaded: LoadedScene, camera: Camera, layers: int, eye: Eye = "left") -> tuple[Geometry, Layers]:
    """Return what the straight rays through the pixel centres of one eye hit, and the first surfaces in order.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    camera : Camera
        The stereo pair.
    layers : int
        Number of surfaces of each ray that are recorded.
    eye : {"left", "right"}
        Which of the two.
    """
    geometry, recorder, count = _recorded(loaded, camera, layers, eye)
    return geometry, recorded_layers(recorder, count, (camera.height, camera.width))


def trace_transmission(loaded: LoadedScene, camera: Camera, layers: int) -> tuple[Geometry, np.ndarray, Transmission]:
    """Return what the straight rays of the left camera hit, and what each surface along them passes on.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    camera : Camera
        The stereo pair.
    layers : int
        Number of surfaces of each ray that are recorded.

    Returns
    -------
    geometry : Geometry
    count : (H, W) int
        Surfaces along each ray, also of those that are not recorded.
    transmission : Transmission
    """
    geometry, recorder, count = _recorded(loaded, camera, layers, "left", transmission=True)
    return geometry, np.array(count).reshape(camera.height, camera.width), recorded_transmission(recorder)


def _recorded(
    loaded: LoadedScene, camera: Camera, layers: int, eye: Eye, transmission: bool = False
) -> tuple[Geometry, LayerRecorder, mi.UInt32]:
    """Trace the rays of one eye; return their geometry, their recorded surfaces, and the number of all of them."""
    objects = len(loaded.description.objects)
    if objects > MAX_OBJECTS:
        raise ValueError(f"a scene of {objects} objects: labels support at most {MAX_OBJECTS}")
    view = pinhole(camera, eye)
    ray, depth_per_distance = pixel_rays(view, dr.arange(mi.UInt32, camera.width * camera.height), mi.Point2f(0.0))
    recorder = layer_recorder(loaded, view, depth_per_distance, layers, transmission)
    hits = straight_hits(loaded, ray, recorder)
    Z, background_Z = hits.first * depth_per_distance, hits.background * depth_per_distance
    facing = dr.select(dr.dot(hits.normal, ray.d) > 0.0, -hits.normal, hits.normal)
    normal = view.world_R_camera.T @ mi.Vector3f(facing)
    dr.eval(Z, background_Z, normal, hits)

    shape = (camera.height, camera.width)
    geometry = Geometry(
        Z=np.array(Z).reshape(shape),
        normal=np.array(normal).T.reshape(*shape, 3).copy(),
        id=np.array(hits.first_id).astype(np.uint16).reshape(shape),
        background_Z=np.array(background_Z).reshape(shape),
        background_id=np.array(hits.background_id).astype(np.uint16).reshape(shape),
        transmittance=np.array(hits.transmittance).T.reshape(*shape, 3).copy(),
        crossed=_bits(hits.crossed, objects, shape),
        reached=_bits(hits.reached, objects, shape),
    )
    return geometry, recorder, hits.count


def line_of_sight(loaded: LoadedScene, origin: np.ndarray, points: np.ndarray) -> LineOfSight:
    """Trace straight rays from `origin` towards each point.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    origin : (3,) float
        The eye, world frame [m].
    points : (n, 3) float
        Targets, world frame [m].
    """
    if len(points) == 0:
        return LineOfSight(np.zeros(0), np.zeros(0))
    direction = dr.normalize(mi.Vector3f(np.ascontiguousarray((points - origin).T, dtype=np.float32)))
    start = dr.opaque(mi.Float, 0.0) + mi.Point3f(np.asarray(origin, dtype=np.float32))
    hits = straight_hits(loaded, mi.Ray3f(start, direction), to_opaque=True)
    dr.eval(hits.first, hits.background)
    return LineOfSight(np.array(hits.first, np.float64), np.array(hits.background, np.float64))


def _bits(word: mi.UInt64, count: int, shape: tuple[int, int]) -> np.ndarray:
    """Return the lowest `count` bits of each ray's integer, (count, H, W) bool."""
    values = np.array(word).reshape(shape)
    bits = np.zeros((count, *shape), bool)
    for i in range(count):
        bits[i] = (values >> np.uint64(i)) & np.uint64(1)
    return bits


@syntax
def straight_hits(
    loaded: LoadedScene, ray: mi.Ray3f, recorder: LayerRecorder | None = None, to_opaque: bool = False
) -> StraightHits:
    """Follow straight rays through all surfaces along them; the recorder takes their layers.

    With `to_opaque` only to the first opaque one: `crossed`, `reached` and `count` are then those of its front.
    """
    scene, table, offset = loaded.mi_scene, loaded.surfaces, mi.Float(loaded.offset)
    robust = loaded.robust_scene
    dr.make_opaque(offset)
    origin, direction, ray = mi.Point3f(ray.o), mi.Vector3f(ray.d), mi.Ray3f(ray)
    first, background = mi.Float(dr.inf), mi.Float(dr.inf)
    first_id, background_id = mi.UInt32(0), mi.UInt32(0)
    normal, transmittance = mi.Normal3f(0.0), mi.Color3f(1.0)
    start_normal = mi.Normal3f(-direction)  # of the surface that the segment starts from
    crossed, reached = mi.UInt64(0), mi.UInt64(0)
    blocker = mi.Int32(-2)  # the first opaque object: -2 none yet, -1 the table, `ROOM_OBJECT` the room
    first_shell, last_shell = dr.opaque(mi.UInt32, min(_SHELL)), dr.opaque(mi.UInt32, max(_SHELL))
    surfaces, count = mi.UInt32(0), mi.UInt32(0)
    active = mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, robust, recorder]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, surfaces == 0, active)
        si = without_crack(si, robust, ray, offset, active)
        si.p = where_met(si, ray)
        row = registry_id(si.shape)
        # Without a room in its place an area light is part of the surroundings, as the sky behind it.
        active &= si.is_valid() & (dr.gather(mi.UInt32, table.label, row, si.is_valid()) > 0)
        nearest = active & (first_id == 0)
        surface = seen_from_air(surface_media(table, si, ray, active), nearest)
        instance = dr.gather(mi.UInt32, table.label, row, active)
        item = dr.gather(mi.Int32, table.object, row, active)
        # Along the whole ray: a sum over its segments would miss their offsets from the surfaces.
        distance = dr.dot(si.p - origin, direction)

        write_layer(recorder, table, count, RayHit(si, ray, distance), active)
        layer = mi.UInt32(count)
        count += dr.select(active, mi.UInt32(1), mi.UInt32(0))

        first = dr.select(nearest, distance, first)
        first_id = dr.select(nearest, instance, first_id)
        normal = dr.select(nearest, si.sh_frame.n, normal)

        unblocked = active & (blocker == -2)
        stops = unblocked & surface.opaque
        background = dr.select(stops, distance, background)
        background_id = dr.select(stops, instance, background_id)
        absorbed, through = straight_passage(table, surface, ray, start_normal, unblocked)
        write_transmission(recorder, layer, dr.select(surface.opaque, 0.0, through), absorbed, unblocked)
        transmittance *= dr.select(unblocked, absorbed * dr.select(surface.opaque, 1.0, through), 1.0)
        start_normal = mi.Normal3f(surface.ns)

        bit = dr.select(active & (item >= 0), mi.UInt64(1) << mi.UInt64(dr.maximum(item, 0)), mi.UInt64(0))
        crossed |= bit
        reached |= dr.select(unblocked | (blocker == item), bit, mi.UInt64(0))
        blocker = dr.select(stops, item, blocker)

        ray = straight_on(si, ray, offset)
        surfaces += 1
        # Behind a wall of the room there is nothing.
        active &= (surfaces < MAX_SURFACES) & ~((instance >= first_shell) & (instance <= last_shell))
        active &= ~(stops & mi.Bool(to_opaque))

    return StraightHits(first, first_id, normal, background, background_id, transmittance, crossed, reached, count)


def straight_transmittance(
    table: SurfaceTable, surface: SurfaceMedia, ray: mi.Ray3f, start_normal: mi.Normal3f, active: mi.Bool
) -> mi.Color3f:
    """Return what a segment and the surface at its end pass on (`straight_passage`); an opaque one changes nothing."""
    absorbed, through = straight_passage(table, surface, ray, start_normal, active)
    return absorbed * dr.select(surface.opaque, 1.0, through)


def straight_passage(
    table: SurfaceTable, surface: SurfaceMedia, ray: mi.Ray3f, start_normal: mi.Normal3f, active: mi.Bool
) -> tuple[mi.Color3f, mi.Float]:
    """Return the Beer-Lambert factor of the segment, and the Fresnel transmittance of the surface at its end.

    A straight ray has no true angle inside glass. By Snell's law n sin(theta) is the same in all layers of a wall with
    parallel faces, so the angle in a medium follows from the straight ray's, which is the one in air. In a round wall
    n r sin(theta) is the same on all surfaces, and r sin(theta) on the straight ray, so each surface has the right
    angle as well.
    """
    index = dr.gather(mi.Float, table.eta_d, surface.before)
    incident = dr.abs(dr.dot(surface.ns, ray.d))
    factor = _path_length_factor(start_normal, surface.ns, ray.d, index)
    absorbed = dr.exp(-dr.gather(mi.Color3f, table.sigma_a_rgb, surface.before, active) * surface.distance * factor)
    cos_i = _inner_cosine(incident, index)
    reflectance, *_ = mi.fresnel(cos_i, relative_index_d(table.eta_d, surface, active))
    return absorbed, 1.0 - reflectance


def _inner_cosine(cos_air: mi.Float, index: mi.Float) -> mi.Float:
    """Return the cosine in a medium of the angle that has a given cosine in air."""
    sin2 = (1.0 - dr.square(cos_air)) / dr.square(index)
    return dr.safe_sqrt(1.0 - sin2)


def _path_length_factor(
    start_normal: mi.Normal3f, end_normal: mi.Normal3f, direction: mi.Vector3f, index: mi.Float
) -> mi.Float:
    """Return the length of the refracted path of a segment over that of the straight one.

    Between parallel faces it is cos / cos' (angles in air and in the medium), because the thickness is the same. Across
    a ball or a round column, whose normals at both ends are mirror images, it is cos' / cos, because the chord of a
    circle is 2 r cos. Both are exact. Between these cases the exponent of the ratio is the cosine of the angle between
    the tangential parts of the normals. Measured for round walls from rays up to 0.9 of their inner radius: within 2 %
    for walls of 2 to 4 mm on a radius of 10 to 35 mm (the straight length: up to 69 % too long).
    """
    ends = [(dr.abs(dr.dot(normal, direction)), normal) for normal in (start_normal, end_normal)]
    (start_cos, start_tangent), (end_cos, end_tangent) = ((cos, normal + cos * direction) for cos, normal in ends)
    ratio = (start_cos + end_cos) / (_inner_cosine(start_cos, index) + _inner_cosine(end_cos, index))
    product = dr.norm(start_tangent) * dr.norm(end_tangent)
    alignment = dr.select(product > 0.0, dr.dot(start_tangent, end_tangent) / product, 1.0)
    return dr.power(dr.maximum(ratio, _MIN_COSINE), alignment)
