"""Maps of roughness, metalness and shading normals, as one array that all ray loops read by the shape's id.

Labels know nothing of them: their normals are those of the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi

#: Least cosine between a mapped normal and the direction to the eye [1]. Normals that turn further away are bent
#: towards the eye: the surface there would be black, although something of it is seen.
_LEAST_COS = 0.02


@dataclass(frozen=True, eq=False)
class SurfaceMaps:
    """The maps of all shapes, one after another; columns by registry id."""

    texels: mi.Float  #: slopes along u and v, roughness, metalness; four numbers for each texel
    first: mi.UInt32  #: the first texel of a shape
    width: mi.UInt32  #: 0 where a shape has no maps
    height: mi.UInt32


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of what conditions return
class MappedValues:
    """What the maps say at points of surfaces; meaningless where they are not `mapped`."""

    mapped: mi.Bool
    slope_u: mi.Float
    slope_v: mi.Float
    roughness: mi.Float
    metallic: mi.Float


def surface_maps(maps: dict[int, np.ndarray], rows: int) -> SurfaceMaps | None:
    """Return the maps of shapes by registry id, each (h, w, 4) as `materials.surface_maps.bake_maps` returns it.

    None where no shape has any: the kernels of such scenes know nothing of maps.
    """
    if not maps:
        return None
    columns = np.zeros((3, rows), np.uint32)
    parts, first = [], 0
    for row, texels in maps.items():
        height, width, _ = texels.shape
        columns[:, row] = first, width, height
        parts.append(texels.reshape(-1))
        first += width * height
    found = SurfaceMaps(mi.Float(np.concatenate(parts)), *(mi.UInt32(column.copy()) for column in columns))
    dr.make_opaque(found.texels, found.first, found.width, found.height)
    return found


def values_at(maps: SurfaceMaps, si: mi.SurfaceInteraction3f, row: mi.UInt32) -> MappedValues:
    """Return the values at points, bilinear between the centres of texels, as bitmaps are read."""
    width, height = dr.gather(mi.UInt32, maps.width, row), dr.gather(mi.UInt32, maps.height, row)
    mapped, first = width > 0, dr.gather(mi.UInt32, maps.first, row)
    x = (si.uv.x - dr.floor(si.uv.x)) * mi.Float(width) - 0.5
    y = (si.uv.y - dr.floor(si.uv.y)) * mi.Float(height) - 0.5
    column, line = dr.floor(x), dr.floor(y)
    fx, fy = x - column, y - line
    left, below = _wrapped(mi.Int32(column), width), _wrapped(mi.Int32(line), height)
    right, above = _wrapped(mi.Int32(column) + 1, width), _wrapped(mi.Int32(line) + 1, height)

    def texel(at: mi.UInt32, on: mi.UInt32) -> mi.Vector4f:
        return dr.gather(mi.Vector4f, maps.texels, first + on * width + at, mapped)

    lower = dr.lerp(texel(left, below), texel(right, below), fx)
    upper = dr.lerp(texel(left, above), texel(right, above), fx)
    value = dr.lerp(lower, upper, fy)
    return MappedValues(mapped, value.x, value.y, value.z, value.w)


def _wrapped(index: mi.Int32, count: mi.UInt32) -> mi.UInt32:
    """Return an index from -1 to `count` within a row that repeats."""
    size = mi.Int32(count)
    return mi.UInt32(dr.select(index < 0, index + size, dr.select(index >= size, index - size, index)))


def mapped_normal(values: MappedValues, si: mi.SurfaceInteraction3f, n: mi.Normal3f, eye: mi.Vector3f) -> mi.Normal3f:
    """Return the shading normals of maps on the side of `n`; `n` itself where there is no map.

    Parameters
    ----------
    values : MappedValues
        The values at the points.
    si : mi.SurfaceInteraction3f
        The points, with the derivatives by texture coordinates.
    n : mi.Normal3f
        Unit shading normal on the eye's side.
    eye : mi.Vector3f
        Unit, towards the eye.
    """
    # Slopes belong to the front: seen from the back, hills are hollows.
    front = dr.select(dr.dot(n, si.n) >= 0.0, mi.Float(1.0), mi.Float(-1.0))
    along = si.dp_du - n * dr.dot(n, si.dp_du)
    length = dr.norm(along)
    u = along / dr.maximum(length, 1e-12)
    v = dr.cross(n, u)
    v = dr.select(dr.dot(v, si.dp_dv) < 0.0, -v, v)
    tilted = dr.normalize(n - front * (values.slope_u * u + values.slope_v * v))
    lacking = dr.maximum(_LEAST_COS - dr.dot(tilted, eye), 0.0)
    bent = dr.normalize(tilted + lacking * eye)
    return mi.Normal3f(dr.select(values.mapped & (length > 0.0), bent, n))


def above_surface(values: MappedValues, si: mi.SurfaceInteraction3f, eye: mi.Vector3f, out: mi.Vector3f) -> mi.Bool:
    """Return whether directions leave surfaces on the eye's side; True where there is no map."""
    return ~values.mapped | (dr.dot(si.n, eye) * dr.dot(si.n, out) > 0.0)
