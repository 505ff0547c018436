"""Points of the irradiance cache: a grid on the table's top, and the vertices of all other opaque surfaces.

The grid is as fine as a pixel of the nearest camera under and beside the objects, where caustics and contact shadows
are, and coarser elsewhere. Other opaque meshes are refined when they are loaded (`scene.loaded_scene.load`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import Scene
from .._mitsuba import dr, mi
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import registry_id

#: Width of the strip around the objects that has fine cells [m]: the reach of the caustic of a vessel of that height
#: under light from 45 degrees.
MARGIN = 0.15
#: Side of a coarse cell over that of a fine one [1].
COARSE = 6.0
#: Bounds of the side of a fine cell [m].
MIN_CELL, MAX_CELL = 5e-4, 4e-3
#: Maximum number of fine cells along one side [1]: two million in all, 100 MB.
MAX_CELLS = 1400
#: Distance from z = 0 up to which a point belongs to the table's top [m]: ray intersections are within a micrometre.
_TOP = 1e-5
#: Area given to vertices of triangles without area, which no ray meets [m^2].
_NO_AREA = 1e-12


@dataclass(frozen=True)
class Axis:
    """One axis of the grid: coarse, fine, coarse. Grid lines are where `cell_position` is an integer."""

    low: float  #: start of the grid [m]
    fine_low: float  #: start of its fine part [m]
    fine_high: float  #: end of its fine part [m]
    high: float  #: end of the grid [m]
    step: float  #: side of a fine cell [m]

    @property
    def lines(self) -> int:
        """Number of grid lines."""
        return int(np.ceil(self.cell_position(np.array(self.high)) - 1e-9)) + 1

    def cell_position(self, x: np.ndarray) -> np.ndarray:
        """Return coordinates [m] in units of cells."""
        wide, inside = COARSE * self.step, np.clip(x, self.fine_low, self.fine_high)
        before, after = np.minimum(x, self.fine_low) - self.low, np.maximum(x, self.fine_high) - self.fine_high
        return before / wide + (inside - self.fine_low) / self.step + after / wide

    def coordinate(self, position: np.ndarray) -> np.ndarray:
        """Return the coordinates of positions in units of cells [m]: the inverse of `cell_position`."""
        wide = COARSE * self.step
        first, second = (float(self.cell_position(np.array(x))) for x in (self.fine_low, self.fine_high))
        before, after = np.minimum(position, first), np.maximum(position, second) - second
        return self.low + before * wide + (np.clip(position, first, second) - first) * self.step + after * wide


@dataclass(frozen=True, eq=False)
class CachePoints:
    """All points of the irradiance cache. First those of the grid, row by row (x runs fastest), then the vertices.

    Open meshes show both sides; their vertices are listed twice, the second time for the back side.
    """

    axes: tuple[Axis, Axis]  #: x, y
    positions: np.ndarray  #: (vertices, 3) float32, world [m]
    normals: np.ndarray  #: (vertices, 3) float32, shading normals on the side that receives the light
    triangles: np.ndarray  #: (triangles, 3) uint32, vertex indices of the refined meshes
    back: np.ndarray  #: (vertices,) bool, whether the vertex stands for a back side
    mesh: np.ndarray  #: (vertices,) uint32, index of the vertex's mesh
    first_triangle: np.ndarray  #: by registry id: first triangle of the shape
    to_back: np.ndarray  #: by registry id: offset from a vertex to that of its back side; 0 for closed meshes

    @property
    def grid_count(self) -> int:
        """Number of points of the grid."""
        return self.axes[0].lines * self.axes[1].lines

    @property
    def count(self) -> int:
        """Number of all points."""
        return self.grid_count + len(self.positions)

    @property
    def fine(self) -> float:
        """Side of a fine cell [m]."""
        return self.axes[0].step


def cache_points_of(loaded: LoadedScene) -> CachePoints:
    """Return the points of a scene's irradiance cache.

    Raises
    ------
    ValueError
        If the scene was loaded without ``for_cache=True``.
    """
    if not loaded.opaque_bodies:
        raise ValueError("the irradiance cache needs a scene that was loaded with for_cache=True")
    positions, normals, triangles, back, mesh = [], [], [], [], []
    rows = int(dr.width(loaded.surfaces.instance))
    first_triangle, to_back = np.zeros(rows, np.uint32), np.zeros(rows, np.uint32)
    vertices, faces = 0, 0
    for number, body in enumerate(loaded.opaque_bodies):
        sides = (1.0,) if body.closed else (1.0, -1.0)
        first_triangle[body.row], to_back[body.row] = faces, 0 if body.closed else len(body.positions)
        triangles.append(body.faces + vertices)
        faces += len(body.faces)
        for sign in sides:
            positions.append(body.positions)
            normals.append(sign * body.normals)
            back.append(np.full(len(body.positions), sign < 0.0))
            mesh.append(np.full(len(body.positions), number, np.uint32))
            vertices += len(body.positions)
    return CachePoints(
        axes=grid_axes(loaded.description),
        positions=np.concatenate(positions),
        normals=np.concatenate(normals).astype(np.float32),
        triangles=np.concatenate(triangles).astype(np.uint32),
        back=np.concatenate(back),
        mesh=np.concatenate(mesh),
        first_triangle=first_triangle,
        to_back=to_back,
    )


def to_front(points: CachePoints) -> np.ndarray:
    """Return by vertex the offset to the same vertex of the front side, counted backwards: 0 for front sides."""
    offset = np.zeros(len(points.positions), np.uint32)
    runs = np.flatnonzero(np.diff(points.back.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    for begin, end in runs:  # the back sides of a mesh follow its front sides
        offset[begin:end] = end - begin
    return offset


def vertex_areas(points: CachePoints) -> np.ndarray:
    """Return a third of the area of each vertex's triangles [m^2]; 0 for back sides, which have no triangles."""
    corners = points.positions[points.triangles].astype(np.float64)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.bincount(points.triangles.ravel(), np.repeat(area / 3.0, 3), len(points.positions))


def point_areas(points: CachePoints) -> np.ndarray:
    """Return the area that each cache point represents [m^2], > 0: the places that it is nearest to."""
    x, y = (_line_widths(axis) for axis in points.axes)
    back = np.arange(len(points.positions)) - to_front(points)  # back sides have the triangles of their front sides
    vertices = np.maximum(vertex_areas(points)[back], _NO_AREA)
    return np.concatenate([np.outer(y, x).ravel(), vertices])


def _line_widths(axis: Axis) -> np.ndarray:
    """Return the width of the strip that is nearest to each grid line [m]."""
    lines = axis.coordinate(np.arange(axis.lines))
    steps = np.diff(lines)
    return 0.5 * (np.append(steps, 0.0) + np.insert(steps, 0, 0.0))


def grid_axes(scene: Scene) -> tuple[Axis, Axis]:
    """Return both axes of the grid on the table's top."""
    top = scene.table.mesh.vertices[scene.table.mesh.vertices[:, 2] == 0.0, :2].astype(np.float64)
    low, high = top.min(0), top.max(0)
    fine_low, fine_high = _around_objects(scene, low, high)
    step = float(np.clip(pixel_on_table(scene), MIN_CELL, MAX_CELL))
    step = max(step, float((fine_high - fine_low).max()) / MAX_CELLS)
    x, y = (_axis(float(low[k]), float(fine_low[k]), float(fine_high[k]), float(high[k]), step) for k in range(2))
    return x, y


def _axis(low: float, fine_low: float, fine_high: float, high: float, step: float) -> Axis:
    """Return an axis whose fine part starts and ends at grid lines: no cell has both step sizes."""
    fine_low = low + np.floor((fine_low - low) / (COARSE * step)) * COARSE * step
    fine_high = fine_low + np.ceil((fine_high - fine_low) / step - 1e-9) * step
    return Axis(low, float(fine_low), float(fine_high), max(high, float(fine_high)), step)


def pixel_on_table(scene: Scene) -> float:
    """Return the side of a pixel of the nearest camera at the centre of the table [m]."""
    return min(float(np.linalg.norm(c.world_T_camera[:3, 3])) / max(c.fx, c.fy) for c in scene.cameras)


def _around_objects(scene: Scene, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the table's part around the objects."""
    if not scene.objects:
        return low, low
    positions = np.array([item.world_T_object[:2, 3] for item in scene.objects])
    reach = np.array([[np.linalg.norm(item.size) / 2 + MARGIN] for item in scene.objects])
    return np.clip((positions - reach).min(0), low, high), np.clip((positions + reach).max(0), low, high)


@dataclass(frozen=True, eq=False)
class Lookup:
    """The cache points as Dr.Jit arrays, to find those around the hit point of a ray."""

    low: mi.Point2f
    fine_low: mi.Point2f
    fine_high: mi.Point2f
    step: mi.Float
    lines: mi.Point2u
    first_vertex: mi.UInt32
    triangles: mi.UInt32
    first_triangle: mi.UInt32
    to_back: mi.UInt32


def lookup_of(points: CachePoints) -> Lookup:
    """Return the cache points as opaque Dr.Jit arrays."""
    x, y = points.axes
    result = Lookup(
        low=mi.Point2f(x.low, y.low),
        fine_low=mi.Point2f(x.fine_low, y.fine_low),
        fine_high=mi.Point2f(x.fine_high, y.fine_high),
        step=mi.Float(x.step),
        lines=mi.Point2u(x.lines, y.lines),
        first_vertex=mi.UInt32(points.grid_count),
        triangles=mi.UInt32(points.triangles.ravel()),
        first_triangle=mi.UInt32(points.first_triangle),
        to_back=mi.UInt32(points.to_back),
    )
    dr.make_opaque(result.low, result.fine_low, result.fine_high, result.step, result.lines)
    dr.make_opaque(result.first_vertex, result.triangles, result.first_triangle, result.to_back)
    return result


def interpolation_weights(
    lookup: Lookup, si: mi.SurfaceInteraction3f, barycentric: mi.Point2f, towards_eye: mi.Vector3f, on_table: mi.Bool
) -> tuple[list[mi.UInt32], list[mi.Float]]:
    """Return the four cache points around a hit point and their interpolation weights, which sum to 1.

    On a triangle there are three, and the fourth weight is 0.

    Parameters
    ----------
    lookup : Lookup
        The points.
    si : mi.SurfaceInteraction3f
        The hit point, on an opaque surface.
    barycentric : mi.Point2f
        Its barycentric coordinates of the second and third vertex of the triangle.
    towards_eye : mi.Vector3f
        Direction against the ray.
    on_table : mi.Bool
        Whether the surface is the table.
    """
    top = on_table & (dr.abs(si.p.z) < _TOP) & (towards_eye.z > 0.0)
    i, j, u, v = _cell(lookup, si.p)
    row = j * lookup.lines.x + i
    grid = [row, row + 1, row + lookup.lines.x, row + lookup.lines.x + 1]
    bilinear = [(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v]

    shape = registry_id(si.shape)
    triangle = dr.gather(mi.UInt32, lookup.first_triangle, shape, ~top) + si.prim_index
    behind = dr.dot(si.n, towards_eye) < 0.0
    base = lookup.first_vertex + dr.select(behind, dr.gather(mi.UInt32, lookup.to_back, shape, ~top), 0)
    vertices = [base + dr.gather(mi.UInt32, lookup.triangles, 3 * triangle + k, ~top) for k in range(3)]
    corners = [1 - barycentric.x - barycentric.y, barycentric.x, barycentric.y]
    index = [dr.select(top, a, b) for a, b in zip(grid, [*vertices, vertices[0]], strict=True)]
    weight = [dr.select(top, a, b) for a, b in zip(bilinear, [*corners, mi.Float(0.0)], strict=True)]
    return index, weight


def _cell(lookup: Lookup, p: mi.Point3f) -> tuple[mi.UInt32, mi.UInt32, mi.Float, mi.Float]:
    """Return column and row of the grid cell of a point, and the position in it, both in [0, 1]."""
    at = mi.Point2f(p.x, p.y)
    wide, inside = COARSE * lookup.step, dr.clip(at, lookup.fine_low, lookup.fine_high)
    before = dr.minimum(at, lookup.fine_low) - lookup.low
    after = dr.maximum(at, lookup.fine_high) - lookup.fine_high
    position = dr.maximum(before / wide + (inside - lookup.fine_low) / lookup.step + after / wide, 0.0)
    i, j = dr.minimum(mi.UInt32(position.x), lookup.lines.x - 2), dr.minimum(mi.UInt32(position.y), lookup.lines.y - 2)
    return i, j, dr.minimum(position.x - mi.Float(i), 1.0), dr.minimum(position.y - mi.Float(j), 1.0)
