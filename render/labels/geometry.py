"""The label pass: straight rays through exact pixel centres, everything that they meet, no filter.

One walk along each ray gives the first surface, the background, the silhouettes and, where asked for, K layers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.surroundings import Camera
from .._mitsuba import dr, mi, syntax
from ..frame import Eye, Geometry, Layers
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import clearance, leave, pinhole, pixel_rays
from ..scene.surfaces import registry_id
from .layers import Recorder, layers_of, record, recorder

#: Most objects a scene can hold: the silhouettes are bits of one 64-bit number.
MAX_OBJECTS = 63
#: Most surfaces a label ray passes; a ray that meets more is a fault of the scene (a prop has tens at the most).
MAX_SURFACES = 4096


@dataclass(frozen=True, eq=False)
class Straight:
    """What straight rays met, one entry a ray; distances are along the ray, inf for none."""

    first: mi.Float
    first_id: mi.UInt32
    normal: mi.Normal3f
    background: mi.Float
    background_id: mi.UInt32
    transmittance: mi.Color3f
    crossed: mi.UInt64
    reached: mi.UInt64
    met: mi.UInt32  #: surfaces along the ray, lamps excepted


def trace_geometry(kernel: LoadedScene, camera: Camera, eye: Eye = "left") -> Geometry:
    """Return what the straight rays through the pixel centres of one eye meet (`trace_straight` without layers)."""
    return trace_straight(kernel, camera, 0, eye)[0]


def trace_straight(kernel: LoadedScene, camera: Camera, layers: int, eye: Eye = "left") -> tuple[Geometry, Layers]:
    """Return what the straight rays through the pixel centres of one eye meet, and the first surfaces in order.

    Parameters
    ----------
    kernel : LoadedScene
        The loaded scene.
    camera : Camera
        The stereo pair.
    layers : int
        How many surfaces of each ray are recorded.
    eye : {"left", "right"}
        Which of the two.
    """
    objects = len(kernel.description.objects)
    if objects > MAX_OBJECTS:
        raise ValueError(f"a scene of {objects} objects: the label pass holds {MAX_OBJECTS} at the most")
    view = pinhole(camera, eye)
    ray, depth_per_distance = pixel_rays(view, dr.arange(mi.UInt32, camera.width * camera.height), mi.Point2f(0.0))
    into = recorder(kernel, view, depth_per_distance, layers)
    seen = straight(kernel, ray, into)
    Z, background_Z = seen.first * depth_per_distance, seen.background * depth_per_distance
    facing = dr.select(dr.dot(seen.normal, ray.d) > 0.0, -seen.normal, seen.normal)
    normal = view.world_R_camera.T @ mi.Vector3f(facing)
    dr.eval(Z, background_Z, normal, seen)

    shape = (camera.height, camera.width)
    geometry = Geometry(
        Z=np.array(Z).reshape(shape),
        normal=np.array(normal).T.reshape(*shape, 3).copy(),
        id=np.array(seen.first_id).astype(np.uint16).reshape(shape),
        background_Z=np.array(background_Z).reshape(shape),
        background_id=np.array(seen.background_id).astype(np.uint16).reshape(shape),
        transmittance=np.array(seen.transmittance).T.reshape(*shape, 3).copy(),
        crossed=_bits(seen.crossed, objects, shape),
        reached=_bits(seen.reached, objects, shape),
    )
    return geometry, layers_of(into, seen.met, shape)


def _bits(word: mi.UInt64, count: int, shape: tuple[int, int]) -> np.ndarray:
    numbers = np.array(word).reshape(shape)
    return (
        np.stack([(numbers >> np.uint64(i)) & np.uint64(1) for i in range(count)]).astype(bool)
        if count
        else (np.zeros((0, *shape), bool))
    )


@syntax
def straight(kernel: LoadedScene, ray: mi.Ray3f, into: Recorder | None = None) -> Straight:
    """Follow straight rays through everything that they meet; `into` takes their layers."""
    scene, table, offset = kernel.mi_scene, kernel.surfaces, mi.Float(kernel.offset)
    dr.make_opaque(offset)
    origin, direction, ray = mi.Point3f(ray.o), mi.Vector3f(ray.d), mi.Ray3f(ray)
    first, background = mi.Float(dr.inf), mi.Float(dr.inf)
    first_id, background_id = mi.UInt32(0), mi.UInt32(0)
    normal, transmittance = mi.Normal3f(0.0), mi.Color3f(1.0)
    crossed, reached = mi.UInt64(0), mi.UInt64(0)
    blocker = mi.Int32(-2)  # the first opaque object: -2 none yet, -1 the table
    surfaces, met = mi.UInt32(0), mi.UInt32(0)
    active = mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, into]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, surfaces == 0, active)
        row = registry_id(si.shape)
        # A lamp is part of the surroundings: as empty as the sky behind it.
        active &= si.is_valid() & (dr.gather(mi.UInt32, table.instance, row, si.is_valid()) > 0)
        instance = dr.gather(mi.UInt32, table.instance, row, active)
        thing = dr.gather(mi.Int32, table.object, row, active)
        opaque = dr.gather(mi.Bool, table.opaque, row, active)
        # Along the whole ray: a sum over its segments would miss the little that each starts off its surface.
        distance = dr.dot(si.p - origin, direction)

        record(into, table, met, si, ray, distance, active)
        met += dr.select(active, mi.UInt32(1), mi.UInt32(0))

        nearest = active & (first_id == 0)
        first = dr.select(nearest, distance, first)
        first_id = dr.select(nearest, instance, first_id)
        normal = dr.select(nearest, si.sh_frame.n, normal)

        before = active & (blocker == -2)
        stops = before & opaque
        background = dr.select(stops, distance, background)
        background_id = dr.select(stops, instance, background_id)
        passed = _straight_transmittance(table, si, ray, row, before)
        transmittance *= dr.select(before, passed, 1.0)

        bit = dr.select(active & (thing >= 0), mi.UInt64(1) << mi.UInt64(dr.maximum(thing, 0)), mi.UInt64(0))
        crossed |= bit
        reached |= dr.select(before | (blocker == thing), bit, mi.UInt64(0))
        blocker = dr.select(stops, thing, blocker)

        ray = leave(si, ray.d, clearance(si, ray, offset))
        surfaces += 1
        active &= surfaces < MAX_SURFACES

    return Straight(first, first_id, normal, background, background_id, transmittance, crossed, reached, met)


def _straight_transmittance(table, si, ray, row, active) -> mi.Color3f:
    """Return Beer-Lambert along the segment that ends here times what Fresnel lets through the surface.

    A straight ray has no true angle inside glass. The angle is taken as the one on the side of the lower index, which
    is exact for plates with parallel faces, as most of a vessel's wall is.
    """
    from_front = dr.dot(si.n, ray.d) < 0.0
    front, back = dr.gather(mi.UInt32, table.front, row, active), dr.gather(mi.UInt32, table.back, row, active)
    facing, beyond = dr.select(from_front, front, back), dr.select(from_front, back, front)
    sigma_a = dr.gather(mi.Color3f, table.sigma_a, facing, active)
    eta = dr.gather(mi.Float, table.eta, beyond, active) / dr.gather(mi.Float, table.eta, facing, active)
    reflectance, *_ = mi.fresnel(dr.abs(dr.dot(si.sh_frame.n, ray.d)), dr.maximum(eta, dr.rcp(eta)))
    opaque = dr.gather(mi.Bool, table.opaque, row, active)
    return dr.exp(-sigma_a * si.t) * dr.select(opaque, 1.0, 1.0 - reflectance)
