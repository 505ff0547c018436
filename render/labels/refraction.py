"""Refracted label rays: where a camera ray ends behind glass, with derivatives if requested.

At every interface the refracted ray is followed, or the reflected one at total internal reflection, to the first opaque
surface or out of the scene. No random number is used. Rough interfaces count as smooth ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.errors import InputError
from ...procedural.description.camera import Camera
from .._mitsuba import dr, mi, syntax
from ..frame import HIT, LOST, SURROUNDINGS, Eye, Refraction
from ..interfaces.dielectric import transmission
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import Pinhole, leave, pinhole, pixel_rays, where_met, without_crack
from ..scene.surfaces import registry_id, relative_index_d, seen_from_air, surface_media, transmittance_rgb

#: Maximum number of interfaces of a ray [1]; a ray that meets more is lost. In eight drawn scenes (32 views) 4 % of the
#: pixels on glass meet 16 or more, 2 % meet 32, and 1 % (0.04 % of all pixels) are lost at 64: total internal
#: reflection traps their rays.
MAX_INTERFACES = 64


@dataclass(frozen=True, eq=False)
class Refracted:
    """Where refracted rays end, one entry a ray."""

    state: mi.UInt32  #: `SURROUNDINGS`, `HIT` or `LOST`
    point: mi.Point3f  #: the point on the opaque surface, world frame [m]; only for `HIT`
    direction: mi.Vector3f  #: unit direction of the last segment
    instance: mi.UInt32  #: id of the opaque object; 0 where there is none
    bounces: mi.UInt32  #: interfaces met
    transmittance: mi.Color3f  #: product of 1 - R at each interface (1 at total reflection) and of exp(-sigma_a t)
    length: mi.Float  #: geometric length of the whole path [m]; only for `HIT`


def refract(
    loaded: LoadedScene,
    ray: mi.Ray3f,
    eta: mi.Float | None = None,
    sigma_a: mi.Float | None = None,
    max_interfaces: int = MAX_INTERFACES,
    derivatives: bool = False,
) -> Refracted:
    """Follow rays through glass and liquid to the first opaque surface.

    With `derivatives`, directions, points and normals stay attached: the result has gradients by the rays (hence the
    camera), by `eta` and `sigma_a`, and by vertex positions and normals set through ``mi.traverse(loaded.mi_scene)``.
    They are valid as long as a ray meets the same surfaces: silhouettes and the onset of total internal reflection have
    no derivatives.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    ray : mi.Ray3f
        Rays that start in air.
    eta, sigma_a : mi.Float, optional
        Index, and absorption in three channels [1/m], of each of ``loaded.surfaces.media``; by default the scene's own
        (``surfaces.eta_d`` and ``surfaces.sigma_a_rgb``).
    max_interfaces : int
        Rays that meet more are `LOST`.
    derivatives : bool
        Run the loop in evaluated mode, so that forward and reverse mode AD work through it; it stores each iteration.

    Raises
    ------
    InputError
        If `derivatives` is set in a variant without AD.
    """
    if derivatives and not dr.is_diff_v(mi.Float):
        raise InputError("derivatives", "a variant with AD, such as llvm_ad_rgb", mi.variant())
    eta = loaded.surfaces.eta_d if eta is None else eta
    sigma_a = loaded.surfaces.sigma_a_rgb if sigma_a is None else sigma_a
    return _refracted(loaded, ray, eta, sigma_a, max_interfaces, "evaluated" if derivatives else "symbolic")


@syntax
def _refracted(
    loaded: LoadedScene,
    ray: mi.Ray3f,
    eta: mi.Float,
    sigma_a: mi.Float,
    max_interfaces: int,
    mode: str,
    watertight: bool = False,
) -> Refracted:
    """Follow rays as `refract` does, in a symbolic or an evaluated loop; `watertight` ones do not slip through cracks.

    Those meet the shapes where they were loaded, so only `trace_refraction` asks for them.
    """
    scene, table, offset = loaded.mi_scene, loaded.surfaces, mi.Float(loaded.offset)
    robust = loaded.robust_scene if watertight else None
    limit = mi.UInt32(max_interfaces)
    dr.make_opaque(offset, limit)

    # ---- Loop state ----
    ray = mi.Ray3f(ray)
    point, direction, length = mi.Point3f(0.0), mi.Vector3f(ray.d), mi.Float(0.0)
    state, instance, bounces = mi.UInt32(LOST), mi.UInt32(0), mi.UInt32(0)
    transmittance = mi.Color3f(1.0)
    active = mi.Bool(True)

    while dr.hint(active, mode=mode, exclude=[table, scene, robust, eta, sigma_a, limit]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, bounces == 0, active)
        si = without_crack(si, robust, ray, offset, active)
        si.p = where_met(si, ray)
        row = registry_id(si.shape)
        # An area light is part of the surroundings, as the sky behind it.
        hit = active & si.is_valid() & (dr.gather(mi.UInt32, table.label, row, active) > 0)
        surface = seen_from_air(surface_media(table, si, ray, hit), bounces == 0)
        length += surface.distance
        transmittance *= transmittance_rgb(sigma_a, surface, hit)

        ends = active & (~hit | surface.opaque)
        state = dr.select(ends, dr.select(hit, mi.UInt32(HIT), mi.UInt32(SURROUNDINGS)), state)
        point = dr.select(ends & hit, si.p, point)
        instance = dr.select(ends & hit, dr.gather(mi.UInt32, table.label, row, hit), instance)

        active &= ~ends & (bounces < limit)
        ratio = relative_index_d(eta, surface, active)
        refracted, fresnel = transmission(-ray.d, surface.n, surface.ns, ratio)
        direction = dr.select(active, refracted, direction)
        transmittance *= dr.select(active, fresnel, 1.0)
        ray = leave(si, direction, offset)
        bounces += dr.select(active, mi.UInt32(1), mi.UInt32(0))

    return Refracted(state, point, direction, instance, bounces, transmittance, length)


def trace_refraction(loaded: LoadedScene, cameras: Sequence[Camera], eye: Eye = "left") -> list[Refraction]:
    """Return where the refracted rays through the pixel centres end, for any number of views in one trace.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    cameras : sequence of Camera
        The stereo pairs. A trace holds about 100 bytes a pixel.
    eye : {"left", "right"}
        Which of the two.

    Returns
    -------
    list of Refraction
        One for each camera.
    """
    eyes = [pinhole(camera, eye) for camera in cameras]
    sizes = [camera.width * camera.height for camera in cameras]
    rays = [
        pixel_rays(view, dr.arange(mi.UInt32, size), mi.Point2f(0.0))[0] for view, size in zip(eyes, sizes, strict=True)
    ]
    ray, table = rays[0] if len(rays) == 1 else _joined(rays), loaded.surfaces
    end = _refracted(loaded, ray, table.eta_d, table.sigma_a_rgb, MAX_INTERFACES, "symbolic", watertight=True)
    dr.eval(end)
    offsets = np.cumsum([0, *sizes])
    return [_picture(end, eyes[i], cameras[i], int(offsets[i])) for i in range(len(cameras))]


def _joined(rays: list[mi.Ray3f]) -> mi.Ray3f:
    def column(values: list) -> mi.Float:
        return dr.concat(values)

    sizes = [dr.width(ray.d) for ray in rays]
    origins = [
        [ray.o[axis] + dr.zeros(mi.Float, size) for ray, size in zip(rays, sizes, strict=True)] for axis in range(3)
    ]
    directions = [[ray.d[axis] for ray in rays] for axis in range(3)]
    return mi.Ray3f(mi.Point3f(*map(column, origins)), mi.Vector3f(*map(column, directions)))


def _picture(end: Refracted, view: Pinhole, camera: Camera, start: int) -> Refraction:
    """Return the part of a trace that belongs to one camera, projected into its picture."""
    size, shape = camera.width * camera.height, (camera.height, camera.width)
    lane = dr.arange(mi.UInt32, size)
    part = dr.gather(Refracted, end, lane + dr.opaque(mi.UInt32, start))
    escaped = part.state == SURROUNDINGS
    end_point = dr.select(
        escaped, mi.Point3f(part.direction), dr.select(part.state == HIT, part.point, mi.Point3f(0.0))
    )
    local, flow = flow_of(view, part, lane)
    # A ray without interfaces is straight: its flow is 0, and projecting the point would only add rounding errors.
    flow = dr.select(part.bounces == 0, mi.Vector2f(0.0), flow)
    Z = dr.select(part.state == HIT, local.z, dr.inf)
    dr.eval(end_point, flow, Z)
    return Refraction(
        state=np.array(part.state).astype(np.uint8).reshape(shape),
        hit=_stacked(end_point, shape),
        Z=np.array(Z).reshape(shape),
        id=np.array(part.instance).astype(np.uint16).reshape(shape),
        flow=_stacked(flow, shape),
        bounces=np.array(part.bounces).astype(np.uint16).reshape(shape),
        transmittance=_stacked(part.transmittance, shape).astype(np.float16),
    )


def flow_of(view: Pinhole, end: Refracted, pixel: mi.UInt32) -> tuple[mi.Vector3f, mi.Vector2f]:
    """Return the end points of refracted rays in the camera frame, and the refractive flow.

    Parameters
    ----------
    view : Pinhole
        The eye that the rays start from.
    end : Refracted
        Their ends: points, or directions of rays that left the scene.
    pixel : mi.UInt32
        The pixels of the rays, which pass their centres; row-major index.

    Returns
    -------
    local : mi.Vector3f
        Camera-frame point [m]; for rays that left the scene their direction.
    flow : mi.Vector2f
        Projection of the end point as if there were no glass, minus the pixel's centre [px]; NaN where the point is
        behind the camera or the ray is lost.
    """
    towards = dr.select(end.state == SURROUNDINGS, end.direction, mi.Vector3f(end.point - view.origin))
    local = view.world_R_camera.T @ mi.Vector3f(towards)
    projects = (local.z > 0.0) & (end.state != LOST)
    depth = dr.select(projects, local.z, 1.0)
    x, y = local.x * dr.rcp(depth * view.inverse_focal.x), local.y * dr.rcp(depth * view.inverse_focal.y)
    row = pixel // view.width
    centre = mi.Vector2f(mi.Float(pixel - row * view.width), mi.Float(row))
    flow = mi.Vector2f(x, y) + mi.Vector2f(view.centre) - centre
    return local, dr.select(projects, flow, dr.nan)


def _stacked(values: mi.Vector3f | mi.Vector2f, shape: tuple[int, int]) -> np.ndarray:
    return np.array(values).T.reshape(*shape, -1).copy()
