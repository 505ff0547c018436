"""Draw a vessel that is no solid of revolution: shape, wall, filling."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..cavities.known import KnownCavity, filled_known
from ..description.bodies import Cavity, MeshVessel
from ..description.mesh_vessel import dry_interfaces_of, with_parts
from ..optics.medium import Medium
from ..placement.resting import turn_about_z
from ..profiles.revolve import segments_for
from ..vessels.draw import (
    FILLET,
    LEAST_BORE,
    LEAST_CORNER,
    LEAST_DEPTH,
    MOST_CORNER,
    PUNT,
    PUNT_PROBABILITY,
    draw_amount,
    draw_roughness,
    draw_within,
)
from ..vessels.draw import PUNT_STEEPNESS as STEEPNESS
from ..vessels.families import FAMILIES
from ..vessels.family_pieces import Size
from ..vessels.outline import Outline
from ..vessels.scaling import draw_wanted, shape_that_holds
from ..vessels.settings import Category, VesselSettings
from ..vessels.sizes import draw_size
from .build import Glass, ShapedGlass, shaped_glass
from .containers import oval_bottle, plain, plastic_cup, spouted_beaker, square_bottle
from .double_wall import double_wall
from .handled import cup, jug, mug
from .section import irregularity
from .shapes import Drawn, Shaper
from .spouts import teapot
from .tumblers import faceted, flutes, ribbed, square

#: What makes the shape of each family.
SHAPERS: Mapping[Category, Shaper] = MappingProxyType(
    {
        "faceted glass": faceted,
        "fluted glass": flutes,
        "ribbed glass": ribbed,
        "square glass": square,
        "mug": mug,
        "cup": cup,
        "jug": jug,
        "teapot": teapot,
        "double-walled glass": double_wall,
        "spouted beaker": spouted_beaker,
        "square bottle": square_bottle,
        "oval bottle": oval_bottle,
        "plastic bottle": plain,
        "plastic cup": plastic_cup,
    }
)
#: How much thicker the wall is at the bottom than at the top, and on one side than on the other, at most [1].
TAPER, UNEVEN = 0.5, 0.12
#: Height of the middle of the floor over its edge, at most, of the corner's radius [1].
DOME = 0.3
#: Names of the meshes of a filled vessel.
_PARTS = ("outside", "wet-wall", "liquid-surface")


def draw_shaped_vessel(
    rng: np.random.Generator,
    settings: VesselSettings,
    *,
    id: int,
    name: str,
    glass: Medium,
    liquid_medium: Medium | None = None,
) -> tuple[MeshVessel, ShapedGlass]:
    """Draw a vessel at the origin of its own frame; its liquid, if it has one, is level.

    Parameters
    ----------
    rng, settings, id, name, glass, liquid_medium
        As in `vessels.draw.draw_vessel`; the families of `SHAPERS` alone.

    Returns
    -------
    MeshVessel, ShapedGlass
        The vessel, and what it was made of.

    Raises
    ------
    InputError
        As `draw_vessel`.
    """
    category, *size = draw_size(rng, settings)
    wanted = draw_wanted(rng, settings, category)

    def build(stream: np.random.Generator, height: float, radius: float) -> ShapedGlass:
        return _built(stream, settings, category, height, radius, f"{name}-solid")

    def takes(made: ShapedGlass) -> bool:
        if wanted.filled is None or liquid_medium is None:
            return True
        least, most = _volume_limits(made.cavity)
        return least <= wanted.filled <= most

    made = shape_that_holds(rng, settings, category, (size[0], size[1]), wanted, build, takes)
    amount = draw_amount(rng, settings, made.brimful, liquid_medium, wanted.filled)
    roughness = draw_roughness(rng, settings)
    vessel = _vessel(made, glass, roughness, id=id, name=name, category=category)
    if amount is None or liquid_medium is None:
        return vessel, made
    return _filled(vessel, made, liquid_medium, float(np.clip(amount, *_volume_limits(made.cavity)))), made


def _built(
    rng: np.random.Generator, settings: VesselSettings, category: Category, height: float, radius: float, name: str
) -> ShapedGlass:
    """Draw a wall, an outline, a shape and roundings for a height and a largest radius [m]."""
    family = FAMILIES[category]
    wall = draw_within(rng, family.wall, settings.wall)
    size = Size(height - 0.5 * wall, radius, room=min(wall * (1.0 + TAPER) + LEAST_CORNER + LEAST_BORE, radius))
    outline = family.outline(rng, size)
    assert isinstance(outline, Outline)
    drawn = Drawn(outline, wall, segments_for(radius, settings.chord_error))
    shape = SHAPERS[category](rng, drawn)
    base = max(draw_within(rng, family.base, settings.base), wall)
    foot = drawn.radius(0.0)
    corner = min(rng.uniform(LEAST_CORNER, MOST_CORNER), 0.4 * foot)
    # The outer corner keeps the wall's thickness from the inner one.
    fillet = min(rng.uniform(*FILLET), 0.35 * foot, corner + 0.5 * wall)
    punt = rng.uniform(*PUNT) if rng.random() < PUNT_PROBABILITY else 0.0
    glass = Glass(
        wall=wall,
        # Facets are thinnest in their middles, below a rim that stands out: there the wall is as thick as asked.
        taper=wall * rng.uniform(0.0, TAPER) * (shape.measured is shape.form),
        uneven=rng.uniform(0.0, UNEVEN),
        side=rng.uniform(),
        base=base,
        fillet=fillet,
        corner=corner,
        punt=min(punt, STEEPNESS * foot),
        dome=rng.uniform(0.0, DOME) * corner,
    )
    return shaped_glass(outline, shape, glass, irregularity(rng), settings.chord_error, name)


def _volume_limits(cavity: KnownCavity) -> tuple[float, float]:
    """Return the volumes of a liquid of `LEAST_DEPTH` and up to the highest level [m^3]."""
    return cavity.volume_below(cavity.floor + LEAST_DEPTH), cavity.volume_below(cavity.most_level)


def _vessel(made: ShapedGlass, glass: Medium, roughness: float, *, id: int, name: str, category: str) -> MeshVessel:
    x, y, z = np.ptp(made.mesh.bounds, axis=0).tolist()
    cavity = Cavity(floor=made.cavity.floor, brim=made.cavity.brim, volume=made.brimful)
    return MeshVessel(
        id=id,
        name=name,
        category=category,
        glass=glass,
        roughness=roughness,
        interfaces=dry_interfaces_of(made.mesh, glass, roughness),
        size=(x, y, z),
        symmetric=made.fold == 0,
        symmetries=_turns(made),
        world_T_object=np.eye(4),
        solid=made.mesh,
        wall=made.wall,
        cavities=(cavity,),
    )


def _turns(made: ShapedGlass) -> tuple[np.ndarray, ...]:
    """Return the turns that leave a vessel as it is, about its axis: a box around an odd number of sides is beside it.

    The axis leans a little; the turns are about the vertical through its point at half height.
    """
    outside = made.outside
    axis = outside.matrix @ (0.0, 0.0, outside.centre[2]) - outside.centre
    turns = []
    for number in range(1, made.fold):
        turn = turn_about_z(2.0 * np.pi * number / made.fold)
        turn[:3, 3] = axis - turn[:3, :3] @ axis
        turns.append(turn)
    return tuple(turns)


def _filled(vessel: MeshVessel, made: ShapedGlass, medium: Medium, volume: float) -> MeshVessel:
    first, second, third = (f"{vessel.name}-{part}" for part in _PARTS)
    parts, level = filled_known(made.cavity, volume, (first, second, third))
    return with_parts(vessel, medium, parts, level, made.brimful)
