"""Shapes of tables that are no plain boards: a cloth that hangs over the edge, a steel counter with a sink."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ..props.normals import creased
from ..things.solids import finished, rounded_rectangle

#: How far a cloth hangs down [m] (a quarter of a metre is customary), its thickness, and its roundness at the edge.
DROP, CLOTH, BEND = (0.16, 0.30), 0.0009, 0.006
#: Folds of a hanging cloth per metre [1/m], how far they swing out at the hem over the drop, and its flare [1].
FOLDS, SWING, FLARE = (3.0, 7.0), (0.05, 0.11), (0.03, 0.09)
#: Distance of points along a hem [m]: a twelfth of the narrowest fold.
POINTS = 0.016
#: Sink: length, width and depth of the basin [m] (EN 13310 basins of 340 x 400 x 160 mm are common), radius of its
#: corners, how much lower the steel around it lies, and the width of that strip.
BASIN, BASIN_RADIUS, SUNK, STRIP = (0.34, 0.40, 0.16), 0.045, 0.004, 0.06
#: Shortest counter with a sink: a work surface of 0.9 m beside it [m].
SHORTEST = 1.4
#: Height of a counter's edge [m].
EDGE = 0.04


def hanging_cloth(rng: np.random.Generator, size: tuple[float, float]) -> tuple[Mesh, tuple[float, float, float]]:
    """Return a cloth on a board and over its edges, a closed shell with its top at z = 0, and its extent [m].

    Texture coordinates are (x, y) on the top and go on down the sides, as the cloth does.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws drop and folds.
    size : (float, float)
        Length and width of the board [m].
    """
    drop, flare = rng.uniform(*DROP), rng.uniform(*FLARE)
    corner = 0.03
    edge = rounded_rectangle(size[0] - 2 * BEND, size[1] - 2 * BEND, corner, 6)
    outline, outward, along, near_corner = _resampled(edge, corner)
    wave = _folds(rng, along)
    swing = rng.uniform(*SWING) * drop * (0.5 + 0.5 * np.abs(wave)) * wave
    # The corners of a square cloth hang lower and stand out.
    length = drop * (1.0 + 0.36 * near_corner)
    out = (flare + 0.30 * near_corner) * drop
    bend = np.linspace(0.0, np.pi / 2, 5)
    down = np.linspace(0.0, 1.0, 11)[1:]
    rings, unrolled = [], []
    for angle in bend:
        rings.append((np.full(len(outline), BEND * np.sin(angle)), np.full(len(outline), BEND * (np.cos(angle) - 1))))
        unrolled.append(np.full(len(outline), BEND * angle))
    for t in down:
        eased = t * t * (3 - 2 * t) * 0.5 + 0.5 * t
        rings.append((BEND + eased * (out + swing), -BEND - t * (length - BEND)))
        unrolled.append(BEND * np.pi / 2 + t * length)
    return _shell(outline, outward, rings, unrolled)


def _resampled(edge: np.ndarray, corner: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return points `POINTS` apart on an outline, outward normals, lengths along it [0, 1], nearness to a corner."""
    closed = np.concatenate([edge, edge[:1]])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    count = int(lengths[-1] / POINTS)
    along = np.arange(count) * lengths[-1] / count
    points = np.stack([np.interp(along, lengths, closed[:, axis]) for axis in range(2)], 1)
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    outward = np.stack([tangent[:, 1], -tangent[:, 0]], 1) / np.linalg.norm(tangent, axis=1, keepdims=True)
    half = np.abs(points).max(0)
    distance = np.linalg.norm(half - np.abs(points), axis=1)
    return points, outward, along / lengths[-1], np.exp(-((distance / (0.09 + corner)) ** 2))


def _folds(rng: np.random.Generator, along: np.ndarray) -> np.ndarray:
    """Return the swing of folds around the table, periodic, in about [-1, 1]: waves of uneven width and height."""
    count = int(rng.uniform(*FOLDS) * 4)
    phase = 2 * np.pi * along
    drift = sum(rng.normal(0.0, 0.9 / k) * np.sin(k * phase + rng.uniform(0, 6.28)) for k in (1, 2, 3))
    height = 0.65 + 0.35 * np.sin(int(rng.integers(2, 6)) * phase + rng.uniform(0, 6.28))
    fine = 0.3 * np.sin((2 * count + 1) * phase + 1.7 * drift)
    return height * (np.sin(count * phase + 2.0 * drift) + fine) / 1.3


def _shell(
    outline: np.ndarray, outward: np.ndarray, rings: list, unrolled: list
) -> tuple[Mesh, tuple[float, float, float]]:
    """Return the shell over rings of (distance outwards, height), the underside a cloth's thickness inside."""
    outer = [np.column_stack([outline + outward * out[:, None], z]) for out, z in rings]
    inner = [np.column_stack([outline + outward * (out - CLOTH)[:, None], np.minimum(z, -CLOTH)]) for out, z in rings]
    flat = [outline + outward * length[:, None] for length in unrolled]
    every, coordinates = [*outer, *inner[::-1]], [*flat, *flat[::-1]]
    count, sides = len(every), len(outline)
    # Seen from above the outline is counter-clockwise, and the rings go down: faces are turned against a loft's.
    i = (np.arange(count - 1)[:, None] * sides + np.arange(sides)).reshape(-1)
    after = (np.arange(count - 1)[:, None] * sides + (np.arange(sides) + 1) % sides).reshape(-1)
    faces = [np.stack([i, i + sides, after + sides], 1), np.stack([i, after + sides, after], 1)]
    index, ahead, last = np.arange(sides), (np.arange(sides) + 1) % sides, (count - 1) * sides
    faces.append(np.stack([index, ahead, np.full(sides, count * sides)], 1))
    faces.append(np.stack([ahead + last, index + last, np.full(sides, count * sides + 1)], 1))
    vertices = np.concatenate([*every, [[0.0, 0.0, 0.0], [0.0, 0.0, -CLOTH]]])
    uv = np.concatenate([*coordinates, [[0.0, 0.0], [0.0, 0.0]]])
    low, high = vertices.min(0), vertices.max(0)
    vertices[:, :2] -= (low[:2] + high[:2]) / 2
    points, triangles, normals, uv = creased(vertices.astype(np.float32).astype(float), np.concatenate(faces), uv)
    mesh = Mesh("table", points, triangles, normals, uv)
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return mesh, (x, y, z)


def over_edges(mesh: Mesh, size: tuple[float, float, float]) -> Mesh:
    """Return a rectangular board whose pattern goes on down its sides, as boards and tiles do.

    Parameters
    ----------
    mesh : Mesh
        A board of `blocks.rounded_box`, with coordinates from the middle of each of its six faces [m].
    size : (x, y, z)
        Its extent [m].
    """
    assert mesh.uv is not None
    uv = mesh.uv.reshape(6, -1, 2).copy()
    along, across = (0.5 * (side + size[2]) for side in size[:2])
    # In the order of `rounded_box`: +x (y, z), -x (z, y), +y (z, x), -y (x, z).
    uv[0] = np.stack([along - uv[0, :, 1], uv[0, :, 0]], 1)
    uv[1] = np.stack([uv[1, :, 0] - along, uv[1, :, 1]], 1)
    uv[2] = np.stack([uv[2, :, 1], across - uv[2, :, 0]], 1)
    uv[3] = np.stack([uv[3, :, 0], uv[3, :, 1] - across], 1)
    return Mesh(mesh.name, mesh.vertices, mesh.faces, mesh.normals, uv.reshape(-1, 2))


def steel_counter(rng: np.random.Generator, size: tuple[float, float]) -> tuple[Mesh, tuple[float, float, float]]:
    """Return a steel counter, its work surface at z = 0, with a sink at one end; and its extent [m].

    The steel around the basin lies lower, so that what runs off stays there; nothing stands on it.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws the end of the sink.
    size : (float, float)
        Length and width [m].
    """
    import manifold3d

    length, width = max(size[0], SHORTEST), max(size[1], BASIN[1] + 2 * STRIP + 0.05)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    sunk = BASIN[0] + 2 * STRIP
    middle = sign * (length / 2 - sunk / 2)
    board = manifold3d.CrossSection([rounded_rectangle(length, width, 0.008, 4)]).extrude(EDGE).translate((0, 0, -EDGE))
    low = manifold3d.Manifold.cube((sunk + 0.2, 2 * width, 0.02), True)
    low = low.translate((middle + 0.1 * sign, 0.0, 0.01 - SUNK))
    outside = manifold3d.CrossSection([rounded_rectangle(BASIN[0] + 0.004, BASIN[1] + 0.004, BASIN_RADIUS, 6)])
    inside = manifold3d.CrossSection([rounded_rectangle(BASIN[0], BASIN[1], BASIN_RADIUS, 6)])
    tub = outside.extrude(BASIN[2]).translate((middle, 0.0, -BASIN[2] - 0.002))
    # Tapered, so that its floor is smaller than its opening.
    cut = inside.extrude(BASIN[2], 0, 0.0, (1.06, 1.06)).translate((middle, 0.0, -BASIN[2]))
    drain = manifold3d.Manifold.cylinder(0.006, 0.045, 0.05, 40).translate((middle, 0.0, -BASIN[2] - 0.001))
    made = ((board - low) + tub) - cut - drain
    found = made.to_mesh()
    vertices = np.asarray(found.vert_properties, float)[:, :3]
    # What is on the work surface but for rounding is on it exactly.
    vertices[np.abs(vertices[:, 2]) < 1e-7, 2] = 0.0
    mesh = finished(vertices, np.asarray(found.tri_verts, np.int64), crease=np.radians(35.0))
    mesh = Mesh("table", mesh.vertices, mesh.faces, mesh.normals, mesh.uv)
    x, y, z = (float(side) for side in np.ptp(mesh.bounds, axis=0))
    return mesh, (x, y, z)
