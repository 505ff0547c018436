"""Emitter sampling and its density: Mitsuba's emitters, or a room in its place (`room_emitter`) in place of its map."""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi
from .rays import leave
from .room_emitter import RoomEmitter, from_shell, is_of_room, room_radiance, to_shell

#: Shadow rays end before the emitter by this fraction of the distance, to not hit it.
_SHADOW_EPSILON = 1e-4


@dataclass(frozen=True, eq=False)
class Emitters:
    """The emitters of a loaded scene."""

    scene: mi.Scene
    room: RoomEmitter | None = None  #: the room, where it is in its place; paths end at its surfaces
    occluders: mi.Scene | None = None  #: the opaque shapes alone, where glass casts no shadows


def sample_emitter(
    emitters: Emitters, si: mi.SurfaceInteraction3f, u: mi.Point2f
) -> tuple[mi.DirectionSample3f, mi.Spectrum]:
    """Sample a direction to an emitter from a point.

    Returns
    -------
    ds : mi.DirectionSample3f
        The direction with its density.
    arriving : mi.Spectrum
        The radiance over the density, without shadows (`unoccluded`); from a room that of its map, an estimate.
    """
    ds, arriving = emitters.scene.sample_emitter_direction(si, u, False)
    if emitters.room is None:
        return ds, arriving
    beyond = _is_beyond(emitters, ds)
    direction, factor = from_shell(emitters.room, si.p, ds.d)
    ds.d = dr.select(beyond, direction, ds.d)
    ds.pdf = dr.select(beyond, ds.pdf * factor, ds.pdf)
    ds.dist = dr.select(beyond, dr.largest(mi.Float), ds.dist)
    return ds, dr.select(beyond, _over(arriving, dr.maximum(factor, 1e-6)), arriving)


def unoccluded(
    emitters: Emitters,
    si: mi.SurfaceInteraction3f,
    sample: tuple[mi.DirectionSample3f, mi.Spectrum],
    offset: mi.Float,
    active: mi.Bool,
) -> mi.Spectrum:
    """Return what arrives along a sampled direction, over its density: 0 in shadow and where not `active`."""
    (ds, arriving), scene, room = sample, emitters.occluders or emitters.scene, emitters.room
    shadow = leave(si, ds.d, offset)
    shadow.maxt = ds.dist * (1.0 - _SHADOW_EPSILON)
    if room is None:
        return dr.select(active & ~scene.ray_test(shadow, False, active), arriving, 0.0)
    beyond = _is_beyond(emitters, ds)
    pi = scene.ray_intersect_preliminary(shadow, False, active)
    # (The texture coordinates are all that is read.)
    met = pi.compute_surface_interaction(shadow, mi.RayFlags.UV, active & beyond)
    radiance = room_radiance(room, pi, met, ds.d, active & beyond)
    seen = dr.select(beyond, _over(radiance, ds.pdf), dr.select(pi.is_valid(), mi.Spectrum(0.0), arriving))
    return dr.select(active & (ds.pdf > 0.0), seen, 0.0)


def _over(light: mi.Spectrum, density: mi.Float) -> mi.Spectrum:
    """Return light over a density; Mueller matrices have no division by a number."""
    return light * mi.Spectrum(dr.rcp(density)) if mi.is_polarized else light / density


def emitted(
    emitters: Emitters,
    pi: mi.PreliminaryIntersection3f,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    active: mi.Bool,
) -> mi.Spectrum:
    """Return the radiance of the emitter that a ray met: a lamp, the environment, or the room."""
    emitter = si.emitter(emitters.scene, active)
    if emitters.room is None:
        return emitter.eval(si, active)
    lamp = emitter.eval(si, active & si.is_valid())
    return dr.select(active & si.is_valid(), lamp, 0.0) + room_radiance(emitters.room, pi, si, ray.d, active)


def emitter_pdf(
    emitters: Emitters,
    previous: mi.Interaction3f,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    active: mi.Bool,
) -> mi.Float:
    """Return the density with which `sample_emitter` gives the direction of a ray from a point to what it met."""
    scene, room = emitters.scene, emitters.room
    ds = mi.DirectionSample3f(scene, si, previous)
    if room is None:
        return scene.pdf_emitter_direction(previous, ds, active)
    beyond = ~si.is_valid() | is_of_room(room, si, active)
    direction, factor = to_shell(room, previous.p, ray.d)
    ds.d = dr.select(beyond, direction, ds.d)
    ds.emitter = dr.select(beyond, room.environment, ds.emitter)
    return scene.pdf_emitter_direction(previous, ds, active) * dr.select(beyond, factor, 1.0)


def _is_beyond(emitters: Emitters, ds: mi.DirectionSample3f) -> mi.Bool:
    assert emitters.room is not None
    return dr.reinterpret_array(mi.UInt32, ds.emitter) == dr.reinterpret_array(mi.UInt32, emitters.room.environment)


def ends_paths(emitters: Emitters, si: mi.SurfaceInteraction3f, active: mi.Bool) -> mi.Bool:
    """Return where rays met a surface of the room: what it sends out is stored, and paths end there."""
    return mi.Bool(False) if emitters.room is None else is_of_room(emitters.room, si, active)
