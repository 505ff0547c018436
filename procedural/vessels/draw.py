"""Draw a vessel: shape, wall, filling."""

from __future__ import annotations

import numpy as np

from ..description.scene import Vessel
from ..optics.medium import Medium
from ..profiles.curve import Curve
from ..profiles.liquid import brimful_volume, volume_below
from ..profiles.liquid_surface import most_volume
from .amounts import fill_fractions
from .build import Filling, VesselShape, build_vessel, vessel_shape
from .families import FAMILIES
from .family_pieces import Family, Size
from .outline import Outline
from .scaling import draw_wanted, shape_that_holds
from .settings import VesselSettings
from .sizes import draw_size
from .wall import WallShape, glass_section, round_section

#: Least radius of the ball that rounds the inside's corners [m]: no blown or pressed glass has a sharp one.
LEAST_CORNER = 1.5e-3
#: Least free inner radius of a neck or a base [m]: a narrow bottle's bore is about 9 mm wide.
LEAST_BORE = 4.5e-3
#: Most that a wall is thicker at the bottom than at the top [m].
MOST_TAPER = 1.5e-3
#: Largest radius of the ball that rounds the inside's corners, and radii of the outer corner at the base [m], as on
#: pressed and blown household glass; both give way where the vessel is narrow.
MOST_CORNER, FILLET = 6e-3, (8e-4, 4e-3)
#: Most that a wall is thicker at the bottom than at the top where the bottom is round, of the wall [1].
ROUND_TAPER = 0.4
#: Heights of the hollow under the base [m], at most this fraction of the base's radius, and how often vessels have one.
PUNT, PUNT_STEEPNESS, PUNT_PROBABILITY = (0.3e-3, 3e-3), 0.12, 0.6
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
        The liquid, if the vessel is drawn to be filled; None leaves it empty.

    Returns
    -------
    Vessel
        With ``world_T_object`` the identity; the origin is the centre of the bounding box, z up.

    Raises
    ------
    InputError
        Where no category of the settings can have the sizes of the settings, or no vessel that was drawn can have the
        volume of the settings, or hold that of its liquid.
    """
    category, *size = draw_size(rng, settings)
    wanted = draw_wanted(rng, settings, category)

    def build(stream: np.random.Generator, height: float, radius: float) -> VesselShape:
        return _built(stream, settings, FAMILIES[category], height, radius)

    def takes(shape: VesselShape) -> bool:
        if wanted.filled is None or liquid_medium is None:
            return True
        least, most = _volume_limits(shape.inner, liquid_medium, glass)
        return least <= wanted.filled <= most

    built = shape_that_holds(rng, settings, category, (size[0], size[1]), wanted, build, takes)
    filling = _draw_filling(rng, settings, built.inner, glass, liquid_medium, wanted.filled)
    roughness = draw_roughness(rng, settings)
    return build_vessel(built, glass, roughness, filling, settings.chord_error, id=id, name=name, category=category)


def _built(
    rng: np.random.Generator, settings: VesselSettings, family: Family, height: float, radius: float
) -> VesselShape:
    """Draw a wall, an outline and its roundings for a height and a largest radius [m]."""
    wall = _draw_wall(rng, settings, family)
    # The rounded rim adds up to half a wall.
    size = Size(height - 0.5 * wall, radius, room=min(wall + MOST_TAPER + LEAST_CORNER + LEAST_BORE, radius))
    outline = family.outline(rng, size)
    if isinstance(outline, Curve):
        taper = ROUND_TAPER * wall * rng.uniform()
        return vessel_shape(round_section(outline, wall, taper, settings.chord_error), wall)
    shape = _draw_shape(rng, settings, family, outline, wall)
    return vessel_shape(glass_section(outline, shape, settings.chord_error), wall)


def draw_within(rng: np.random.Generator, family: tuple[float, float], limits: tuple[float, float]) -> float:
    """Draw from the family's range, clipped to the settings' limits."""
    low, high = np.clip(family, *limits)
    return float(rng.uniform(low, high))


def _draw_wall(rng: np.random.Generator, settings: VesselSettings, family: Family) -> float:
    return draw_within(rng, family.wall, settings.wall)


def _draw_shape(
    rng: np.random.Generator, settings: VesselSettings, family: Family, outline: Outline, wall: float
) -> WallShape:
    """Draw base and roundings that the outline has room for."""
    z = np.linspace(outline.solid_below, outline.height, 513)
    radius = outline.derivative(z[z >= outline.solid_below], 0)
    open_radius = float(radius[len(radius) // 4 if outline.solid_below else 0 :].min())
    narrowest = float(outline.derivative(np.linspace(0.0, outline.height, 513), 0).min())
    foot = float(outline.derivative(np.zeros(1), 0)[0])
    base = max(draw_within(rng, family.base, settings.base), wall)
    taper = min(MOST_TAPER, 0.6 * wall) * rng.uniform(0.0, 1.0)
    corner = min(rng.uniform(LEAST_CORNER, MOST_CORNER), max(LEAST_CORNER, 0.6 * (open_radius - wall - taper)))
    fillet = min(rng.uniform(*FILLET), 0.35 * narrowest)
    punt = rng.uniform(*PUNT) if rng.random() < PUNT_PROBABILITY and not outline.solid_below else 0.0
    return WallShape(wall, taper, base, fillet, corner, min(punt, PUNT_STEEPNESS * foot))


def draw_amount(
    rng: np.random.Generator,
    settings: VesselSettings,
    brimful: float,
    medium: Medium | None,
    volume: float | None,
) -> float | None:
    """Draw whether a vessel is filled, and how far [m^3]; with a given volume [m^3] only whether. None is empty."""
    filled, fill = rng.random() < settings.fill_probability, rng.uniform(*fill_fractions(settings.fill))
    if medium is None or not filled:
        return None
    return fill * brimful if volume is None else volume


def _draw_filling(
    rng: np.random.Generator,
    settings: VesselSettings,
    inner: Curve,
    glass: Medium,
    medium: Medium | None,
    volume: float | None,
) -> Filling | None:
    """Draw whether a vessel is filled, and how far."""
    amount = draw_amount(rng, settings, brimful_volume(inner.points), medium, volume)
    if medium is None or amount is None:
        return None
    return Filling(
        medium, amount if volume is not None else float(np.clip(amount, *_volume_limits(inner, medium, glass)))
    )


def _volume_limits(inner: Curve, medium: Medium, glass: Medium) -> tuple[float, float]:
    """Return the volumes of a liquid of `LEAST_DEPTH` and up to the rim [m^3]."""
    least = volume_below(inner.points, float(inner.points[0, 1]) + LEAST_DEPTH)
    return least, most_volume(inner, medium, glass)


def draw_roughness(rng: np.random.Generator, settings: VesselSettings) -> float:
    """Draw the GGX alpha of a vessel's glass; 0 is smooth."""
    rough, alpha = rng.random() < settings.rough_probability, rng.uniform(*settings.roughness)
    return alpha if rough else 0.0
