"""Sizes and volumes of vessels: which families can have those of the settings, and random ones of them."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError
from ...core.units import volume_text
from .amounts import fill_volumes, volume_limits
from .families import FAMILIES
from .family_pieces import Family, Limits
from .settings import LEAST_FILL, MOST_FILL, Category, VesselSettings, family_weights

#: Nominal volume over the brimful one [1]. Laboratory glass is named by its graduation: by the diameters and heights of
#: ISO 3819 (beakers, low form, 50 to 1000 ml) and ISO 1773 (conical flasks) less 1.3 mm walls it is 0.71 to 0.86. A
#: wine bottle of 750 ml holds 770 ml (CETIE data sheets). Drinking glasses, bowls and vases are sold by what they hold.
#: Volumetric flasks are filled to the mark in the middle of the neck (ISO 1042), injection vials of 10 ml hold 13.5 (ISO
#: 8362-1), jars and plastic bottles have some room under the lid.
NOMINAL: dict[Category, float] = {
    "beaker": 0.8,
    "spouted beaker": 0.8,
    "flask": 0.8,
    "round flask": 0.8,
    "volumetric flask": 0.9,
    "vial": 0.75,
    "bottle": 0.97,
    "square bottle": 0.97,
    "oval bottle": 0.97,
    "jar": 0.95,
    "plastic bottle": 0.95,
}
#: Brimful volume over that of a cylinder of the same height and largest radius [1]: 5th and 95th percentiles of 250
#: drawn shapes of each family (60 of those with other cross-sections, whose radius is half the smaller width), within
#: which most shapes can be scaled to a volume.
FULLNESS: dict[Category, Limits] = {
    "tumbler": (0.54, 0.79),
    "beaker": (0.58, 0.85),
    "bowl": (0.50, 0.71),
    "bottle": (0.41, 0.55),
    "stem glass": (0.28, 0.43),
    "flask": (0.29, 0.45),
    "vase": (0.35, 0.62),
    "freeform": (0.34, 0.69),
    "faceted glass": (0.54, 0.77),
    "fluted glass": (0.56, 0.78),
    "ribbed glass": (0.71, 0.88),
    "square glass": (0.79, 1.22),
    "mug": (0.64, 0.79),
    "cup": (0.59, 0.72),
    "jug": (0.53, 0.71),
    "teapot": (0.56, 0.64),
    "double-walled glass": (0.47, 0.58),
    "cocktail glass": (0.14, 0.31),
    "spouted beaker": (0.58, 0.81),
    "test tube": (0.56, 0.79),
    "vial": (0.58, 0.76),
    "volumetric flask": (0.23, 0.28),
    "round flask": (0.34, 0.42),
    "square bottle": (0.62, 1.60),
    "oval bottle": (0.72, 1.09),
    "jar": (0.66, 0.82),
    "plastic bottle": (0.67, 0.74),
    "plastic cup": (0.60, 0.71),
}


def draw_size(rng: np.random.Generator, settings: VesselSettings) -> tuple[Category, float, float]:
    """Draw a category, a height [m] and a largest outer radius [m] that fit it and the settings.

    Raises
    ------
    InputError
        Where no category of the settings has heights and radii, or volumes, within the settings.
    """
    weights = family_weights(settings)
    fitting: list[Category] = [c for c in weights if _fits(FAMILIES[c], settings) and _holds_volumes(c, settings)]
    if not fitting:
        check_volumes(settings)
        raise InputError(
            "vessels.categories",
            f"one that can be {settings.height} m high with a radius of {settings.radius} m",
            ", ".join(weights),
        )
    probabilities = np.array([weights[c] for c in fitting])
    if (probabilities == probabilities[0]).all():
        category = fitting[int(rng.integers(len(fitting)))]
    else:
        category = fitting[int(rng.choice(len(fitting), p=probabilities / probabilities.sum()))]
    return category, *draw_proportions(rng, settings, category)


def draw_proportions(rng: np.random.Generator, settings: VesselSettings, category: Category) -> tuple[float, float]:
    """Draw a height and a largest outer radius of a category that fit the settings [m]."""
    family = FAMILIES[category]
    height_limits, radius_limits = _common(family, settings)
    height = rng.uniform(*height_limits)
    slender = (family.slenderness[0] * height, family.slenderness[1] * height)
    low, high = np.clip(slender, *radius_limits)
    return float(height), float(rng.uniform(low, high))


def _common(family: Family, settings: VesselSettings) -> tuple[Limits, Limits]:
    """Heights and radii that both the family and the settings allow, and that have a partner in each other."""
    radius = _overlap(family.radius, settings.radius)
    return _overlap(family.height, _partnered(family, settings.height, radius)), radius


def _partnered(family: Family, height: Limits, radius: Limits) -> Limits:
    """Return the part of a range of heights that has a partner in a range of radii, by the family's slenderness."""
    slenderness = family.slenderness
    return _overlap(height, (radius[0] / slenderness[1], radius[1] / slenderness[0]))


def _fits(family: Family, settings: VesselSettings) -> bool:
    return all(low <= high for low, high in _common(family, settings))


def size_limits(settings: VesselSettings, category: Category) -> tuple[Limits, Limits]:
    """Return the heights and radii that a vessel may be scaled to [m].

    A vessel that is ordered by its volume may have any size of the settings. One that only has to hold a filling keeps
    the sizes of its family.
    """
    if settings.volume is not None:
        return settings.height, settings.radius
    return _common(FAMILIES[category], settings)


def volumes_of(settings: VesselSettings, category: Category) -> Limits:
    """Return the range of brimful volumes that a family's shapes can be scaled to within the settings [m^3]."""
    family, (height, radius) = FAMILIES[category], size_limits(settings, category)
    low, high = _partnered(family, height, radius)
    least, most = max(radius[0], family.slenderness[0] * low), min(radius[1], family.slenderness[1] * high)
    emptiest, fullest = FULLNESS[category]
    return fullest * np.pi * least**2 * low, emptiest * np.pi * most**2 * high


def check_volumes(settings: VesselSettings) -> None:
    """Raise InputError where no family of the settings can have their volumes, or hold their fillings."""
    if any(_holds_volumes(c, settings) for c in family_weights(settings) if _fits(FAMILIES[c], settings)):
        return
    ranges: dict[Category, Limits] = {
        c: volumes_of(settings, c) for c in family_weights(settings) if _fits(FAMILIES[c], settings)
    }
    if not ranges:  # `draw_size` says which sizes do not go together
        return
    if settings.volume is None:
        field, given = "fill", settings.fill
        low = LEAST_FILL * min(limits[0] for limits in ranges.values())
        high = MOST_FILL * max(limits[1] for limits in ranges.values())
    else:
        field, given = "volume", settings.volume
        low = min(limits[0] * NOMINAL.get(c, 1.0) for c, limits in ranges.items())
        high = max(limits[1] * NOMINAL.get(c, 1.0) for c, limits in ranges.items())
    expected = f"{volume_text(low)} to {volume_text(high)} (a {' or '.join(ranges)} of the set heights and radii)"
    raise InputError(f"vessels.{field}", expected, " to ".join(dict.fromkeys(map(str, given))))


def nominal_limits(settings: VesselSettings, category: Category) -> Limits | None:
    """Return the nominal volumes of the settings that a family can have [m^3]; None where they are left free."""
    if settings.volume is None:
        return None
    factor = NOMINAL.get(category, 1.0)
    low, high = volumes_of(settings, category)
    return _overlap(volume_limits(settings.volume), (factor * low, factor * high))


def filled_limits(settings: VesselSettings, category: Category) -> Limits | None:
    """Return the volumes of liquid of the settings that a family can hold [m^3]; None for fractions."""
    filled = fill_volumes(settings.fill)
    if filled is None or settings.volume is not None:  # settings themselves compare the two volumes
        return filled
    low, high = volumes_of(settings, category)
    return _overlap(filled, (LEAST_FILL * low, MOST_FILL * high))


def _holds_volumes(category: Category, settings: VesselSettings) -> bool:
    """Return whether a family can have nominal volumes of the settings and hold fillings of theirs."""
    found = (nominal_limits(settings, category), filled_limits(settings, category))
    return all(limits is None or limits[0] <= limits[1] for limits in found)


def _overlap(*limits: Limits) -> Limits:
    return max(low for low, _ in limits), min(high for _, high in limits)
