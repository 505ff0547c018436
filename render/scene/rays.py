"""Camera rays (pinhole) and rays that leave surfaces (self-intersection offset)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import InputError
from ...procedural.description.camera import Camera
from .._mitsuba import dr, mi
from ..frame import Eye

#: How much nearer than the fast test's hit the robust one's has to be, in ray offsets [1]: some 50 um. Both compute the
#: distance of the same hit to a micrometre, and walls are a millimetre thick.
SLIPPED = 100.0

#: Cosine below which a ray, within 0.06 degrees of a triangle's plane, has no exact place in it [1]: float32 positions
#: at 1 m are good to 1e-7 m, which is 0.1 mm along the plane there.
GRAZING = 1e-3


@dataclass(frozen=True, eq=False)
class Pinhole:
    """One eye of a stereo camera as opaque Dr.Jit values, so that all cameras share one compiled kernel."""

    width: mi.UInt32
    inverse_focal: mi.Vector2f
    centre: mi.Point2f
    world_R_camera: mi.Matrix3f
    origin: mi.Point3f


def pinhole(camera: Camera, eye: Eye = "left") -> Pinhole:
    """Return the left or the right eye of a stereo camera.

    Raises
    ------
    InputError
        If `eye` is neither "left" nor "right".
    """
    if eye not in ("left", "right"):
        raise InputError("eye", "'left' or 'right'", repr(eye))
    world_T_eye = camera.world_T_camera if eye == "left" else camera.world_T_right
    view = Pinhole(
        width=mi.UInt32(camera.width),
        inverse_focal=mi.Vector2f(1.0 / camera.fx, 1.0 / camera.fy),
        centre=mi.Point2f(*map(float, camera.centre)),
        world_R_camera=mi.Matrix3f(world_T_eye[:3, :3].astype(np.float32)),
        origin=mi.Point3f(world_T_eye[:3, 3].astype(np.float32)),
    )
    for value in (view.width, view.inverse_focal, view.centre, view.world_R_camera, view.origin):
        dr.make_opaque(value)
    return view


def pixel_rays(view: Pinhole, pixel: mi.UInt32, jitter: mi.Point2f) -> tuple[mi.Ray3f, mi.Float]:
    """Return the camera rays through pixels.

    Parameters
    ----------
    view : Pinhole
        The eye.
    pixel : mi.UInt32
        Row-major index, ``row * width + column``.
    jitter : mi.Point2f
        Offset from the pixel's centre [px]; 0 for labels, in [-1/2, 1/2) for pictures.

    Returns
    -------
    ray : mi.Ray3f
        Unit directions in the world frame.
    depth_per_distance : mi.Float
        Cosine between the ray and the optical axis: ``Z = distance * depth_per_distance``.
    """
    row = pixel // view.width
    u = mi.Float(pixel - row * view.width) + jitter.x
    v = mi.Float(row) + jitter.y
    x, y = (u - view.centre.x) * view.inverse_focal.x, (v - view.centre.y) * view.inverse_focal.y
    local = mi.Vector3f(x, y, 1.0)
    local = dr.normalize(local)
    return mi.Ray3f(mi.Point3f(view.origin), view.world_R_camera @ local), local.z


def without_crack(
    si: mi.SurfaceInteraction3f, robust: mi.Scene | None, ray: mi.Ray3f, offset: mi.Float, active: mi.Bool
) -> mi.SurfaceInteraction3f:
    """Return what a ray hits, `si`, or what the robust test hits in front of it where the ray slipped through a crack.

    Embree's default test rounds the common edge of two triangles differently in each: a ray that passes it within some
    0.3 um may miss both. Of rays aimed at edges of a beaker 5 % do. The robust test evaluates an edge in the same way
    for both its triangles (after Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection"): 5 in 100,000 do.
    But its points are less exact (up to 0.5 mm off along large triangles), so it only helps out.
    Pictures do without: a mean over samples does not show one ray in a million. Without a robust scene nothing changes.
    """
    if robust is None:
        return si
    closed = robust.ray_intersect(ray, mi.RayFlags.All, False, active)
    slipped = active & closed.is_valid() & (closed.t < si.t - SLIPPED * offset)
    return dr.select(slipped, closed, si)


def where_met(si: mi.SurfaceInteraction3f, ray: mi.Ray3f) -> mi.Point3f:
    """Return where a ray meets the plane of the triangle that it hits [m].

    Barycentric coordinates of sliver triangles are ill-conditioned. The point that they give is in the plane, but off
    along it: up to 0.1 mm on triangles of 1.4 m x 3 mm, and some mm by the robust test at narrow faces that rays graze.
    From that point on, the ray finds the plane within the rounding of positions over the cosine.
    """
    along, cosine = dr.dot(si.p - ray.o, ray.d), dr.dot(si.n, ray.d)
    exact = dr.abs(cosine) > GRAZING
    beyond = dr.dot(si.p - ray(along), si.n) / dr.select(exact, cosine, 1.0)
    return dr.select(exact, ray(along + beyond), si.p)


def straight_on(si: mi.SurfaceInteraction3f, ray: mi.Ray3f, offset: mi.Float) -> mi.Ray3f:
    """Return the ray that goes straight on behind a surface, started `offset` [m] off the point where it was met.

    On sliver triangles that point (`where_met`) and the distance that the intersection gave may be 0.1 mm apart. The
    ray starts twice as far off the plane as that may be, or it would meet the triangle again.
    """
    off = dr.maximum(offset, 2.0 * dr.abs(dr.dot(si.p - ray(si.t), si.n)))
    return leave(si, ray.d, off)


def leave(si: mi.SurfaceInteraction3f, direction: mi.Vector3f, offset: float | mi.Float) -> mi.Ray3f:
    """Return a ray from the surface along `direction`, started `offset` [m] off it on the side of `direction`."""
    side = dr.select(dr.dot(si.n, direction) > 0.0, mi.Float(offset), -mi.Float(offset))
    return mi.Ray3f(si.p + side * si.n, direction, si.time, si.wavelengths)
