"""Points of a view's surfaces with colours, normals and ids, and their PLY files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...annotate.projection import transformed, unproject
from ...core.errors import InputError
from ..format import layout
from ..reader import StoredView

#: A vertex of our PLY files; MeshLab, CloudCompare, Open3D and trimesh know all of these names but `id`, which they
#: keep as a scalar field or ignore.
VERTEX = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    + [(name, "u1") for name in ("red", "green", "blue")]
    + [("id", "<u2")]
)
#: Digits of the largest number of points; fewer are made up for in a comment.
_COUNT_DIGITS = 20
_PLY_TYPES = {"<f4": "float", "|u1": "uchar", "<u2": "ushort"}


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points in the world frame."""

    points: np.ndarray  #: (n, 3) float64 [m]
    normals: np.ndarray  #: (n, 3) float64, unit, towards the camera
    colours: np.ndarray  #: (n, 3) uint8, sRGB of the left picture
    ids: np.ndarray  #: (n,) uint16, instance ids


def cloud_of(view: StoredView, ids: frozenset[int] | None = None) -> Cloud:
    """Return the first surfaces that the left camera sees, a point per pixel, row by row.

    Parameters
    ----------
    view : StoredView
        The view.
    ids : set of int, optional
        Only points of these instances; all by default.
    """
    camera, geometry, picture = view.camera(), view.geometry(), view.picture()
    if picture.shape[:2] != geometry.Z.shape:
        raise InputError(view.folder / "left.png", f"a picture of {geometry.Z.shape} px", picture.shape[:2])
    shown = np.isfinite(geometry.Z)
    if ids is not None:
        shown &= np.isin(geometry.id, list(ids))
    pose = np.array(camera.world_T_camera)
    return Cloud(
        points=transformed(pose, unproject(geometry.Z, camera.K)[shown]),
        normals=geometry.normal[shown].astype(np.float64) @ pose[:3, :3].T,
        colours=picture[shown],
        ids=geometry.id[shown],
    )


def joined_clouds(clouds: list[Cloud]) -> Cloud:
    """Return the points of several clouds as one."""
    fields = ("points", "normals", "colours", "ids")
    return Cloud(**{field: np.concatenate([getattr(cloud, field) for cloud in clouds]) for field in fields})


def thinned(cloud: Cloud, most: int) -> Cloud:
    """Return at most so many points of a cloud, evenly spaced in its order."""
    step = max(1, -(-len(cloud.ids) // most))
    return Cloud(cloud.points[::step], cloud.normals[::step], cloud.colours[::step], cloud.ids[::step])


def write_cloud(path: Path, cloud: Cloud) -> None:
    """Write a binary PLY file of vertices `VERTEX`."""
    with cloud_file(path) as add:
        add(cloud)


@contextmanager
def cloud_file(path: Path) -> Iterator[Callable[[Cloud], None]]:
    """Yield what adds clouds to a binary PLY file, so that not all of them are in memory at once."""
    count = 0
    with path.open("wb") as file:
        file.write(_header(count))

        def add(cloud: Cloud) -> None:
            nonlocal count
            count += len(cloud.ids)
            file.write(_rows(cloud).tobytes())

        yield add
        file.seek(0)
        file.write(_header(count))


def _header(count: int) -> bytes:
    """Return the header, of the same length for every number of points."""
    properties = [f"property {_PLY_TYPES[VERTEX[name].str]} {name}" for name in VERTEX.names or ()]
    comment = f"comment world frame, metres; id: instance ids of {layout.OBJECTS}, 1 the table"
    comment += "." * (_COUNT_DIGITS - len(str(count)))
    lines = ["ply", "format binary_little_endian 1.0", comment, f"element vertex {count}", *properties, "end_header"]
    return "\n".join(lines).encode() + b"\n"


def _rows(cloud: Cloud) -> np.ndarray:
    rows = np.zeros(len(cloud.ids), VERTEX)
    for names, values in (("x y z", cloud.points), ("nx ny nz", cloud.normals), ("red green blue", cloud.colours)):
        for column, name in enumerate(names.split()):
            rows[name] = values[:, column]
    rows["id"] = cloud.ids
    return rows
