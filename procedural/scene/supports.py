"""Vessels that stand on trays and plates, where everything stands apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from ...core.randomness import stream
from ..cavities.columns import columns_of
from ..description.scene import GlassBody, Prop, SceneObject
from ..placement.placement import CONTACT_GAP, PlacementSettings, apart, footprint

#: Kinds of props that carry vessels as they are used, and how many at most [1].
CARRIERS = {"tray": 4, "plate": 1}
#: Distance of the lines along which a top is known, how much it may rise and still be flat, and how far a foot stays
#: away from where it rises [m].
_PITCH, _FLAT, _MARGIN = 1e-3, 2e-4, 2e-3
#: Places that are tried for each vessel on each carrier [1].
_TRIES = 40


@dataclass(frozen=True, eq=False)
class _Top:
    """The flat part of a top, as a grid of vertical lines meets it."""

    origin: np.ndarray  #: (2,) place of the first line [m]
    free: np.ndarray  #: (x, y) bool, flat and away from where it rises
    height: float  #: of the flat part [m]
    rim: float  #: of its highest place [m]

    def holds(self, places: np.ndarray) -> bool:
        """Return whether all places (k, 2) are over the flat part."""
        cell = np.round((places - self.origin) / _PITCH).astype(int)
        inside = ((cell >= 0) & (cell < self.free.shape)).all(1)
        return bool(inside.all() and self.free[tuple(cell.T)].all())


def put_on_carriers(
    objects: Sequence[SceneObject],
    upright: Sequence[bool],
    meshes: Sequence[Mesh],
    poses: Sequence[np.ndarray],
    settings: PlacementSettings,
    seed: int,
    scene_id: int,
) -> dict[int, int]:
    """Move some vessels onto trays and plates that stand on the table, all still at the origin.

    Parameters
    ----------
    objects : sequence of SceneObject
        The objects of the scene.
    upright : sequence of bool
        Which of them are vessels that stand.
    meshes : sequence of Mesh
        Each object with what goes with it, object frame.
    poses : sequence of (4, 4) float64
        Turned as they will stand, the lowest point at z = 0; those of vessels that are carried are changed.
    settings : PlacementSettings
        How often.
    seed, scene_id : int, int
        Of the scene.

    Returns
    -------
    dict of int to int
        From the number of a vessel to that of its carrier.
    """
    carriers = [number for number, item in enumerate(objects) if _carries(item, poses[number])]
    if not carriers:
        return {}
    tops = {number: _top_of(meshes[number], poses[number]) for number in carriers}
    found: dict[int, int] = {}
    outlines: dict[int, list[np.ndarray]] = {number: [] for number in carriers}
    for number, item in enumerate(objects):
        rng = stream(seed, scene_id, f"support/{item.name}")
        if not (isinstance(item, GlassBody) and upright[number]) or rng.random() >= settings.carried_probability:
            continue
        for carrier in rng.permutation(carriers).tolist():
            top, others = tops[carrier], outlines[carrier]
            if top is None or len(others) >= CARRIERS[objects[carrier].category]:
                continue
            outline = _placed(meshes[number], poses[number], top, others, settings.gap, rng)
            if outline is not None:
                others.append(outline)
                found[number] = carrier
                break
    return found


def _carries(item: SceneObject, pose: np.ndarray) -> bool:
    """Return whether an object is a carrier that stands as it is used."""
    return isinstance(item, Prop) and item.origin is None and item.category in CARRIERS and pose[2, 2] > 1.0 - 1e-9


def _top_of(mesh: Mesh, pose: np.ndarray) -> _Top | None:
    """Return the flat part around the middle of a body's top; None where it has none."""
    from scipy import ndimage  # here, as few scenes need it

    points, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    places = points.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
    columns = columns_of(places, index.reshape(-1)[mesh.faces], _PITCH)
    above = np.isinf(columns.top) & (columns.column >= 0)
    heights = np.full(columns.shape, np.nan)
    heights.reshape(-1)[columns.column[above]] = columns.bottom[above]
    middle = tuple((np.array(columns.shape) // 2).tolist())
    height = float(heights[middle])
    with np.errstate(invalid="ignore"):
        label, _ = ndimage.label(np.abs(heights - height) < _FLAT)
    if not np.isfinite(height) or label[middle] == 0:
        return None
    free = ndimage.binary_erosion(label == label[middle], iterations=round(_MARGIN / _PITCH))
    return _Top(columns.origin, free, float(heights[free].max()), float(places[:, 2].max())) if free.any() else None


def _placed(
    mesh: Mesh, pose: np.ndarray, top: _Top, others: Sequence[np.ndarray], gap: float, rng: np.random.Generator
) -> np.ndarray | None:
    """Put an object somewhere on a top, apart from others there, and return its outline; None where it has no room."""
    points = mesh.vertices.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
    low = points[points[:, 2] < top.rim - top.height + _MARGIN]  # what is higher may reach over the rim
    foot = _dense(footprint(Mesh("foot", low, np.zeros((0, 3), int)), np.eye(4)))
    outline, cells = footprint(mesh, pose), np.argwhere(top.free)
    for _ in range(_TRIES):
        shift = top.origin + _PITCH * cells[int(rng.integers(len(cells)))] - outline.mean(0)
        if top.holds(foot + shift) and all(apart(outline + shift, other, gap) for other in others):
            pose[:3, 3] += [*shift, top.height + CONTACT_GAP]
            return outline + shift
    return None


def _dense(outline: np.ndarray) -> np.ndarray:
    """Return points on the sides of a polygon, as near to each other as the lines of a top."""
    along = np.roll(outline, -1, axis=0) - outline
    counts = np.maximum(np.ceil(np.hypot(*along.T) / _PITCH).astype(int), 1)
    side = np.repeat(np.arange(len(outline)), counts)
    part = (np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[side]
    return outline[side] + part[:, None] * along[side]
