"""Points of a view's surfaces with colours, normals and ids, and their PLY files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from ....annotate.projection import pixel_rays, transformed
from ....core.errors import InputError
from ...format import layout
from ...reader import StoredView

#: A vertex of our PLY files; MeshLab, CloudCompare, Open3D and trimesh know all of these names but `id` and `layer`,
#: which they keep as scalar fields or ignore.
VERTEX = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    + [(name, "u1") for name in ("red", "green", "blue")]
    + [("id", "<u2"), ("layer", "u1")]
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
    layers: np.ndarray  #: (n,) uint8, surfaces in front on the same ray


def cloud_of(view: StoredView, ids: frozenset[int] | None = None, layers: bool = False) -> Cloud:
    """Return the surfaces along the straight rays through the left camera's pixels, row by row.

    Parameters
    ----------
    view : StoredView
        The view.
    ids : set of int, optional
        Only points of these instances; all by default.
    layers : bool
        Every stored surface along the rays, the first of all pixels first, instead of the first alone.

    Raises
    ------
    InputError
        For damaged files, or with `layers` where the data set was made without them.
    """
    camera, picture = view.camera(), view.picture()
    if layers:
        every = view.layers()
        depths, normals, instances = every.Z, every.normal, every.id
    else:
        geometry = view.geometry()
        depths, normals, instances = geometry.Z[None], geometry.normal[None], geometry.id[None]
    if picture.shape[:2] != depths.shape[1:]:
        raise InputError(view.folder / "left.png", f"a picture of {depths.shape[1:]} px", picture.shape[:2])
    shown = np.isfinite(depths)
    if ids is not None:
        shown &= np.isin(instances, list(ids))
    number, row, column = np.nonzero(shown)
    pose, Z = np.array(camera.world_T_camera), depths[shown].astype(np.float64)
    height, width = picture.shape[:2]
    rays = pixel_rays(height, width, camera.K)[row, column]
    return Cloud(
        points=transformed(pose, rays * Z[:, None]),
        normals=normals[shown].astype(np.float64) @ pose[:3, :3].T,
        colours=picture[row, column],
        ids=instances[shown],
        layers=number.astype(np.uint8),
    )


def joined_clouds(clouds: list[Cloud]) -> Cloud:
    """Return the points of several clouds as one."""
    return Cloud(*(np.concatenate([getattr(cloud, field.name) for cloud in clouds]) for field in fields(Cloud)))


def thinned(cloud: Cloud, most: int) -> Cloud:
    """Return at most so many points of a cloud, evenly spaced in its order."""
    step = max(1, -(-len(cloud.ids) // most))
    return Cloud(*(getattr(cloud, field.name)[::step] for field in fields(Cloud)))


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
    rows["id"], rows["layer"] = cloud.ids, cloud.layers
    return rows
