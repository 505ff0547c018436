"""The convex parts that stand for an object when bodies meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.mesh import Mesh
from ..description.bodies import MeshVessel, Prop, SceneObject, Vessel, glass_solid
from .decomposition import convex_parts
from .sectors import sector_parts
from .thin import thickened
from .wedges import ConvexPart, revolved_hull, revolved_parts

#: Deepest dent of a body whose hull stands for it [m]. A hull touches a plane where the body does; something that rests
#: in a dent floats by this much at most.
HULL_DEPTH = 1e-3
#: Parts that lie on the wall of their vessel.
ON_THE_WALL = ("label", "print")
#: Vertices, and middles of triangles, whose depth is looked at [1]: a dent that none of them is in is a detail.
_SAMPLES = 300


@dataclass(frozen=True, eq=False)
class BodyParts:
    """An object as bodies meet it, object frame.

    Parameters
    ----------
    hull : (n, 3) float64
        Corners of its convex hull, which is what a plane touches [m].
    parts : tuple of ConvexPart
        Convex bodies whose union stands for it; empty where the hull does.
    """

    hull: np.ndarray
    parts: tuple[ConvexPart, ...]


def body_parts(item: SceneObject) -> BodyParts:
    """Return the convex parts of an object without its liquid, none thinner than `LEAST_THICKNESS`.

    Vessels and props that are solids of revolution are rings of wedges of their section; vessels of other shapes are
    cut into sectors, drawn props into slices or sectors; what is convex but for `HULL_DEPTH` is its hull; everything
    else, which files have, is decomposed.
    """
    found = _parts(item)
    parts = tuple(replace(part, points=thickened(part.points)) for part in found.parts)
    return BodyParts(thickened(found.hull), parts)


def _parts(item: SceneObject) -> BodyParts:
    if isinstance(item, Vessel):
        return _of_revolution([_vessel_outline(item)])
    mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
    if isinstance(item, MeshVessel):
        corners, sectors = sector_parts(mesh)
        if sectors:
            return BodyParts(corners, tuple(sectors))
    points, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    places, faces = points.astype(np.float64), index.reshape(-1)[mesh.faces]
    thick = thickened(places)
    if len(thick) > len(places):  # a sheet, which has no hull of its own
        return BodyParts(thick, ())
    corners, depth = _hull(places, faces)
    if depth <= HULL_DEPTH:
        return BodyParts(corners, ())
    outlines = mesh_outlines(mesh) if item.symmetric else []
    if outlines:
        return _of_revolution(outlines)
    if not isinstance(item, Prop) or item.origin is None:  # drawn things are closed, and each is there once
        sectors = sector_parts(mesh, wall=not isinstance(item, Prop))[1]
        if sectors:
            return BodyParts(corners, tuple(sectors))
    return BodyParts(corners, tuple(ConvexPart(part) for part in convex_parts(places, faces)))


def with_attached(body: BodyParts, attached: Sequence[SceneObject]) -> BodyParts:
    """Return the shape of a body together with its parts, whose poses are in its frame: their hulls.

    A label or a print adds nothing: it lies on the wall, as thin as the gap that bodies keep, and the hull of one that
    goes around would fill the vessel.
    """
    hulls = []
    for part in attached:
        if part.category in ON_THE_WALL:
            continue
        points = body_parts(part).hull
        hulls.append(points @ part.world_T_object[:3, :3].T + part.world_T_object[:3, 3])
    if not hulls:
        return body
    own = body.parts or (ConvexPart(body.hull),)
    return BodyParts(np.concatenate([body.hull, *hulls]), (*own, *(ConvexPart(points) for points in hulls)))


def _of_revolution(outlines: list[np.ndarray]) -> BodyParts:
    parts = tuple(part for outline in outlines for part in revolved_parts(outline))
    return BodyParts(revolved_hull(np.concatenate(outlines)), parts)


def _hull(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the corners of the convex hull, and about how deep the surface lies in it where it is deepest [m]."""
    from scipy.spatial import ConvexHull  # here, as it takes a third of a second to load

    hull = ConvexHull(points)
    planes = np.unique(np.round(hull.equations, 9), axis=0)
    inner = np.delete(points, hull.vertices, axis=0)
    surface = np.concatenate([some[:: len(some) // _SAMPLES + 1] for some in (inner, points[faces].mean(1))])
    depth = (-(surface @ planes[:, :3].T + planes[:, 3])).min(1).max() if len(surface) else 0.0
    return points[hull.vertices], float(depth)


def _vessel_outline(item: Vessel) -> np.ndarray:
    """Return the half section of a vessel's glass, counter-clockwise."""
    return np.concatenate([np.array(item.outer), np.array(item.inner)[::-1][1:]])


def mesh_outlines(mesh: Mesh) -> list[np.ndarray]:
    """Return the half sections (n, 2) of a closed mesh that is a solid of revolution about z; none of an open one.

    The mesh is cut by the half plane of its first vertices off the axis, in which its rings have their corners.
    """
    from manifold3d import CrossSection, Error, Manifold
    from manifold3d import Mesh as Solid

    points, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    solid = Manifold(Solid(points.astype(np.float32), index.reshape(-1)[mesh.faces].astype(np.uint32)))
    if solid.status() != Error.NoError or solid.is_empty():
        return []
    # The plane y = 0 becomes the plane z = 0: (x, y, z) -> (x, z, -y).
    section = solid.transform(np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]])).slice(0.0)
    low, high = mesh.bounds[:, 2]
    reach = 2.0 * float(np.abs(mesh.bounds).max()) + 1.0
    half = CrossSection([np.array([[0.0, low - 1.0], [reach, low - 1.0], [reach, high + 1.0], [0.0, high + 1.0]])])
    return [np.array(outline) for part in (section ^ half).decompose() for outline in part.to_polygons()[:1]]
