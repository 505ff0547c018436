"""The vessel that a part goes with: radii, heights and points of its outside, in its object frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..description.bodies import GlassBody, Vessel
from ..profiles.curve import Curve
from ..profiles.liquid import brimful_volume, level_of_volume
from ..shaped_vessels.build import ShapedGlass
from ..shaped_vessels.forms import Form, round_form
from ..shaped_vessels.loft import surface

#: Heights at which a host's outside is known [1].
_HEIGHTS = 1024
#: Part of the wall that the inside of a shaped vessel may lie further in than its thickness says [1]: unevenness.
_UNEVEN = 0.3


@dataclass(frozen=True, eq=False)
class Host:
    """A vessel as its parts see it.

    Parameters
    ----------
    body : GlassBody
        The vessel.
    form : Form
        Cross-sections of its outside.
    curve : Curve
        Its half section's outside, in the frame in which it was drawn [m].
    first : int
        The curve's point where the wall begins.
    matrix, centre : (3, 3) and (3,) float64
        Take a drawn point p to ``matrix p - centre`` in the object frame.
    fold : int
        Turns about z that leave the vessel unchanged; 0 for all.
    level_of : callable
        The level of a volume [m^3], object frame [m].
    brimful : float
        Volume [m^3].
    bore : callable
        Largest radius that fits into it at a height of the object frame [m].
    """

    body: GlassBody
    form: Form
    curve: Curve
    first: int
    matrix: np.ndarray
    centre: np.ndarray
    fold: int
    level_of: Callable[[float], float]
    brimful: float
    bore: Callable[[float], float]

    @property
    def rim(self) -> float:
        """Height of its highest point, object frame [m]."""
        return 0.5 * float(self.body.size[2])

    @property
    def axis_at_rim(self) -> np.ndarray:
        """Where its axis is at the rim, (2,) in the object frame [m]."""
        top = float(self.curve.points[-1, 1])
        return (self.matrix @ np.array([0.0, 0.0, top]) - self.centre)[:2]

    def radius(self, z: np.ndarray) -> np.ndarray:
        """Return the half section's outer radius at heights of the object frame [m]."""
        wall = self.curve.points[self.first :]
        return np.interp(z + self.centre[2], wall[:, 1], wall[:, 0])

    def widest(self, low: float) -> float:
        """Return the largest distance of the glass from the axis at the rim, above a height of the object frame [m].

        A flaring wall's rim is rounded: its crown stands out beyond the half section's end.
        """
        glass = [part.mesh.vertices for part in self.body.interfaces if part.part in ("outside", "wet_wall")]
        points = np.concatenate(glass).astype(np.float64)
        beside = points[points[:, 2] >= low, :2] - self.axis_at_rim
        return float(np.hypot(beside[:, 0], beside[:, 1]).max())

    def points(self, u: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points and normals of the outside at places around [turns] and heights of the object frame [m]."""
        wall = self.curve.points[self.first :, 1]
        s = self.first + np.interp(z + self.centre[2], wall, np.arange(len(wall)))
        points, normals = surface(self.form, self.curve, u, s)
        normals = normals @ np.linalg.inv(self.matrix)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        return points @ self.matrix.T - self.centre, normals

    def straight(self, slope: float) -> tuple[float, float]:
        """Return the longest range of heights in which the outside is straight, object frame [m]."""
        z = np.linspace(self.curve.points[self.first, 1], self.curve.points[-1, 1], _HEIGHTS)
        radius = np.interp(z, *self.curve.points[self.first :, ::-1].T)
        flat = np.abs(np.gradient(radius, z)) <= slope
        edges = np.flatnonzero(np.diff(np.concatenate([[False], flat, [False]]).astype(int))).reshape(-1, 2)
        if not len(edges):
            return 0.0, 0.0
        start, stop = edges[int(np.argmax(edges[:, 1] - edges[:, 0]))]
        return float(z[start] - self.centre[2]), float(z[stop - 1] - self.centre[2])


def host_of_revolution(vessel: Vessel) -> Host:
    """Return a vessel of revolution as a host."""
    outer, inner = np.array(vessel.outer), np.array(vessel.inner)
    lowest = int(np.flatnonzero(outer[:, 1] <= outer[:, 1].min() + 1e-9)[-1])
    along = np.gradient(outer, axis=0)
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    rising = np.maximum.accumulate(inner[:, 1])

    def bore(z: float) -> float:
        return float(np.interp(z, rising, inner[:, 0]))

    return Host(
        body=vessel,
        form=round_form(96),
        curve=Curve(outer, normals),
        first=lowest,
        matrix=np.eye(3),
        centre=np.zeros(3),
        fold=0,
        level_of=lambda volume: level_of_volume(inner, volume),
        brimful=brimful_volume(inner),
        bore=bore,
    )


def host_of_shape(body: GlassBody, made: ShapedGlass) -> Host:
    """Return a shaped vessel as a host."""
    outside, cavity = made.outside, made.cavity
    wall = outside.section.curve.points[outside.section.side :]

    def bore(z: float) -> float:
        radius = float(np.interp(z + outside.centre[2], wall[:, 1], wall[:, 0]))
        return radius - (1.0 + _UNEVEN) * made.wall

    return Host(
        body=body,
        form=outside.form,
        curve=outside.section.curve,
        first=outside.section.side,
        matrix=outside.matrix,
        centre=outside.centre,
        fold=made.fold,
        level_of=cavity.level_of,
        brimful=made.brimful,
        bore=bore,
    )
