"""Thin opaque patches that follow a vessel's outside: labels of cells with colours of their own, and bars of print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from .attach import CONTACT
from .host import Host

#: Thickness of a label and of a fired enamel print [m]: paper of 80 g/m^2 is 0.1 mm.
PAPER, ENAMEL = 1e-4, 5e-5


@dataclass(frozen=True)
class Area:
    """A part of the outside: places around [turns], which may pass 1, and heights of the object frame [m]."""

    start: float
    end: float
    low: float
    high: float


def label_mesh(host: Host, area: Area, cells: np.ndarray, back: np.ndarray) -> Mesh:
    """Return a closed patch whose front has cells of one colour each.

    Parameters
    ----------
    host : Host
        The vessel.
    area : Area
        Where it is.
    cells : (rows, columns, 3) float
        Reflectances, the first row at the lower edge, columns counter-clockwise seen from above.
    back : (3,) float
        Reflectance of the back, which glass shows.
    """
    rows, columns = cells.shape[:2]
    front, normals = _sheet(host, area, rows, columns, CONTACT + PAPER)
    behind, _ = _sheet(host, area, rows, columns, CONTACT)
    # A full turn ends where it began.
    wrapped = area.end - area.start >= 1.0
    if wrapped:
        for grid in (front, behind, normals):
            grid[:, -1] = grid[:, 0]
    quads, facing = _quads(front), _quads(normals)
    others = [_quads(behind)[:, ::-1], *_edges(front, behind, wrapped)]
    corners = np.concatenate([quads, *others])
    directions = np.concatenate([facing, *[_flat(some) for some in others]])
    colours = np.concatenate([cells.reshape(-1, 3), np.tile(back, (len(corners) - len(quads), 1))])
    return _of_quads("label", corners, directions, np.repeat(colours[:, None], 4, axis=1))


def bars_mesh(host: Host, areas: Sequence[Area]) -> Mesh:
    """Return one mesh of closed thin bars, each an area of the outside."""
    corners, directions = [], []
    for area in areas:
        wrapped = area.end - area.start >= 1.0
        around = 2.0 * np.pi * float(host.radius(np.array(area.low))) * (area.end - area.start)
        columns = max(1, int(np.ceil(around / 0.0015)))
        columns = max(columns, 96) if wrapped else columns
        front, normals = _sheet(host, area, 1, columns, CONTACT + ENAMEL)
        behind, _ = _sheet(host, area, 1, columns, CONTACT)
        if wrapped:
            for grid in (front, behind, normals):
                grid[:, -1] = grid[:, 0]
        others = [_quads(behind)[:, ::-1], *_edges(front, behind, wrapped)]
        corners += [_quads(front), *others]
        directions += [_quads(normals), *[_flat(some) for some in others]]
    return _of_quads("print", np.concatenate(corners), np.concatenate(directions), None)


def _sheet(host: Host, area: Area, rows: int, columns: int, off: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (rows + 1, columns + 1, 3) at a distance off the outside [m], and its normals."""
    u = np.linspace(area.start, area.end, columns + 1)[None]
    z = np.linspace(area.low, area.high, rows + 1)[:, None]
    points, normals = host.points(*np.broadcast_arrays(u, z))
    return points + off * normals, normals


def _quads(grid: np.ndarray) -> np.ndarray:
    """Return the corners of a grid's cells, counter-clockwise seen from outside, (k, 4, 3)."""
    cells = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
    return np.stack(cells, axis=2).reshape(-1, 4, 3)


def _edges(front: np.ndarray, behind: np.ndarray, wrapped: bool) -> list[np.ndarray]:
    """Return the quads that join the edges of two sheets, looking outwards."""
    bottom = np.stack([behind[0, :-1], behind[0, 1:], front[0, 1:], front[0, :-1]], axis=1)
    top = np.stack([front[-1, :-1], front[-1, 1:], behind[-1, 1:], behind[-1, :-1]], axis=1)
    if wrapped:
        return [bottom, top]
    start = np.stack([behind[:-1, 0], front[:-1, 0], front[1:, 0], behind[1:, 0]], axis=1)
    end = np.stack([front[:-1, -1], behind[:-1, -1], behind[1:, -1], front[1:, -1]], axis=1)
    return [bottom, top, start, end]


def _flat(quads: np.ndarray) -> np.ndarray:
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    return np.repeat(normal[:, None], 4, axis=1)


def _of_quads(name: str, corners: np.ndarray, normals: np.ndarray, colours: np.ndarray | None) -> Mesh:
    count = len(corners)
    first = 4 * np.arange(count)[:, None]
    faces = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]], axis=1).reshape(-1, 3)
    flat = None if colours is None else colours.reshape(-1, 3)
    return Mesh(name, corners.reshape(-1, 3), faces, normals.reshape(-1, 3), None, flat)
