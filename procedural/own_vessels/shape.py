"""A vessel of the user, understood: its solid, whether it is one of revolution, and the glass that its file says."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from ...core.errors import InputError, cause_of
from ...core.mesh import Mesh, volume_of
from ..cavities.columns import pitch_for
from ..cavities.interior import interior_of
from ..cavities.wall import spread
from ..description.bodies import Origin
from ..mesh_files.embedded import picture_folder
from ..mesh_files.model import Look, Notes, Source
from ..optics.catalogue import glass_named
from ..optics.draw import glass_names
from ..optics.medium import Medium
from ..props.glass import medium_of
from ..props.normals import CREASE, creased
from ..vessels.settings import UpAxis, VesselSettings
from .choice import FileChoice
from .files import VesselFile
from .points import solid_of_points
from .read import UP, metres_per_unit, read_triangles, turned_up
from .repair import closed_solid
from .smoothing import smoothed

#: Shapes that are remembered between scenes [1].
_REMEMBERED = 32
#: Points of the surface, sectors about the axis, and largest distance between the sections of two sectors, as a
#: fraction of the longest side [1], for a solid of revolution: a ring of 24 edges is off by 0.9 % of its radius.
_POINTS, _SECTORS, _ROUND = 40_000, 16, 0.012
#: Part of the points that has to be so near [1]: near the axis a sector has few. The smallest handle is more.
_ALIKE = 0.995
#: Least part of its box that a body holds the right way up [1]: less is a hollow under a foot.
_LEAST_HELD = 0.02
#: Lowest part of a body that stands on the table [1 of its height].
_FOOT = 0.02


@dataclass(frozen=True, eq=False)
class OwnShape:
    """A vessel of the user.

    Parameters
    ----------
    solid : Mesh
        Closed, z up, its box about the origin, with normals.
    glass : Medium or None
        What its file says that it is made of.
    symmetric : bool
        Whether it is a solid of revolution about z.
    origin : Origin
        Where it comes from, and how its frame lies in the file's.
    """

    solid: Mesh
    glass: Medium | None
    symmetric: bool
    origin: Origin


def own_shape(file: VesselFile, settings: VesselSettings) -> OwnShape:
    """Return the shape in a file; InputError with what is wrong with it and where."""
    return read_shape(file, settings)[0]


def read_shape(file: VesselFile, settings: VesselSettings) -> tuple[OwnShape, Notes]:
    """Return the shape in a file, and what its reader noted: the licence that it states, and files that it refers to.

    Raises
    ------
    InputError
        With what is wrong with the file, and where.
    """
    try:
        stamp = file.path.stat()
    except OSError as error:
        raise InputError(file.path, "a readable mesh", cause_of(error)) from error
    # Its licence may have been found after it was read first.
    plain = replace(file, place=replace(file.place, licence="unknown"))
    shape, notes = _read_shape(plain, FileChoice.of(settings), stamp.st_size, stamp.st_mtime_ns)
    origin = shape.origin.model_copy(update={"licence": file.place.licence})
    return replace(shape, origin=origin), notes


@lru_cache(_REMEMBERED)
def _read_shape(file: VesselFile, choice: FileChoice, _size: int, _changed: int) -> tuple[OwnShape, Notes]:
    path, notes = file.path, Notes()
    # Pictures are not looked at: glass has none.
    source = Source(path, file.root, picture_folder(), notes, check_pictures=False)
    found = read_triangles(source)
    scale = metres_per_unit(path, found.vertices, choice.unit, file.place)
    vertices, faces = scale * found.vertices, found.faces
    if not len(faces):
        if choice.shell is None:
            expected = "faces, or a thickness for a surface through the points (--vessels.shell 3mm)"
            raise InputError(path, expected, f"{len(vertices):,} points alone")
        vertices, faces = solid_of_points(path, vertices, choice.shell)
    surface = closed_solid(path, vertices, faces, choice.shell)
    if choice.smooth is not None:
        surface = smoothed(path, surface, choice.smooth)
    up = _fullest(surface.vertices, surface.faces) if choice.up == "fullest" else choice.up or file.place.up
    placed = turned_up(surface.vertices, up)
    solid = _with_normals(placed - 0.5 * (placed.min(0) + placed.max(0)), surface.faces, choice.smooth)
    _check_thickness(path, solid)
    x, y, z = (0.5 / scale * (surface.vertices.min(0) + surface.vertices.max(0))).tolist()
    origin = Origin(
        file=file.name,
        layout=file.place.layout,
        metres_per_unit=scale,
        centre=(x, y, z),
        up=up,
    )
    return OwnShape(solid, _glass(path, found.look, scale), is_round(solid), origin), notes


def _check_thickness(path: Path, solid: Mesh) -> None:
    """Refuse a solid around nothing, or with walls thinner than the lines are apart along which cavities are sought."""
    volume = volume_of(solid)
    if volume <= 0.0:
        raise InputError(path, "a solid", "a surface around nothing")
    corners = solid.vertices[solid.faces].astype(np.float64)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    thickness, least = 2.0 * volume / area, pitch_for(solid.vertices.astype(np.float64), 0.0)
    if thickness < least:
        wall = f"walls of {1e3 * thickness:.2g} mm on average; a file of one open surface gets them by --vessels.shell"
        raise InputError(path, f"walls of at least {1e3 * least:.2g} mm in a vessel of this width", wall)


def _glass(path: Path, look: Look | None, scale: float) -> Medium | None:
    """Return what a file's material is: a glass or plastic of the catalogue by its name, or as the file states it."""
    if look is None or look.glass is None:
        return None
    names = {name.lower(): name for name in glass_names()}
    known = names.get(re.sub(r"[_\-]+", " ", look.name.lower()).strip())
    if known is not None:
        return glass_named(known)
    return medium_of(look.glass, scale, f"{look.name[:60] or 'glass'} of {path.name}")


def _with_normals(vertices: np.ndarray, faces: np.ndarray, smooth: float | None = None) -> Mesh:
    single = vertices.astype(np.float32).astype(np.float64)
    points, corners, normals, _ = creased(single, faces, crease=max(smooth or 0.0, CREASE))
    return Mesh("solid", points, corners, normals)


def _fullest(vertices: np.ndarray, faces: np.ndarray) -> UpAxis:
    """Return the axis that has to point up so that a solid holds most, or stands on most where it holds nothing."""
    turned: dict[UpAxis, Mesh] = {axis: Mesh(f"up {axis}", turned_up(vertices, axis), faces) for axis in UP}
    held = {axis: interior_of(mesh).volume for axis, mesh in turned.items()}
    best = max(turned, key=lambda axis: held[axis])
    box = float(np.prod(np.ptp(vertices, axis=0)))
    if held[best] > _LEAST_HELD * box:
        return best
    return max(turned, key=lambda axis: _foot(turned[axis].vertices.astype(np.float64)))


def _foot(points: np.ndarray) -> float:
    """Return the area that a solid stands on [m^2]: the hull, from above, of what is lowest."""
    low, high = points[:, 2].min(), points[:, 2].max()
    lowest = points[points[:, 2] <= low + _FOOT * (high - low), :2]
    if np.linalg.matrix_rank(lowest - lowest[0]) < 2:
        return 0.0
    return float(ConvexHull(lowest).volume)


def is_round(solid: Mesh) -> bool:
    """Return whether a solid is one of revolution about z: its sections at all angles are the same."""
    points, _ = spread(solid.vertices[solid.faces].astype(np.float64), _POINTS)
    section = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=1)
    turns = np.arctan2(points[:, 1], points[:, 0]) / (2.0 * np.pi)
    sector = np.floor(turns * _SECTORS).astype(int) % _SECTORS
    reach = _ROUND * float(np.ptp(solid.bounds, axis=0).max())
    everything = cKDTree(section)
    for number in range(_SECTORS):
        some = section[sector == number]
        if len(some) < _POINTS // (4 * _SECTORS):
            return False
        # From everywhere to the sector, and back: a handle is in few sectors, a notch is missing in few.
        if np.quantile(cKDTree(some).query(everything.data)[0], _ALIKE) > reach:
            return False
    return True
