"""What vessels are made of and hold, as the settings choose it: by family, or by names with weights."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.errors import InputError
from ...core.weighted import weights_of
from ..optics.draw import LIQUID_WEIGHTS, NO_MEDIA, draw_dyed, draw_glass, draw_liquid
from ..optics.medium import Medium
from ..optics.own_media import read_media
from .settings import Category, VesselSettings, check_dissolving, unknown_media
from .wall_materials import draw_wall_material


def own_media(settings: VesselSettings) -> dict[str, Medium]:
    """Return the media of the settings' file by name; none without one.

    Raises
    ------
    InputError
        For a file that cannot be read, or names of glasses and liquids that neither it nor the catalogue has.
    """
    if settings.media is None:
        return {}
    found = {medium.name: medium for medium in read_media(settings.media)}
    unknown = unknown_media(settings, tuple(found))
    for field, (expected, names) in unknown.items():
        others = [f"; vessels.{other}: {wrong[1]}" for other, wrong in unknown.items() if other != field]
        raise InputError(f"vessels.{field}", f"{expected}", names + "".join(others))
    check_dissolving(settings)
    return found


def draw_media(
    rng: np.random.Generator, settings: VesselSettings, category: Category, own: Mapping[str, Medium] = NO_MEDIA
) -> tuple[Medium, Medium]:
    """Return the medium of a vessel's wall, and the liquid that it holds if it is drawn to be filled.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream of the vessel's media.
    settings : VesselSettings
        Which glasses, liquids and dyes; by default what the family is made of, and mostly water.
    category : str
        Family of the vessel.
    own : mapping of str to Medium
        Own media by name.
    """
    if settings.glasses is None:
        glass = draw_wall_material(rng, category)
    else:
        glass = draw_glass(rng, weights_of(settings.glasses), own)
    weights = LIQUID_WEIGHTS if settings.liquids is None else weights_of(settings.liquids)
    if settings.dyes is None:
        return glass, draw_liquid(rng, weights, own)
    undyed: dict[str, float] = {}
    for name, weight in weights.items():
        base = name.removeprefix("dyed ") if name in LIQUID_WEIGHTS else name
        undyed[base] = undyed.get(base, 0.0) + weight
    liquid = draw_liquid(rng, undyed, own)
    return glass, draw_dyed(rng, liquid, weights_of(settings.dyes), settings.dye_concentration)
