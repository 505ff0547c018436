"""State of the paths of `trace_cached`: a wavefront traced in passes; the paths that are left are compacted."""

from __future__ import annotations

from dataclasses import dataclass, fields

from .._mitsuba import dr, mi
from ..pictures.sampler import SobolSampler, sample_1d
from ..scene.surfaces import AIR_INDEX
from .footprint import Footprint, NormalDerivatives, camera_footprint


@dataclass(frozen=True, eq=False)
class PathState:
    """A wavefront of paths: the state of the loop."""

    origin: mi.Point3f
    direction: mi.Vector3f
    beta: mi.Color3f  #: throughput
    L: mi.Color3f  #: radiance so far
    eta_scale: mi.Float  #: product of eta^2, which Russian roulette must not count as loss
    pdf: mi.Float  #: density of the last direction by solid angle
    delta: mi.Bool  #: whether emitter sampling could not have sampled the last direction
    glossy: mi.Color3f  #: fraction of an emitter's light behind glass that the last opaque surface has not stored
    through_glass: mi.Bool  #: whether the path has met glass since that surface; both only where surfaces are traced
    footprint: Footprint | None  #: None where nothing reads it
    medium: mi.UInt32  #: medium of the segment by the last event
    u_rescaled: mi.Float  #: the path's number, rescaled to [0, 1) within the interval of the lobes sampled so far
    u_interval: mi.Float  #: length of that interval
    depth: mi.UInt32
    violations: mi.UInt32
    active: mi.Bool
    pixel: mi.UInt32  #: pixel of the path
    index: mi.UInt32  #: sample of the pixel
    lane: mi.UInt32  #: lane of the result


def camera_state(ray: mi.Ray3f, sampler: SobolSampler, derivatives: NormalDerivatives | None) -> PathState:
    """Return the paths of camera rays, before their first surface; footprints are followed with `derivatives`."""
    lanes = dr.width(sampler.index)
    return PathState(
        origin=ray.o,
        direction=ray.d,
        beta=mi.Color3f(1.0),
        L=mi.Color3f(0.0),
        eta_scale=mi.Float(1.0),
        pdf=mi.Float(1.0),
        delta=mi.Bool(True),
        glossy=mi.Color3f(1.0),
        through_glass=mi.Bool(False),
        footprint=None if derivatives is None else camera_footprint(derivatives, ray.d),
        medium=mi.UInt32(AIR_INDEX),
        u_rescaled=sample_1d(sampler, mi.UInt32(0), mi.UInt32(3)),  # of the camera's set, beside the pixel position
        u_interval=mi.Float(1.0),
        depth=mi.UInt32(0),
        violations=mi.UInt32(0),
        active=mi.Bool(True),
        pixel=sampler.pixel,
        index=sampler.index,
        lane=dr.arange(mi.UInt32, lanes),
    )


def compacted(state: PathState, lanes: mi.UInt32) -> PathState:
    """Return the paths in the given lanes."""
    return PathState(*(None if value is None else dr.gather(type(value), value, lanes) for value in values_of(state)))


def values_of(state: PathState) -> tuple:
    """Return the fields of a state, in their order."""
    return tuple(getattr(state, field.name) for field in fields(state))
