"""Beams of a time-of-flight camera: followed through glass and liquid with exact interfaces to what returns them.

A beam is refracted at each interface, as label rays are (`labels.refraction`). Light comes back on the way that it went
out: from opaque surfaces by their BSDF towards the beam, from interfaces and mirrors that face it. A return is measured
by the optical length of the way: each medium slows light down by its group index. So what is behind a slab of the
thickness t is reported t (n - 1) / cos too far, besides being displaced.

A second ray for each pixel is mirrored by the first interface that it meets: at grazing angles most light goes there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.camera import Camera
from ...procedural.description.time_of_flight import TimeOfFlightCamera
from ...procedural.optics.medium import Medium
from .._mitsuba import dr, mi, syntax
from ..frame import Beams
from ..interfaces.dielectric import consistent_normal, transmission
from ..labels.geometry import trace_geometry
from ..labels.refraction import MAX_INTERFACES
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave, pinhole, pixel_rays, without_crack
from ..scene.surfaces import (
    SurfaceMedia,
    SurfaceTable,
    registry_id,
    relative_index_d,
    seen_from_air,
    surface_media,
    transmittance_rgb,
)
from .media import at_wavelength, infrared_index
from .reflectances import infrared_reflectances
from .trace_pattern import interface_lobe, opaque_lobe

#: Nodes and weights of the Gauss-Hermite rule of three points: places in a Gaussian beam, in standard deviations [1].
_NODES, _WEIGHTS = (-(3.0**0.5), 0.0, 3.0**0.5), (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)
#: Standard deviations of a Gaussian beam in the full angle at 1/e^2 [1].
_SIGMAS = 4.0
#: Cosine of the half width up to which the lobe of an opaque surface mirrors the beam as a whole [1]: 1.1 degrees.
_SHARP = 0.9998
#: Angle in air between a beam and the normal of a smooth interface at which 1/e of what it mirrors meets the receiver
#: [rad]: assumed, some 6 mm beside the laser for a face that is half a metre away.
_ACCEPTANCE = 0.006
#: Wavelengths on both sides from which the slope of the index is taken [nm].
_STEP = 5.0


@dataclass(frozen=True, eq=False)
class Receiver:
    """What counts as a return."""

    first: mi.Bool  #: the first one, instead of the strongest
    least: mi.Float  #: [1/m^2]
    group: mi.Float  #: group index by medium


def trace_beams(loaded: LoadedScene, view: int, device: TimeOfFlightCamera) -> Beams:
    """Return what comes back along the beams of a time-of-flight camera.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    view : int
        Number of the camera that the device stands beside.
    device : TimeOfFlightCamera
        The device.
    """
    camera = device.scanner(loaded.description.cameras[view])
    infrared = at_wavelength(loaded, device.wavelength)
    group = mi.Float(np.array([group_index(one, device.wavelength) for one in infrared.surfaces.media], np.float32))
    receiver = Receiver(mi.Bool(device.returns == "first"), mi.Float(device.least), group)
    dr.make_opaque(receiver.first, receiver.least, receiver.group)
    sigma = device.beam / _SIGMAS * device.focal
    places = [
        (sigma * x, sigma * y, u * v)
        for x, u in zip(_NODES, _WEIGHTS, strict=True)
        for y, v in zip(_NODES, _WEIGHTS, strict=True)
    ]
    rays = [(x, y, False) for x, y, _ in places] + [(0.0, 0.0, True)]
    with infrared_reflectances(loaded):
        found = [_returned(infrared, camera, receiver, *one) for one in rays]
    return Beams(
        camera=camera,
        weight=np.array([*(weight for *_, weight in places), 1.0], np.float32),
        strength=np.stack([strength for strength, _ in found]),
        path=np.stack([path for _, path in found]),
        Z=trace_geometry(infrared, camera).Z,
    )


def group_index(medium: Medium, nm: float) -> float:
    """Return the group index n - lambda dn/dlambda of a medium: the speed of light over that of a pulse in it [1]."""
    below, at, above = (infrared_index(medium, nm + step) for step in (-_STEP, 0.0, _STEP))
    return at - nm * (above - below) / (2.0 * _STEP)


def _returned(
    loaded: LoadedScene, camera: Camera, receiver: Receiver, x: float, y: float, mirrored: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return strength and optical length of each pixel's ray, (h, w) float32 each; `x` and `y` off its centre [px]."""
    jitter = mi.Point2f(dr.opaque(mi.Float, x), dr.opaque(mi.Float, y))
    lanes = dr.arange(mi.UInt32, camera.width * camera.height)
    ray, _ = pixel_rays(pinhole(camera, "left"), lanes, jitter)
    strength, path = _followed(loaded, receiver, ray, dr.opaque(mi.Bool, mirrored))
    dr.eval(strength, path)
    shape = (camera.height, camera.width)
    return np.array(strength).reshape(shape), np.array(path).reshape(shape)


@syntax
def _followed(loaded: LoadedScene, receiver: Receiver, ray: mi.Ray3f, mirrored: mi.Bool) -> tuple[mi.Float, mi.Float]:
    """Return strength [1/m^2] and optical length [m] of the return of each ray; 0 and +inf where there is none.

    The strength of a matte surface of the reflectance rho at the distance z is rho cos / z^2.
    """
    scene, table, robust = loaded.mi_scene, loaded.surfaces, loaded.robust_scene
    offset, limit = dr.opaque(mi.Float, loaded.offset), dr.opaque(mi.UInt32, MAX_INTERFACES)
    ray, bounces, active = mi.Ray3f(ray), mi.UInt32(0), mi.Bool(True)
    path, length, fraction = mi.Float(0.0), mi.Float(0.0), mi.Float(1.0)
    best, best_path, mirror = mi.Float(0.0), mi.Float(dr.inf), mi.Bool(mirrored)

    while dr.hint(active, exclude=[loaded, table, scene, robust, receiver]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, bounces == 0, active)
        si = without_crack(si, robust, ray, offset, active)
        hit = active & si.is_valid() & (dr.gather(mi.UInt32, table.label, registry_id(si.shape), active) > 0)
        surface = seen_from_air(surface_media(table, si, ray, hit), bounces == 0)
        path += surface.distance * dr.gather(mi.Float, receiver.group, surface.before, hit)
        length += surface.distance
        fraction *= transmittance_rgb(table.sigma_a_rgb, surface, hit).x
        back, direction, factor = mi.Float(0.0), mi.Vector3f(0.0, 0.0, 1.0), mi.Float(0.0)
        if dr.hint(hit & surface.opaque, exclude=[loaded, table, scene, receiver]):
            back, sampled, weight = opaque_lobe(loaded, si, ray, -ray.d, mi.Float(0.5), mi.Point2f(0.5))
            direction = mi.reflect(-ray.d, surface.ns)
            polished = dr.gather(mi.Bool, table.polished, surface.row)
            factor = dr.select(polished & (dr.dot(sampled, direction) > _SHARP), weight, 0.0)
        if dr.hint(hit & ~surface.opaque, exclude=[loaded, table, scene, receiver]):
            back = _mirrored_back(table, surface, -ray.d)
            ratio = relative_index_d(table.eta_d, surface)
            direction, factor = transmission(-ray.d, surface.n, surface.ns, ratio)
            facet = consistent_normal(-ray.d, surface.n, surface.ns, ratio)
            direction = dr.select(mirror, mi.reflect(-ray.d, facet), direction)
            factor = dr.select(mirror, 1.0 - factor, factor)
        # Out and back: what the way takes counts twice.
        strength = dr.select(hit, dr.pi * back * dr.square(fraction) / dr.square(length), 0.0)
        better = (strength >= receiver.least) & (best < receiver.least)
        better |= (strength > best) & (~receiver.first | (best < receiver.least))
        better &= ~mirror  # what comes back from there or before belongs to the other rays
        best, best_path = dr.select(better, strength, best), dr.select(better, path, best_path)
        fraction *= factor
        mirror &= ~hit | surface.opaque
        ray = leave(si, direction, offset)
        bounces += 1
        active = hit & (fraction > 0.0) & (bounces < limit)

    return best, best_path


def _mirrored_back(table: SurfaceTable, surface: SurfaceMedia, wi: mi.Vector3f) -> mi.Float:
    """Return what an interface mirrors to where the beam came from: a lobe times the cosine [1/sr], per angle in air.

    A smooth one mirrors into the receiver where the beam meets it at a right angle: a Gaussian lobe of the angle that
    the beam has, by Snell's law, in the air before the glass, whose integral is the Fresnel reflectance. A rough one
    has its GGX lobe; a solid angle in the medium is one n^2 times as wide in air.
    """
    index = dr.gather(mi.Float, table.eta_d, surface.before)
    cos = dr.dot(wi, surface.ns)
    reflectance, *_ = mi.fresnel(cos, relative_index_d(table.eta_d, surface))
    sine2, width2 = dr.square(index) * (1.0 - dr.square(cos)), dr.square(_ACCEPTANCE)
    smooth = reflectance * dr.exp(-sine2 / width2) / (4.0 * dr.pi * width2)
    rough = interface_lobe(table, surface, wi, wi) / dr.square(index)
    alpha = dr.gather(mi.Float, table.alpha, surface.row)
    return dr.select(cos > 0.0, dr.select(alpha > 0.0, rough, smooth), 0.0)
