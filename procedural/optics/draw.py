"""Random media: everyday mixtures of the catalogue, all physical."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ...core.errors import InputError
from ...core.setting_errors import suggest
from .catalogue import SUCROSE, catalogue, dyed, glasses, liquids, olive_oil, soda_lime, sugar_solution, water
from .dyes import DYES, PIGMENTS
from .medium import Absorber, Medium
from .turbid import TURBID, turbid_medium

#: How often a vessel holds what [1]. Water most; coloured water next, because colour is what liquids differ in.
LIQUID_WEIGHTS = {
    "water": 0.50,
    "dyed water": 0.25,
    "sugar solution": 0.06,
    "dyed sugar solution": 0.06,
    "olive oil": 0.07,
    "ethanol": 0.03,
    "glycerol": 0.03,
}
#: No media of one's own.
NO_MEDIA: Mapping[str, Medium] = MappingProxyType({})
#: A sugar solution by its fraction of sucrose by mass.
_SUGAR_NAME = re.compile(r"([0-9]{1,2}) % sugar solution")
#: The name that stands for no dye among dyes with weights.
NO_DYE = "none"
#: Share of dyed drinks with two dyes (greens, oranges and browns are mixtures).
TWO_DYES = 0.3
#: Sugar by mass: from a light drink to a syrup.
SUGAR_RANGE = (0.05, 0.6)


def glass_names() -> list[str]:
    """Return the names of the media that walls can be of."""
    return [medium.name for medium in glasses()]


def liquid_names() -> list[str]:
    """Return the names of the liquids that can be drawn: those of the catalogue, and mixtures with random parts."""
    return list(dict.fromkeys([*(medium.name for medium in liquids()), *LIQUID_WEIGHTS, *TURBID]))


def is_sugar_solution(name: str) -> bool:
    """Return whether a name is that of a sugar solution that can be made, such as ``30 % sugar solution``."""
    match = _SUGAR_NAME.fullmatch(name)
    return match is not None and int(match[1]) <= 100 * SUCROSE[-1][0]


def dissolves_dyes(name: str) -> bool:
    """Return whether food dyes dissolve in a liquid: oils do not take them, and turbid liquids keep their look."""
    return not (name.endswith("oil") or name in TURBID)


def draw_glass(rng: np.random.Generator, weights: Mapping[str, float], own: Mapping[str, Medium] = NO_MEDIA) -> Medium:
    """Return a medium of the catalogue or of one's own for a wall, by weights; soda-lime with random iron."""
    kind = _choice(rng, weights)
    iron = float(rng.uniform())
    return soda_lime(iron) if kind == "soda-lime glass" else own.get(kind) or catalogue()[kind]


def draw_liquid(
    rng: np.random.Generator, weights: Mapping[str, float] = LIQUID_WEIGHTS, own: Mapping[str, Medium] = NO_MEDIA
) -> Medium:
    """Return a liquid by weights; concentrations of dyes and pigments are log-uniform in their usual range.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream.
    weights : mapping of str to float
        How often which liquid is drawn, by names of `liquid_names`, of sugar solutions and of own media.
    own : mapping of str to Medium
        Own media by name.
    """
    kind = _choice(rng, weights)
    dyes = draw_dyes(rng)
    sugar = float(rng.uniform(*SUGAR_RANGE))
    oil = [_log_uniform(rng, PIGMENTS[name].concentrations) for name in ("pheophytins", "carotenoids")]
    # Everything is drawn whatever the kind is, so that a change of the weights moves as little as possible.
    if kind == "olive oil":
        return olive_oil(*oil)
    if kind in ("water", "dyed water"):
        return water(*(dyes if kind == "dyed water" else ()))
    if kind in ("sugar solution", "dyed sugar solution"):
        return sugar_solution(sugar, *(dyes if kind == "dyed sugar solution" else ()))
    return own[kind] if kind in own else liquid_named(kind)


def liquid_named(name: str) -> Medium:
    """Return a liquid by its name in the catalogue, or a sugar solution; InputError with the nearest name."""
    if is_sugar_solution(name):
        return sugar_solution(float(name.split()[0]) / 100.0)
    if name in TURBID:
        return turbid_medium(name)
    known = {medium.name: medium for medium in liquids()}
    if name not in known:
        names = [*known, *TURBID]
        raise InputError("liquid", f"one of {', '.join(names)}{suggest(name, names)}", repr(name))
    return known[name]


def draw_dyed(
    rng: np.random.Generator, liquid: Medium, weights: Mapping[str, float], concentrations: tuple[float, float] | None
) -> Medium:
    """Return a liquid with one of some dyes in it, or none (`NO_DYE`), by weights; oil stays as it is.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream.
    liquid : Medium
        Without dyes.
    weights : mapping of str to float
        How often which dye is drawn, by names of `DYES` and `NO_DYE`.
    concentrations : (float, float), optional
        Range of its concentration [kg/m^3], log-uniform; that of drinks by default.
    """
    dye, position = _choice(rng, weights), float(rng.uniform())
    if dye == NO_DYE or not dissolves_dyes(liquid.name):
        return liquid
    low, high = np.log(concentrations or DYES[dye].concentrations)
    return dyed(liquid, dye, float(np.exp(low + position * (high - low))))


def draw_dyes(rng: np.random.Generator) -> tuple[Absorber, ...]:
    """Return one or two food dyes with concentrations in drinks [kg/m^3]."""
    names = rng.permutation(sorted(DYES))[:2]
    count = 2 if rng.uniform() < TWO_DYES else 1
    amounts = [_log_uniform(rng, DYES[str(name)].concentrations) for name in names]
    return tuple(Absorber(spectrum=str(n), amount=a) for n, a in zip(names[:count], amounts[:count], strict=True))


def _log_uniform(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))


def _choice(rng: np.random.Generator, weights: Mapping[str, float]) -> str:
    weight = np.array(list(weights.values()))
    return list(weights)[int(rng.choice(len(weight), p=weight / weight.sum()))]
