"""The projector as a point of light that straight shadow rays reach through glass and liquid.

A renderer's own spotlight lights nothing behind smooth glass: a point and a mirror-like refraction can be connected
along one path alone, which no sampling finds. Here the shadow ray goes on in a straight line, and loses at each surface
what Fresnel's equations say and in each medium what it absorbs (`labels.geometry.straight_transmittance`). So the light
behind glass has the right strength, at the place where it would be without the glass; how glass bends it is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi, syntax
from ..labels.geometry import straight_transmittance
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.surfaces import surface_media
from .pattern import PatternMap

#: Largest number of surfaces that a shadow ray passes [1]; a filled vessel has six, and scenes a dozen vessels.
_MAX_SURFACES = 96
#: Shadow rays end so far before their target [m]: float32 points of some metres.
_SHORT = 1e-4


@dataclass(frozen=True, eq=False)
class ProjectedLight:
    """The projector: its place, its axes, and its pattern."""

    origin: mi.Point3f
    projector_R_world: mi.Matrix3f
    density: mi.Float  #: `PatternMap.density`, row by row
    columns: mi.UInt32
    rows: mi.UInt32
    step: mi.Float
    corner: mi.Point2f

    def intensity(self, direction: mi.Vector3f) -> mi.Float:
        """Return the radiant intensity in unit directions of the world [W/sr]; 0 outside the pattern.

        A solid angle is the area in the plane at distance 1 times cos^3.
        """
        d = self.projector_R_world @ direction
        forward = d.z > 1e-3
        inverse = dr.rcp(dr.select(forward, d.z, 1.0))
        x = (d.x * inverse - self.corner.x) / self.step - 0.5
        y = (d.y * inverse - self.corner.y) / self.step - 0.5
        columns, rows = mi.Float(self.columns), mi.Float(self.rows)
        inside = forward & (x >= 0.0) & (y >= 0.0) & (x < columns - 1.0) & (y < rows - 1.0)
        x, y = dr.select(inside, x, 0.0), dr.select(inside, y, 0.0)
        column, row = mi.UInt32(x), mi.UInt32(y)
        index, fx, fy = row * self.columns + column, x - mi.Float(column), y - mi.Float(row)
        value = [dr.gather(mi.Float, self.density, index + place, inside) for place in (0, 1)]
        below = [dr.gather(mi.Float, self.density, index + self.columns + place, inside) for place in (0, 1)]
        density = dr.lerp(dr.lerp(value[0], value[1], fx), dr.lerp(below[0], below[1], fx), fy)
        return dr.select(inside, density * inverse * inverse * inverse, 0.0)


def projected_light(pattern: PatternMap, world_T_projector: np.ndarray) -> ProjectedLight:
    """Return a projector in its place."""
    rows, columns = pattern.density.shape
    light = ProjectedLight(
        origin=mi.Point3f(world_T_projector[:3, 3].astype(np.float32)),
        projector_R_world=mi.Matrix3f(world_T_projector[:3, :3].T.astype(np.float32)),
        density=mi.Float(pattern.density.ravel()),
        columns=mi.UInt32(columns),
        rows=mi.UInt32(rows),
        step=mi.Float(pattern.step),
        corner=mi.Point2f(*pattern.corner),
    )
    dr.make_opaque(light.origin, light.projector_R_world, light.columns, light.rows, light.step, light.corner)
    dr.make_opaque(light.density)
    return light


@syntax
def passed(loaded: LoadedScene, ray: mi.Ray3f, distance: mi.Float, active: mi.Bool) -> mi.Float:
    """Return the fraction of light that passes along straight rays up to a distance: 0 behind opaque surfaces.

    Parameters
    ----------
    loaded : LoadedScene
        The scene; the columns `eta_d` and `sigma_a_rgb` of its surface table count, of the latter the first channel.
    ray : mi.Ray3f
        Where it starts, and where to.
    distance : mi.Float
        Length of the way [m]. Surfaces within `_SHORT` of its end are left out.
    active : mi.Bool
        Which rays are followed; the others give 0.
    """
    scene, table, offset = loaded.mi_scene, loaded.surfaces, dr.opaque(mi.Float, loaded.offset)
    ray, left = mi.Ray3f(ray), mi.Float(distance - _SHORT)
    ray.maxt = left
    fraction, surfaces = dr.select(active, mi.Float(1.0), mi.Float(0.0)), mi.UInt32(0)
    normal, active = mi.Normal3f(-ray.d), mi.Bool(active)
    while dr.hint(active, exclude=[loaded, table, scene]):
        si = scene.ray_intersect(ray, mi.RayFlags.ShadingFrame, False, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        through = straight_transmittance(table, surface, ray, normal, hit).x
        fraction = dr.select(hit, dr.select(surface.opaque, 0.0, fraction * through), fraction)
        normal, left = mi.Normal3f(surface.ns), left - si.t
        surfaces += 1
        active = hit & ~surface.opaque & (left > 0.0) & (surfaces < _MAX_SURFACES)
        ray = leave(si, ray.d, offset)
        ray.maxt = left
    return fraction


def arriving(
    loaded: LoadedScene, light: ProjectedLight, si: mi.SurfaceInteraction3f, offset: mi.Float, active: mi.Bool
) -> tuple[mi.Vector3f, mi.Float]:
    """Return the direction to the projector from points on surfaces, and its irradiance on planes that face it [W/m^2].

    The pattern is read where no ray is traced: most points lie between the dots.
    """
    to_light = light.origin - si.p
    distance = dr.norm(to_light)
    direction = to_light / distance
    irradiance = light.intensity(-direction) / dr.square(distance)
    shadow = leave(si, direction, offset)
    return direction, irradiance * passed(loaded, shadow, distance, active & (irradiance > 0.0))


def sees(loaded: LoadedScene, origin: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return whether a place sees points, (n,) bool, glass in between or not; world frame [m]."""
    if len(points) == 0:
        return np.zeros(0, bool)
    start = dr.opaque(mi.Float, 0.0) + mi.Point3f(np.asarray(origin, np.float32))
    way = mi.Vector3f(np.ascontiguousarray((points - origin).T, np.float32))
    distance = dr.norm(way)
    # Points on surfaces: what they lie on must not hide them, also where the view grazes it.
    fraction = passed(loaded, mi.Ray3f(start, way / distance), distance * (1.0 - 1e-3), mi.Bool(True))
    return np.array(fraction) > 0.0
