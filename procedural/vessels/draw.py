"""Draw a vessel: shape, wall, filling."""

from __future__ import annotations

import numpy as np

from ...core.model import Profile
from ..description.scene import Liquid, Vessel
from ..optics.medium import Medium
from .curve import Curve
from .families import FAMILIES, Family, Size, draw_size
from .interfaces import dry_interfaces, wet_interfaces
from .liquid import brimful_volume, level_of_volume, volume_below
from .outline import Outline
from .revolve import segments_for
from .settings import VesselSettings
from .surface import Surface, most_volume, surface_of_volume
from .wall import WallShape, glass_section

#: Least radius of the ball that rounds the inside's corners [m]: no blown or pressed glass has a sharp one.
LEAST_CORNER = 1.5e-3
#: Least free inner radius of a neck or a base [m]: a narrow bottle's bore is about 9 mm wide.
LEAST_BORE = 4.5e-3
#: Most that a wall is thicker at the bottom than at the top [m].
MOST_TAPER = 1.5e-3
#: Least depth of a liquid [m]: less is a film, whose shape the floor decides, not the wall.
LEAST_DEPTH = 4e-3


def draw_vessel(
    rng: np.random.Generator,
    settings: VesselSettings,
    *,
    id: int,
    name: str,
    glass: Medium,
    liquid_medium: Medium | None = None,
) -> Vessel:
    """Draw a vessel at the origin of its own frame.

    Parameters
    ----------
    rng : numpy.random.Generator
        The vessel's own stream. The shape does not depend on the liquid: filling and roughness are drawn after it.
    settings : VesselSettings
        Ranges to draw from.
    id, name : int, str
        Instance id and name in the scene.
    glass : Medium
        The glass.
    liquid_medium : Medium, optional
        The liquid for the case that the vessel is filled; None leaves it empty.

    Returns
    -------
    Vessel
        With ``world_T_object`` the identity; the origin is the centre of the bounding box, z up.

    Raises
    ------
    InputError
        Where no category asked for has the sizes asked for.
    """
    category, height, radius = draw_size(rng, settings)
    wall = _draw_wall(rng, settings, FAMILIES[category])
    # The rounded rim adds up to half a wall.
    size = Size(height - 0.5 * wall, radius, room=min(wall + MOST_TAPER + LEAST_CORNER + LEAST_BORE, radius))
    outline = FAMILIES[category].outline(rng, size)
    shape = _draw_shape(rng, settings, FAMILIES[category], outline, wall)
    section = glass_section(outline, shape, settings.chord_error)
    lift = np.array([0.0, 0.5 * section.outer.points[-1, 1]])
    outer, inner = (Curve(curve.points - lift, curve.normals) for curve in (section.outer, section.inner))
    volume, roughness = _draw_volume(rng, settings, inner, liquid_medium), _draw_roughness(rng, settings)
    reach = float(outer.points[:, 0].max())
    segments = segments_for(reach, settings.chord_error)
    common = {"glass": glass, "roughness": roughness, "segments": segments, "name": name}
    if volume is None or liquid_medium is None:
        liquid, interfaces = None, dry_interfaces(outer, inner, **common)
    else:
        surface = surface_of_volume(inner, volume, liquid_medium, settings.chord_error)
        liquid = _liquid(inner, surface, liquid_medium)
        interfaces = wet_interfaces(outer, inner, surface.top, liquid=liquid_medium, **common)
    return Vessel(
        id=id,
        name=name,
        category=category,
        glass=glass,
        roughness=roughness,
        wall=wall,
        outer=_profile(outer),
        inner=_profile(inner),
        liquid=liquid,
        interfaces=interfaces,
        size=(2.0 * reach, 2.0 * reach, 2.0 * float(lift[1])),
        world_T_object=np.eye(4),
    )


def _draw_within(rng: np.random.Generator, family: tuple[float, float], asked: tuple[float, float]) -> float:
    """Draw from the part of the family's range that was asked for; where they have none in common, what was asked."""
    low, high = np.clip(family, *asked)
    return float(rng.uniform(low, high))


def _draw_wall(rng: np.random.Generator, settings: VesselSettings, family: Family) -> float:
    return _draw_within(rng, family.wall, settings.wall)


def _draw_shape(
    rng: np.random.Generator, settings: VesselSettings, family: Family, outline: Outline, wall: float
) -> WallShape:
    """Draw base and roundings that the outline has room for."""
    z = np.linspace(outline.solid_below, outline.height, 513)
    radius = outline.derivative(z[z >= outline.solid_below], 0)
    open_radius = float(radius[len(radius) // 4 if outline.solid_below else 0 :].min())
    narrowest = float(outline.derivative(np.linspace(0.0, outline.height, 513), 0).min())
    foot = float(outline.derivative(np.zeros(1), 0)[0])
    base = max(_draw_within(rng, family.base, settings.base), wall)
    taper = min(MOST_TAPER, 0.6 * wall) * rng.uniform(0.0, 1.0)
    corner = min(rng.uniform(LEAST_CORNER, 6e-3), max(LEAST_CORNER, 0.6 * (open_radius - wall - taper)))
    fillet = min(rng.uniform(8e-4, 4e-3), 0.35 * narrowest)
    punt = rng.uniform(0.3e-3, 3e-3) if rng.random() < 0.6 and not outline.solid_below else 0.0
    return WallShape(wall, taper, base, fillet, corner, min(punt, 0.12 * foot))


def _draw_volume(
    rng: np.random.Generator, settings: VesselSettings, inner: Curve, medium: Medium | None
) -> float | None:
    filled, share = rng.random() < settings.fill_probability, rng.uniform(*settings.fill)
    if medium is None or not filled:
        return None
    brimful = brimful_volume(inner.points)
    least = volume_below(inner.points, float(inner.points[0, 1]) + LEAST_DEPTH)
    return float(np.clip(share * brimful, least, most_volume(inner, medium)))


def _liquid(inner: Curve, surface: Surface, medium: Medium) -> Liquid:
    return Liquid(
        medium=medium,
        level=level_of_volume(inner.points, surface.volume),
        centre=surface.centre,
        contact=surface.contact,
        contact_angle=surface.contact_angle,
        fill=surface.volume / brimful_volume(inner.points),
        volume=surface.volume,
    )


def _draw_roughness(rng: np.random.Generator, settings: VesselSettings) -> float:
    rough, alpha = rng.random() < settings.rough_probability, rng.uniform(*settings.roughness)
    return alpha if rough else 0.0


def _profile(curve: Curve) -> Profile:
    return tuple((float(r), float(z)) for r, z in curve.points)
