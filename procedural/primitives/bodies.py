"""Glass bodies of a few numbers: any closed mesh, ball, slab, prism, and a vessel from the profile of its outside."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import trimesh

from ...core.errors import InputError
from ...core.mesh import Mesh, check_closed
from ..description.scene import FIRST_OBJECT_ID, GlassBody, Interface, Vessel
from ..optics.medium import AIR, Medium
from ..placement.placement import CONTACT_GAP
from ..profiles.liquid import brimful_volume
from ..vessels.build import Filling, build_vessel, vessel_shape
from ..vessels.outline import Outline, linear
from ..vessels.wall import WallShape, glass_section

Point = tuple[float, float, float]

#: Largest distance of a ball's or a vessel's mesh from the true surface [m]; the default of drawn vessels.
CHORD_ERROR = 15e-6
#: Levels of an icosphere: each has four times the triangles of the one before; 7 is 327,680.
_SUBDIVISIONS = range(2, 8)
#: Chord error of the unit icosphere without subdivision, 1 - sqrt((5 + 2 sqrt 5) / 15); each level quarters it.
_ICOSAHEDRON_SAGITTA = 0.2053
#: Of a vessel by hand: radii of the outer base corner, of the corner between floor and wall, and half the height over
#: which joints of the profile are smoothed [m]; the middle of what drawn vessels have.
_FILLET, _CORNER, _JOINT = 2e-3, 3e-3, 8e-3


def glass_body(
    mesh: Mesh,
    glass: Medium,
    *,
    id: int = FIRST_OBJECT_ID,
    name: str = "body",
    category: str = "body",
    roughness: float = 0.0,
    symmetric: bool = False,
    world_T_mesh: np.ndarray | None = None,
) -> GlassBody:
    """Return a solid body of one medium in air.

    Parameters
    ----------
    mesh : Mesh
        Closed, faces and normals outwards. It is moved so that its bounding box is about the origin; the pose moves it
        back.
    glass : Medium
        What it is made of.
    id, name, category : int, str, str
        As in the description; id and name are unique in a scene.
    roughness : float
        GGX alpha; 0 is smooth.
    symmetric : bool
        Whether it is a solid of revolution about the mesh's z axis, which then passes through the box's centre.
    world_T_mesh : (4, 4) float, optional
        Where the mesh's frame is; the world's by default.

    Raises
    ------
    InputError
        A mesh that is not closed or is inside out.
    """
    if len(mesh.faces) == 0:
        raise InputError(f"{name}, mesh {mesh.name}", "triangles", "none")
    check_closed(f"{name}, mesh {mesh.name}", mesh)
    centre = mesh.bounds.mean(0)
    centred = Mesh(mesh.name, mesh.vertices - centre, mesh.faces, mesh.normals, mesh.uv)
    shift = np.eye(4)
    shift[:3, 3] = centre
    skin = Interface(part="outside", mesh=centred, front=AIR, back=glass, roughness=roughness)
    x, y, z = np.ptp(centred.bounds, axis=0).tolist()
    return GlassBody(
        id=id,
        name=name,
        category=category,
        glass=glass,
        roughness=roughness,
        interfaces=(skin,),
        size=(x, y, z),
        symmetric=symmetric,
        world_T_object=shift if world_T_mesh is None else world_T_mesh @ shift,
    )


def ball(
    radius: float,
    glass: Medium,
    centre: Point = (0.0, 0.0, 0.0),
    *,
    id: int = FIRST_OBJECT_ID,
    name: str = "ball",
    chord_error: float = CHORD_ERROR,
) -> GlassBody:
    """Return a ball about a point [m], with exact normals; InputError where its radius [m] is not positive.

    The chord error [m] is kept down to the finest icosphere, of 327,680 triangles.
    """
    fine = (level for level in _SUBDIVISIONS if radius * _ICOSAHEDRON_SAGITTA / 4.0**level <= chord_error)
    mesh = ball_mesh(radius, next(fine, _SUBDIVISIONS[-1]), name)
    return glass_body(mesh, glass, id=id, name=name, category="ball", symmetric=True, world_T_mesh=_moved(centre))


def slab(
    size: Point, glass: Medium, centre: Point = (0.0, 0.0, 0.0), *, id: int = FIRST_OBJECT_ID, name: str = "slab"
) -> GlassBody:
    """Return a box with axis-parallel faces about a point [m]; InputError where a side [m] is not positive."""
    return glass_body(box_mesh(size, name), glass, id=id, name=name, category="slab", world_T_mesh=_moved(centre))


def prism(
    corners: Sequence[tuple[float, float]] | np.ndarray,
    depth: float,
    glass: Medium,
    *,
    id: int = FIRST_OBJECT_ID,
    name: str = "prism",
) -> GlassBody:
    """Return a convex polygon in the x z plane, corners (n, 2) [m], extruded along y by ``depth`` [m] about y = 0."""
    return glass_body(prism_mesh(corners, depth, name), glass, id=id, name=name, category="prism")


def vessel(
    profile: Sequence[tuple[float, float]],
    glass: Medium,
    *,
    wall: float = 2e-3,
    base: float = 4e-3,
    liquid: Medium | None = None,
    fill: float = 0.5,
    place: tuple[float, float] = (0.0, 0.0),
    id: int = FIRST_OBJECT_ID,
    name: str = "vessel",
    category: str = "vessel",
    chord_error: float = CHORD_ERROR,
) -> Vessel:
    """Return a vessel that stands on the table, `CONTACT_GAP` above z = 0, from the profile of its outside.

    Parameters
    ----------
    profile : sequence of (float, float)
        Radius and height [m] of the outside, from the foot at height 0 up; joints are smoothed, the base's corner and
        the rim are rounded.
    glass : Medium
        The glass.
    wall, base : float
        Smallest thickness of the wall and of the base [m].
    liquid : Medium, optional
        What it holds.
    fill : float
        Fraction of the brimful volume that is filled, with a liquid.
    place : (float, float)
        Where its axis stands, x and y [m].
    id, name, category : int, str, str
        As in the description.
    chord_error : float
        Largest distance of the meshes from the true surfaces [m].

    Raises
    ------
    InputError
        A profile that does not rise from height 0, radii that leave no room inside the wall, or a liquid too near to
        the rim.
    """
    _check_profile(name, profile, wall)
    pieces = tuple(linear(low, high, start, end) for (start, low), (end, high) in pairwise(profile))
    joints = tuple(min(_JOINT, 0.45 * min(a.high - a.low, b.high - b.low)) for a, b in pairwise(pieces))
    shape = WallShape(wall, taper=0.0, base=max(base, wall), fillet=_FILLET, corner=_CORNER, punt=0.0)
    try:
        section = glass_section(Outline(pieces, joints), shape, chord_error)
    except ValueError as error:
        raise InputError(f"{name}, profile", f"room inside a wall of {1e3 * wall:g} mm", str(error)) from error
    built = vessel_shape(section, wall)
    filling = None if liquid is None else Filling(liquid, fill * brimful_volume(built.inner.points))
    made = build_vessel(built, glass, 0.0, filling, chord_error, id=id, name=name, category=category)
    return made.model_copy(update={"world_T_object": _moved((*place, 0.5 * made.size[2] + CONTACT_GAP))})


def ball_mesh(radius: float, subdivisions: int, name: str = "ball", centre: Point = (0.0, 0.0, 0.0)) -> Mesh:
    """Return an icosphere about a point [m] with exact normals.

    Parameters
    ----------
    radius : float
        Radius [m].
    subdivisions : int
        The mesh has 20 * 4^subdivisions triangles; their distance from the sphere is at most
        ``0.2053 radius / 4^subdivisions``.
    name : str
        Name of the mesh.
    centre : (float, float, float)
        Centre [m].
    """
    _check_positive(f"{name}, radius", radius)
    solid = trimesh.creation.icosphere(subdivisions=subdivisions)
    unit = np.asarray(solid.vertices) / np.linalg.norm(solid.vertices, axis=1, keepdims=True)
    return Mesh(name, radius * unit + np.array(centre), np.asarray(solid.faces), unit)


def box_mesh(size: Point, name: str = "box", centre: Point = (0.0, 0.0, 0.0)) -> Mesh:
    """Return a box with axis-parallel, flat shaded faces about a point [m]."""
    for axis, side in zip("xyz", size, strict=True):
        _check_positive(f"{name}, size {axis}", side)
    solid = trimesh.creation.box(extents=size)
    return Mesh(name, np.asarray(solid.vertices) + np.array(centre), np.asarray(solid.faces))


def prism_mesh(corners: Sequence[tuple[float, float]] | np.ndarray, depth: float, name: str = "prism") -> Mesh:
    """Return a convex polygon in the x z plane, (n, 2) [m], extruded along y about y = 0, flat shaded."""
    _check_positive(f"{name}, depth", depth)
    points = np.asarray(corners, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise InputError(f"{name}, corners", "at least 3 rows (x, z)", f"an array of shape {points.shape}")
    edges = np.roll(points, -1, axis=0) - points
    after = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
    if not ((turns > 0.0).all() or (turns < 0.0).all()):
        raise InputError(f"{name}, corners", "a convex polygon, its corners in order", points.tolist())
    points = points if turns[0] > 0.0 else points[::-1]
    count = len(points)
    front, back = (np.insert(points, 1, y, axis=1) for y in (-0.5 * depth, 0.5 * depth))
    here = np.arange(count)
    there = np.roll(here, -1)
    fan = np.stack([np.zeros(count - 2, int), here[1:-1], here[2:]], axis=1)
    sides = [np.stack([here, here + count, there], axis=1), np.stack([there, here + count, there + count], axis=1)]
    return Mesh(name, np.concatenate([front, back]), np.concatenate([fan, fan[:, ::-1] + count, *sides]))


def _check_profile(name: str, profile: Sequence[tuple[float, float]], wall: float) -> None:
    _check_positive(f"{name}, wall", wall)
    points = np.asarray(profile, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise InputError(f"{name}, profile", "at least 2 rows (radius, height)", f"an array of shape {points.shape}")
    if points[0, 1] != 0.0 or not (np.diff(points[:, 1]) > 0.0).all():
        raise InputError(f"{name}, profile", "heights that rise from 0", points[:, 1].tolist())
    least = wall + _CORNER
    if not points[:, 0].min() > least:
        raise InputError(f"{name}, profile", f"radii above {1e3 * least:g} mm", f"{1e3 * points[:, 0].min():g} mm")


def _check_positive(where: str, value: float) -> None:
    if not 0.0 < value < np.inf:
        raise InputError(where, "a positive number of metres", value)


def _moved(centre: Point) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = centre
    return pose
