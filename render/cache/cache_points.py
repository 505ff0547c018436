"""Where light is stored: a grid on the table's top, and the vertices of all other opaque surfaces.

The grid is as fine as a pixel of the nearest camera under and beside the objects, where caustics and contact shadows
are, and coarser elsewhere. Other opaque meshes are cut fine when they are loaded (`scene.loaded_scene.load`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import Scene
from .._mitsuba import dr, mi
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import registry_id

#: Width of the strip round the objects that has fine cells [m]: as far as a vessel of that height throws its caustic
#: under light from 45 degrees.
MARGIN = 0.15
#: Coarse cells over fine ones.
COARSE = 6.0
#: Bounds of a fine cell [m].
FINEST, COARSEST = 5e-4, 4e-3
#: Most fine cells along one side: two million in all, 100 MB.
MOST_CELLS = 1400
#: How near z = 0 a point lies on the table's top [m]: rays find it within a micrometre.
_TOP = 1e-5


@dataclass(frozen=True)
class Axis:
    """One side of the grid: coarse, fine, coarse. Lines lie where `place` is a whole number."""

    low: float  #: where the grid begins [m]
    fine_low: float  #: ... and its fine part
    fine_high: float
    high: float
    step: float  #: fine cell [m]

    @property
    def lines(self) -> int:
        """How many lines there are."""
        return int(np.ceil(self.place(np.array(self.high)) - 1e-9)) + 1

    def place(self, x: np.ndarray) -> np.ndarray:
        """Return positions on the axis, counted in cells."""
        wide, inside = COARSE * self.step, np.clip(x, self.fine_low, self.fine_high)
        before, after = np.minimum(x, self.fine_low) - self.low, np.maximum(x, self.fine_high) - self.fine_high
        return before / wide + (inside - self.fine_low) / self.step + after / wide

    def coordinate(self, place: np.ndarray) -> np.ndarray:
        """Return the coordinates of positions counted in cells [m]: the inverse of `place`."""
        wide = COARSE * self.step
        first, second = (float(self.place(np.array(x))) for x in (self.fine_low, self.fine_high))
        before, after = np.minimum(place, first), np.maximum(place, second) - second
        return self.low + before * wide + (np.clip(place, first, second) - first) * self.step + after * wide


@dataclass(frozen=True, eq=False)
class Nodes:
    """All places where light is stored. First the grid's, row by row (x runs fastest), then the vertices.

    Open meshes show both sides; their vertices stand twice, the second time for the back.
    """

    axes: tuple[Axis, Axis]  #: x, y
    positions: np.ndarray  #: (vertices, 3) float32, world [m]
    normals: np.ndarray  #: (vertices, 3) float32, shading normals on the side that the light is stored for
    triangles: np.ndarray  #: (triangles, 3) uint32, vertices of the cut meshes, counted from the first vertex
    back: np.ndarray  #: (vertices,) bool, whether the light is that of a back side
    mesh: np.ndarray  #: (vertices,) uint32, which mesh the vertex belongs to
    first_triangle: np.ndarray  #: by registry id: where a shape's triangles begin
    to_back: np.ndarray  #: by registry id: from a vertex to the one of its back side; 0 where they are the same

    @property
    def grid_count(self) -> int:
        """Nodes of the grid."""
        return self.axes[0].lines * self.axes[1].lines

    @property
    def count(self) -> int:
        """All nodes."""
        return self.grid_count + len(self.positions)

    @property
    def fine(self) -> float:
        """Side of a fine cell [m]."""
        return self.axes[0].step


def place_nodes(kernel: LoadedScene) -> Nodes:
    """Return where light is to be stored in a scene that was loaded with cut meshes."""
    positions, normals, triangles, back, mesh = [], [], [], [], []
    rows = int(dr.width(kernel.surfaces.instance))
    first_triangle, to_back = np.zeros(rows, np.uint32), np.zeros(rows, np.uint32)
    vertices, faces = 0, 0
    for number, body in enumerate(kernel.opaque_bodies):
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
    return Nodes(
        axes=grid_axes(kernel.description),
        positions=np.concatenate(positions),
        normals=np.concatenate(normals).astype(np.float32),
        triangles=np.concatenate(triangles).astype(np.uint32),
        back=np.concatenate(back),
        mesh=np.concatenate(mesh),
        first_triangle=first_triangle,
        to_back=to_back,
    )


def to_front(nodes: Nodes) -> np.ndarray:
    """Return by vertex how far before it the same vertex of the front stands: 0 for fronts."""
    away = np.zeros(len(nodes.positions), np.uint32)
    runs = np.flatnonzero(np.diff(nodes.back.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    for begin, end in runs:  # the backs of one mesh follow its fronts
        away[begin:end] = end - begin
    return away


def vertex_areas(nodes: Nodes) -> np.ndarray:
    """Return a third of the area of the triangles round each vertex [m^2]; 0 for backs, which no triangle names."""
    corners = nodes.positions[nodes.triangles].astype(np.float64)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.bincount(nodes.triangles.ravel(), np.repeat(area / 3.0, 3), len(nodes.positions))


def grid_axes(scene: Scene) -> tuple[Axis, Axis]:
    """Return both sides of the grid on the table's top."""
    top = scene.table.mesh.vertices[scene.table.mesh.vertices[:, 2] == 0.0, :2].astype(np.float64)
    low, high = top.min(0), top.max(0)
    fine_low, fine_high = _round_objects(scene, low, high)
    step = float(np.clip(pixel_on_table(scene), FINEST, COARSEST))
    step = max(step, float((fine_high - fine_low).max()) / MOST_CELLS)
    x, y = (_axis(float(low[k]), float(fine_low[k]), float(fine_high[k]), float(high[k]), step) for k in range(2))
    return x, y


def _axis(low: float, fine_low: float, fine_high: float, high: float, step: float) -> Axis:
    """Return an axis whose fine part begins and ends at lines: no cell has both kinds of step."""
    fine_low = low + np.floor((fine_low - low) / (COARSE * step)) * COARSE * step
    fine_high = fine_low + np.ceil((fine_high - fine_low) / step - 1e-9) * step
    return Axis(low, float(fine_low), float(fine_high), max(high, float(fine_high)), step)


def pixel_on_table(scene: Scene) -> float:
    """Return the side of a pixel at the middle of the table, seen from the nearest camera [m]."""
    return min(float(np.linalg.norm(c.world_T_camera[:3, 3])) / c.focal for c in scene.cameras)


def _round_objects(scene: Scene, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if not scene.objects:
        return low, low
    places = np.array([item.world_T_object[:2, 3] for item in scene.objects])
    reach = np.array([[np.linalg.norm(item.size) / 2 + MARGIN] for item in scene.objects])
    return np.clip((places - reach).min(0), low, high), np.clip((places + reach).max(0), low, high)


@dataclass(frozen=True, eq=False)
class Lookup:
    """The arrays with which a ray's hit finds the nodes round it."""

    low: mi.Point2f
    fine_low: mi.Point2f
    fine_high: mi.Point2f
    step: mi.Float
    lines: mi.Point2u
    first_vertex: mi.UInt32
    triangles: mi.UInt32
    first_triangle: mi.UInt32
    to_back: mi.UInt32


def lookup_of(nodes: Nodes) -> Lookup:
    """Return the nodes as opaque Dr.Jit arrays."""
    x, y = nodes.axes
    result = Lookup(
        low=mi.Point2f(x.low, y.low),
        fine_low=mi.Point2f(x.fine_low, y.fine_low),
        fine_high=mi.Point2f(x.fine_high, y.fine_high),
        step=mi.Float(x.step),
        lines=mi.Point2u(x.lines, y.lines),
        first_vertex=mi.UInt32(nodes.grid_count),
        triangles=mi.UInt32(nodes.triangles.ravel()),
        first_triangle=mi.UInt32(nodes.first_triangle),
        to_back=mi.UInt32(nodes.to_back),
    )
    dr.make_opaque(result.low, result.fine_low, result.fine_high, result.step, result.lines)
    dr.make_opaque(result.first_vertex, result.triangles, result.first_triangle, result.to_back)
    return result


def nodes_round(
    lookup: Lookup, si: mi.SurfaceInteraction3f, corner: mi.Point2f, seen_from: mi.Vector3f, on_table: mi.Bool
) -> tuple[list[mi.UInt32], list[mi.Float]]:
    """Return the four nodes round a hit, and their weights, which sum to 1 (three on a triangle, the fourth is 0).

    Parameters
    ----------
    lookup : Lookup
        The nodes.
    si : mi.SurfaceInteraction3f
        The hit, on an opaque surface.
    corner : mi.Point2f
        Its barycentric coordinates at the second and third corner of its triangle.
    seen_from : mi.Vector3f
        Towards the eye.
    on_table : mi.Bool
        Whether it belongs to the table.
    """
    top = on_table & (dr.abs(si.p.z) < _TOP) & (seen_from.z > 0.0)
    i, j, u, v = _cell(lookup, si.p)
    row = j * lookup.lines.x + i
    grid = [row, row + 1, row + lookup.lines.x, row + lookup.lines.x + 1]
    shares = [(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v]

    shape = registry_id(si.shape)
    triangle = dr.gather(mi.UInt32, lookup.first_triangle, shape, ~top) + si.prim_index
    behind = dr.dot(si.n, seen_from) < 0.0
    base = lookup.first_vertex + dr.select(behind, dr.gather(mi.UInt32, lookup.to_back, shape, ~top), 0)
    vertices = [base + dr.gather(mi.UInt32, lookup.triangles, 3 * triangle + k, ~top) for k in range(3)]
    corners = [1 - corner.x - corner.y, corner.x, corner.y]
    index = [dr.select(top, a, b) for a, b in zip(grid, [*vertices, vertices[0]], strict=True)]
    weight = [dr.select(top, a, b) for a, b in zip(shares, [*corners, mi.Float(0.0)], strict=True)]
    return index, weight


def _cell(lookup: Lookup, p: mi.Point3f) -> tuple[mi.UInt32, mi.UInt32, mi.Float, mi.Float]:
    at = mi.Point2f(p.x, p.y)
    wide, inside = COARSE * lookup.step, dr.clip(at, lookup.fine_low, lookup.fine_high)
    before = dr.minimum(at, lookup.fine_low) - lookup.low
    after = dr.maximum(at, lookup.fine_high) - lookup.fine_high
    place = dr.maximum(before / wide + (inside - lookup.fine_low) / lookup.step + after / wide, 0.0)
    i, j = dr.minimum(mi.UInt32(place.x), lookup.lines.x - 2), dr.minimum(mi.UInt32(place.y), lookup.lines.y - 2)
    return i, j, dr.minimum(place.x - mi.Float(i), 1.0), dr.minimum(place.y - mi.Float(j), 1.0)
