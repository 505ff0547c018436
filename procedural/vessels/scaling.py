"""Vessels of a wanted volume: the drawn shape, scaled in height and radius, with the wall that was drawn."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from ...core.errors import InputError
from ...core.units import volume_text
from .family_pieces import Limits
from .rolling import NoRoomError
from .settings import LEAST_FILL, MOST_FILL, Category, VesselSettings
from .sizes import NOMINAL, draw_proportions, filled_limits, nominal_limits, size_limits

#: Largest relative error of a volume that is reached by scaling [1]: a tenth of what ISO 3819 allows a graduation.
VOLUME_TOLERANCE = 0.01
#: Most steps of the scale, and its step for a ratio of volumes: as the wall does not grow, the volume grows faster than
#: by the third power.
_STEPS, _EXPONENT = 16, 1.0 / 3.6
#: Most shapes that are drawn for one vessel before the request is refused.
ATTEMPTS = 24
#: Filled fraction [1] below which a vessel is too large for a volume, and the ranges of those of vessels that are
#: scaled because they are too small or too large for it.
_TOO_LARGE, _IN_SMALL, _IN_LARGE = 0.1, (0.5, 0.85), (0.15, 0.4)


class Holds(Protocol):
    """A shape that holds a liquid."""

    @property
    def brimful(self) -> float:
        """Volume up to the brim [m^3]."""
        ...


S = TypeVar("S", bound=Holds)
#: Makes a shape of a height and a radius [m], with the draws that a stream gives.
Build = Callable[[np.random.Generator, float, float], S]


@dataclass(frozen=True)
class WantedVolume:
    """What a vessel has to hold [m^3], each None where it is left free."""

    brimful: float | None = None
    filled: float | None = None


def draw_wanted(rng: np.random.Generator, settings: VesselSettings, category: Category) -> WantedVolume:
    """Draw what a vessel has to hold: what the settings say and its family can."""
    nominal, filled = nominal_limits(settings, category), filled_limits(settings, category)
    brimful = None if nominal is None else float(rng.uniform(*nominal)) / NOMINAL.get(category, 1.0)
    return WantedVolume(brimful, None if filled is None else float(rng.uniform(*filled)))


def shape_that_holds(
    rng: np.random.Generator,
    settings: VesselSettings,
    category: Category,
    size: tuple[float, float],
    wanted: WantedVolume,
    build: Build[S],
    takes: Callable[[S], bool] = lambda shape: True,
) -> S:
    """Return a shape that has a wanted brimful volume, or room for a wanted filling; any shape where both are free.

    Where a shape has no room inside its wall, or cannot be scaled to the volume within the settings' heights and radii,
    others of the same family are drawn; also where `takes` says that a shape does not take the liquid as it wets.

    Raises
    ------
    InputError
        Where no shape that was drawn can be.
    """
    nearest = 0.0
    for _ in range(ATTEMPTS):
        try:
            shape = _attempt(rng, size_limits(settings, category), size, wanted, build)
            if wanted == WantedVolume():
                return shape
            volume = shape.brimful
            if _holds(volume, wanted) and takes(shape):
                return shape
            target = wanted.brimful or wanted.filled or 1.0
            nearest = min((nearest or volume, volume), key=lambda found: abs(np.log(found / target)))
        except NoRoomError:
            pass
        size = draw_proportions(rng, settings, category)
    raise _refusal(settings, category, wanted, nearest)


def _attempt(
    rng: np.random.Generator,
    limits: tuple[Limits, Limits],
    size: tuple[float, float],
    wanted: WantedVolume,
    build: Build[S],
) -> S:
    before = deepcopy(rng)
    shape = build(rng, *size)
    if wanted == WantedVolume():
        return shape
    target = wanted.brimful
    if target is None:
        fraction = (wanted.filled or 0.0) / shape.brimful
        if _TOO_LARGE <= fraction <= MOST_FILL:
            return shape
        target = (wanted.filled or 0.0) / float(rng.uniform(*(_IN_SMALL if fraction > MOST_FILL else _IN_LARGE)))
    return _scaled(rng, before, limits, size, target, build)


def _scaled(
    rng: np.random.Generator,
    before: np.random.Generator,
    limits: tuple[Limits, Limits],
    size: tuple[float, float],
    target: float,
    build: Build[S],
) -> S:
    """Return the shape of a stream, scaled as near to a brimful volume [m^3] as limits of height and radius allow."""
    height, radius = size
    heights, radii = limits
    low = max(heights[0] / height, radii[0] / radius)
    high = min(heights[1] / height, radii[1] / radius)
    scale = float(np.clip(1.0, low, high))
    stream = deepcopy(before)
    shape = build(stream, scale * height, scale * radius)
    for _ in range(_STEPS):
        ratio = target / shape.brimful
        following = float(np.clip(scale * ratio**_EXPONENT, low, high))
        if abs(ratio - 1.0) <= 0.5 * VOLUME_TOLERANCE or following == scale:
            break
        scale, stream = following, deepcopy(before)
        shape = build(stream, scale * height, scale * radius)
    rng.bit_generator.state = stream.bit_generator.state
    return shape


def _holds(brimful: float, wanted: WantedVolume) -> bool:
    if wanted.brimful is not None:
        return abs(brimful / wanted.brimful - 1.0) <= VOLUME_TOLERANCE
    return wanted.filled is None or LEAST_FILL * brimful <= wanted.filled <= MOST_FILL * brimful


def _refusal(settings: VesselSettings, category: Category, wanted: WantedVolume, nearest: float) -> InputError:
    sizes = f"heights of {settings.height[0]:g} to {settings.height[1]:g} m and radii of {settings.radius[0]:g} to "
    sizes += f"{settings.radius[1]:g} m"
    if not nearest:
        return InputError("vessels.wall, vessels.base", f"walls that leave room in a {category} with {sizes}", "none")
    factor, amount = NOMINAL.get(category, 1.0), wanted.filled or 0.0
    if wanted.brimful is not None and abs(nearest / wanted.brimful - 1.0) > VOLUME_TOLERANCE:
        expected = f"{volume_text(nearest * factor)}, the nearest that a {category} with {sizes} can have"
        return InputError("vessels.volume", expected, volume_text(wanted.brimful * factor))
    if wanted.brimful is not None:
        expected = "more than a film on the floor" if amount < 0.5 * nearest else "a level below the rim"
        where = f"in a {category} of {volume_text(nearest * factor)}, whose brim is at {volume_text(nearest)}"
        return InputError("vessels.fill", f"{expected} {where}", volume_text(amount))
    most = amount > MOST_FILL * nearest
    limit = f"at {'most' if most else 'least'} {volume_text((MOST_FILL if most else LEAST_FILL) * nearest)}"
    return InputError("vessels.fill", f"{limit} in a {category} with {sizes}", volume_text(amount))
