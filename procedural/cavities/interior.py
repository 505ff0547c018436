"""What a solid is inside: its cavities, the volume of each, and the thickness of the wall around them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from ...core.mesh import Mesh
from .columns import PITCH_PER_WIDTH, Columns, columns_of, pitch_for, solid_runs
from .cut import Filling, Parts, clear_level, cut, touched_faces, welded
from .domes import Dome
from .find import Hollow, hollows
from .sections import WALL_TOP, Wall, wall_of
from .wall import THINNEST, thicknesses

#: Least distance of a liquid's surface below the brim [m], and the fraction of the depth that it may be at most [1]:
#: below the rounding of most rims, as in vessels that are drawn.
BRIM_MARGIN, MOST_MARGIN = 2.5e-3, 0.1
#: Quantile of the pieces of horizontal lines in the solid that counts as the wall [1], to choose how far lines are
#: apart.
_THIN_RUN = 0.05
#: Near the brim the wall is rounded off: it is measured this fraction of the depth below it [1].
_RIM_PART = 0.15
#: Interiors that are remembered [1]: scenes have up to 24 vessels.
_REMEMBERED = 32


@dataclass(frozen=True, eq=False)
class Interior:
    """The cavities of a solid.

    Parameters
    ----------
    columns : Columns
        Free space along vertical lines.
    hollows : tuple of Hollow
        The largest first.
    walls : tuple of Wall
        The wall around each of them.
    wall : float or None
        Smallest thickness of the wall around the cavities [m]; None without cavities.
    """

    columns: Columns
    hollows: tuple[Hollow, ...]
    walls: tuple[Wall, ...]
    wall: float | None

    @property
    def volume(self) -> float:
        """Volume that all cavities hold up to their brims [m^3]."""
        return sum(hollow.volume for hollow in self.hollows)


@lru_cache(_REMEMBERED)
def interior_of(solid: Mesh) -> Interior:
    """Return the cavities of a closed solid as it stands, z up."""
    places, index = welded(solid)
    faces = index[solid.faces]
    columns = columns_of(places, faces, pitch_for(places, _thin(places, faces)))
    near = {hollow: _near(places, faces, columns, hollow) for hollow in hollows(columns)}
    # Where a wall is thinner than lines can tell, a part of the outside may look like a cavity: it has no wall.
    near = {hollow: some for hollow, some in near.items() if some.any()}
    corners = places[faces]
    walls = tuple(wall_of(corners[some], hollow) for hollow, some in near.items())
    return Interior(columns, tuple(near), walls, _thickness(corners, near) if near else None)


def _near(places: np.ndarray, faces: np.ndarray, columns: Columns, hollow: Hollow) -> np.ndarray:
    """Return the faces around a cavity, (m,) bool."""
    return touched_faces(faces, places[:, 2], columns, hollow, hollow.floor + WALL_TOP * (hollow.brim - hollow.floor))


def _thin(places: np.ndarray, faces: np.ndarray) -> float:
    """Return how long horizontal lines are in the solid where it is thin [m]."""
    runs = []
    for axes in ([1, 2, 0], [2, 0, 1]):
        turned = places[:, axes]
        pitch = PITCH_PER_WIDTH * float(np.ptp(turned[:, :2], axis=0).max())
        runs.append(solid_runs(turned, faces, pitch))
    lengths = np.concatenate(runs)
    return float(np.quantile(lengths, _THIN_RUN)) if len(lengths) else 0.0


def _thickness(corners: np.ndarray, walls: Mapping[Hollow, np.ndarray]) -> float:
    """Return the smallest thickness of the wall around cavities [m]."""
    near = np.logical_or.reduce(list(walls.values()))
    top = corners[..., 2].max(1)
    deep = [wall & (top < one.brim - _RIM_PART * (one.brim - one.floor)) for one, wall in walls.items()]
    inner = np.logical_or.reduce(deep)
    # Faces may be as long as the wall is high.
    distances = thicknesses(corners, inner if inner.any() else near, ~near)
    return float(np.quantile(distances, THINNEST))


def most_level(hollow: Hollow) -> float:
    """Return the highest level of a liquid in a cavity [m]."""
    return hollow.brim - min(BRIM_MARGIN, MOST_MARGIN * (hollow.brim - hollow.floor))


def most_volume(interior: Interior) -> float:
    """Return the largest volume that the cavities hold together, each as full as the others [m^3]."""
    fractions = [hollow.volume_below(most_level(hollow)) / hollow.volume for hollow in interior.hollows]
    return min(fractions) * interior.volume if fractions else 0.0


def filled(
    solid: Mesh,
    interior: Interior,
    volume: float,
    names: tuple[str, str, str],
    curved: Callable[[Wall, float], Dome | None] | None = None,
) -> tuple[Parts, tuple[Filling, ...]]:
    """Return a solid's surface cut for a volume of liquid, and the liquid of each cavity, the largest first.

    Every cavity gets the same fraction of what it holds.

    Parameters
    ----------
    solid : Mesh
        The closed solid.
    interior : Interior
        Its own (`interior_of`).
    volume : float
        Volume of the liquid [m^3], at most `most_volume`.
    names : (str, str, str)
        Names of the outside, the wet wall and the liquid's surface.
    curved : callable, optional
        Gives the surface of a volume [m^3] inside a wall, or None for a flat one; by default all are flat.

    Raises
    ------
    ValueError
        Where a level does not cut the wall in closed lines.
    """
    heights = welded(solid)[0][:, 2]
    fraction = volume / interior.volume
    fillings = tuple(
        _filling(hollow, fraction * hollow.volume, heights, curved and curved(wall, fraction * hollow.volume))
        for hollow, wall in zip(interior.hollows, interior.walls, strict=True)
    )
    return cut(solid, interior.columns, fillings, names), fillings


def flat_level(hollow: Hollow, volume: float) -> float:
    """Return the level of a flat surface above a volume [m^3] in a cavity [m]."""
    return float(brentq(lambda z: hollow.volume_below(z) - volume, hollow.floor, hollow.brim, xtol=1e-9))


def _filling(hollow: Hollow, volume: float, heights: np.ndarray, dome: Dome | None) -> Filling:
    if dome is None:
        return Filling(hollow, clear_level(heights, flat_level(hollow, volume)))
    wanted = float(dome.points[-1, 1])
    level = clear_level(heights, wanted)
    points = dome.points + np.array([0.0, level - wanted])
    return Filling(hollow, level, Dome(dome.centre, points, dome.normals))
