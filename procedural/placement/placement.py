"""Where objects stand: resting on the table, apart from each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.model import Model
from ...core.units import Length

#: Height of every object over the table [m]. Dry glass on wood is separated by roughness and dust: air, not optical
#: contact, lies between them. A tenth of a millimetre is far above the renderer's ray offset (1e-6 m) and far below
#: what a picture or a label shows.
CONTACT_GAP = 1e-4
#: Attempts to place one object before the disc grows, and factor of its growth.
_TRIES, _GROWTH = 60, 1.15
#: Restarts of the whole placement before the objects are said not to fit.
_RESTARTS = 20


class PlacementSettings(Model):
    """How objects are distributed over the table."""

    radius: Length = Field(
        default=0.16,
        gt=0.0,
        le=2.0,
        description="Objects are centred in a disc of this radius [m]; it grows if they do not fit",
    )
    gap: Length = Field(
        default=0.005, ge=0.001, le=0.2, description="Smallest distance between two objects, seen from above [m]"
    )
    carried_probability: float = Field(
        default=0.5,
        ge=0.0,
        le=1.0,
        description="Probability that a vessel that stands is on a tray or a plate of the scene, where one has room "
        "for it and nothing piles",
    )
    edge: Length = Field(default=0.03, ge=0.0, le=0.5, description="Smallest distance to the edge of the table [m]")


def footprint(mesh: Mesh, pose: np.ndarray) -> np.ndarray:
    """Return the convex outline seen from above, (k, 2) float64, counter-clockwise [m]."""
    from scipy.spatial import ConvexHull  # here, as it takes a third of a second to load

    points = mesh.vertices.astype(np.float64) @ pose[:2, :3].T + pose[:2, 3]
    return points[ConvexHull(points).vertices]


def apart(a: np.ndarray, b: np.ndarray, gap: float) -> bool:
    """Return whether a strip of width `gap` separates two convex polygons (separating axis over their edges)."""
    for polygon in (a, b):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        along_a, along_b = a @ normals.T, b @ normals.T
        clear = np.maximum(along_b.min(0) - along_a.max(0), along_a.min(0) - along_b.max(0))
        if (clear >= gap).any():
            return True
    return False


def draw_positions(
    footprints: Sequence[np.ndarray], board: np.ndarray, settings: PlacementSettings, rng: np.random.Generator
) -> np.ndarray:
    """Draw a position for each footprint so that all lie on the board, apart from each other.

    Parameters
    ----------
    footprints : sequence of (k, 2) float
        Convex outlines about each object's own origin [m].
    board : (m, 2) float
        Convex outline of the table's top [m].
    settings : PlacementSettings
        Disc, gap and edge.
    rng : numpy.random.Generator
        Draws positions.

    Returns
    -------
    (n, 2) float64
        Shift of each footprint [m].

    Raises
    ------
    InputError
        If the objects do not fit on the table.
    """
    shifts = find_positions(footprints, board, settings, rng)
    if shifts is None:
        raise crowded(len(footprints), board)
    return shifts


def crowded(count: int, board: np.ndarray) -> InputError:
    """Return the error of a number of objects that do not fit on the table, whose outline is (m, 2) [m]."""
    width, depth = np.ptp(board, axis=0)
    expected = f"objects that fit on the table of {width:.2f} x {depth:.2f} m"
    return InputError("vessel_count, prop_count", expected, f"{count} that do not")


def find_positions(
    footprints: Sequence[np.ndarray], board: np.ndarray, settings: PlacementSettings, rng: np.random.Generator
) -> np.ndarray | None:
    """Return what `draw_positions` returns, or None where the objects do not fit on the table."""
    order = sorted(range(len(footprints)), key=lambda i: -np.ptp(footprints[i], axis=0).max())
    for _ in range(_RESTARTS):
        shifts = _attempt(footprints, order, board, settings, rng)
        if shifts is not None:
            return shifts
    return None


def _attempt(
    footprints: Sequence[np.ndarray],
    order: Sequence[int],
    board: np.ndarray,
    settings: PlacementSettings,
    rng: np.random.Generator,
) -> np.ndarray | None:
    """Place the footprints one after another; None where the disc outgrows the board."""
    placed: dict[int, np.ndarray] = {}
    shifts = np.zeros((len(footprints), 2))
    radius, limit = settings.radius, float(np.linalg.norm(board, axis=1).max())
    for index in order:
        while index not in placed:
            if radius > limit:
                return None
            for _ in range(_TRIES):
                angle, distance = rng.uniform(0.0, 2.0 * np.pi), radius * np.sqrt(rng.uniform())
                shifts[index] = distance * np.array([np.cos(angle), np.sin(angle)])
                outline = footprints[index] + shifts[index]
                if inside(outline, board, settings.edge) and all(
                    apart(outline, b, settings.gap) for b in placed.values()
                ):
                    placed[index] = outline
                    break
            else:
                radius *= _GROWTH
    return shifts


def inside(outline: np.ndarray, board: np.ndarray, edge: float) -> bool:
    """Return whether a convex polygon lies in another one, at least a distance [m] from its sides."""
    sides = np.roll(board, -1, axis=0) - board
    normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    depth = (outline @ normals.T) - (board * normals).sum(1)
    return bool((depth >= edge).all())
