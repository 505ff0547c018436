"""From the two curves of a section to a vessel: meshes, liquid and record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.model import Profile
from ..description.interfaces import dry_interfaces, wet_interfaces
from ..description.refill import liquid_of
from ..description.scene import Vessel
from ..optics.medium import Medium
from ..profiles.curve import Curve
from ..profiles.liquid import brimful_volume
from ..profiles.liquid_surface import surface_of_volume
from ..profiles.revolve import segments_for
from .wall import Section


@dataclass(frozen=True, eq=False)
class VesselShape:
    """The section of a vessel whose origin is the centre of its bounding box.

    Parameters
    ----------
    outer, inner : Curve
        From the axis to the rim's crown, normals out of the glass (`wall.Section`).
    wall : float
        Smallest thickness of the glass [m].
    """

    outer: Curve
    inner: Curve
    wall: float

    @property
    def brimful(self) -> float:
        """Volume up to the brim [m^3]."""
        return brimful_volume(self.inner.points)


@dataclass(frozen=True)
class Filling:
    """A liquid and how much of it [m^3]."""

    medium: Medium
    volume: float


def vessel_shape(section: Section, wall: float) -> VesselShape:
    """Return a section that stands on z = 0 in the frame whose origin is the centre of its bounding box."""
    lift = np.array([0.0, 0.5 * section.outer.points[-1, 1]])
    outer, inner = (Curve(curve.points - lift, curve.normals) for curve in (section.outer, section.inner))
    return VesselShape(outer, inner, wall)


def build_vessel(
    shape: VesselShape,
    glass: Medium,
    roughness: float,
    filling: Filling | None,
    chord_error: float,
    *,
    id: int,
    name: str,
    category: str,
) -> Vessel:
    """Return a vessel at the origin.

    Parameters
    ----------
    shape : VesselShape
        Its section.
    glass : Medium
        The glass.
    roughness : float
        GGX alpha of the glass.
    filling : Filling, optional
        The liquid in it.
    chord_error : float
        Largest distance of the meshes from the true surfaces [m].
    id, name, category : int, str, str
        As in the description.

    Raises
    ------
    InputError
        Where the liquid would come nearer to the rim than `liquid.RIM_MARGIN`.
    """
    outer, inner = shape.outer, shape.inner
    reach, top = float(outer.points[:, 0].max()), float(outer.points[-1, 1])
    common = {"glass": glass, "roughness": roughness, "segments": segments_for(reach, chord_error), "name": name}
    if filling is None:
        liquid, interfaces = None, dry_interfaces(outer, inner, **common)
    else:
        surface = surface_of_volume(inner, filling.volume, filling.medium, chord_error, glass)
        liquid = liquid_of(inner, surface, filling.medium)
        interfaces = wet_interfaces(outer, inner, surface.top, liquid=filling.medium, **common)
    return Vessel(
        id=id,
        name=name,
        category=category,
        glass=glass,
        roughness=roughness,
        wall=shape.wall,
        outer=_profile(outer),
        inner=_profile(inner),
        liquid=liquid,
        interfaces=interfaces,
        size=(2.0 * reach, 2.0 * reach, 2.0 * top),
        world_T_object=np.eye(4),
    )


def _profile(curve: Curve) -> Profile:
    return tuple((float(r), float(z)) for r, z in curve.points)
