"""Ray differentials: how far the paths of one pixel spread, on surfaces and in direction.

A curved wall spreads the rays of a pixel: after a few interfaces they leave in directions many degrees apart. The
derivatives of a path's position and direction by its place in the pixel tell by how much (Igehy, "Tracing Ray
Differentials", SIGGRAPH 1999). They need the derivative of the shading normal along the surface, which is constant in a
triangle. Rough interfaces count as smooth ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi
from ..interfaces.dielectric import Scattered
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import SurfaceMedia, registry_id

#: Smallest cosine of a ray to a surface in a divisor [1]: at grazing angles the derivatives grow without bound.
_MIN_COS = 0.05


@dataclass(frozen=True, eq=False)
class NormalDerivatives:
    """Derivatives of the shading normals along glass surfaces, constant in each triangle, and the angle of a pixel."""

    values: mi.Float  #: by triangle: a 3 x 3 matrix in world coordinates, row by row [1/m], and three zeros
    first: mi.UInt32  #: by registry id: number of the shape's first triangle
    pixel_angle: mi.Float  #: of the finest view [rad]


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class Footprint:
    """Derivatives of a path by two perpendicular offsets of its place in the pixel [1/px]."""

    p_u: mi.Vector3f  #: of the position [m]
    p_v: mi.Vector3f
    d_u: mi.Vector3f  #: of the direction [1]
    d_v: mi.Vector3f


def normal_derivatives(loaded: LoadedScene) -> NormalDerivatives:
    """Return the derivatives of the shading normals of a scene's glass; 0 where faces are flat."""
    opaque = np.array(loaded.surfaces.opaque)
    first, matrices, count = np.zeros(len(opaque), np.uint32), [np.zeros((1, 3, 3))], 1
    for shape in loaded.mi_scene.shapes():
        row = int(registry_id(mi.ShapePtr(shape))[0])
        if opaque[row]:
            continue
        parameters = mi.traverse(shape)
        faces = np.array(parameters["faces"]).reshape(-1, 3)
        points = np.array(parameters["vertex_positions"], np.float64).reshape(-1, 3)[faces]
        smooth = shape.has_vertex_normals()
        normals = np.array(parameters["vertex_normals"], np.float64).reshape(-1, 3)[faces] if smooth else 0.0 * points
        first[row], count = count, count + len(faces)
        matrices.append(along_triangles(points, normals))
    values = np.pad(np.concatenate(matrices).reshape(-1, 9), ((0, 0), (0, 3))).astype(np.float32)
    angle = min(1.0 / camera.focal for camera in loaded.description.cameras)
    result = NormalDerivatives(mi.Float(values.ravel()), mi.UInt32(first), mi.Float(angle))
    dr.make_opaque(result.values, result.first, result.pixel_angle)
    return result


def along_triangles(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return matrices (n, 3, 3) from a step along each triangle to the change of values that it interpolates.

    Parameters
    ----------
    points, values : (n, 3, 3) float
        Corners of triangles, and the vectors there.
    """
    edges, changes = (corners[:, 1:] - corners[:, :1] for corners in (points, values))
    return np.swapaxes(np.linalg.pinv(edges) @ changes, 1, 2)


def camera_footprint(derivatives: NormalDerivatives, direction: mi.Vector3f) -> Footprint:
    """Return the footprint of camera rays of unit directions."""
    frame, angle = mi.Frame3f(direction), derivatives.pixel_angle
    return Footprint(dr.zeros(mi.Vector3f), dr.zeros(mi.Vector3f), angle * frame.s, angle * frame.t)


def followed(
    footprint: Footprint | None,
    derivatives: NormalDerivatives | None,
    triangle: tuple[mi.UInt32, mi.Float],
    surface: SurfaceMedia,
    before: mi.Vector3f,
    event: Scattered,
    eta: mi.Float,
) -> Footprint | None:
    """Return the footprint after an interface; None where there is none.

    Snell's law in vector form is after = r before - (r cos_i - cos_o) n, with the ratio r of the indices and the
    cosines of both directions to n; a reflection has r = 1 and cos_o = -cos_i. This is its derivative.

    Parameters
    ----------
    footprint : Footprint, optional
        At the start of the segment that ends there.
    derivatives : NormalDerivatives, optional
        Of the scene's glass.
    triangle : (mi.UInt32, mi.Float)
        Number of the triangle in its shape, and the sign of its own normal over that on the ray's side.
    surface : SurfaceMedia
        The interface.
    before : mi.Vector3f
        Unit direction of the segment.
    event : Scattered
        What happens there.
    eta : mi.Float
        Index of the medium behind the interface over that of the medium before it.
    """
    if footprint is None or derivatives is None:
        return None
    number, sign = triangle
    entry = 3 * (dr.gather(mi.UInt32, derivatives.first, surface.row) + number)
    a, b, c = (sign * dr.gather(mi.Vector4f, derivatives.values, entry + k) for k in range(3))
    rows = mi.Vector3f(a.x, a.y, a.z), mi.Vector3f(a.w, b.x, b.y), mi.Vector3f(b.z, b.w, c.x)
    n, ng = mi.Vector3f(surface.ns), mi.Vector3f(surface.n)
    cos_i, cos_o = dr.minimum(dr.dot(before, n), -_MIN_COS), dr.dot(event.direction, n)
    ratio = dr.select(event.transmitted, dr.rcp(eta), 1.0)
    along_n = ratio * cos_i - cos_o
    refracted = ratio - dr.square(ratio) * cos_i / dr.minimum(cos_o, -_MIN_COS)
    slope = dr.select(event.transmitted, refracted, 2.0)

    def moved(p: mi.Vector3f, d: mi.Vector3f) -> tuple[mi.Vector3f, mi.Vector3f]:
        p = p + surface.distance * d
        p = p - before * (dr.dot(p, ng) / dr.minimum(dr.dot(before, ng), -_MIN_COS))
        change = mi.Vector3f(*(dr.dot(row, p) for row in rows))
        change = change - n * dr.dot(n, change)  # a unit vector stays one
        return p, ratio * d - along_n * change - slope * (dr.dot(d, n) + dr.dot(before, change)) * n

    p_u, d_u = moved(footprint.p_u, footprint.d_u)
    p_v, d_v = moved(footprint.p_v, footprint.d_v)
    return Footprint(p_u, p_v, d_u, d_v)
