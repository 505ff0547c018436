"""Random media: everyday mixtures of the catalogue, all physical."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .catalogue import catalogue, olive_oil, soda_lime, sugar_solution, water
from .dyes import DYES, PIGMENTS
from .medium import Absorber, Medium

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
#: Share of dyed drinks with two dyes (greens, oranges and browns are mixtures).
TWO_DYES = 0.3
#: Sugar by mass: from a light drink to a syrup.
SUGAR_RANGE = (0.05, 0.6)


def draw_glass(rng: np.random.Generator, weights: Mapping[str, float]) -> Medium:
    """Return a medium of the catalogue for a wall, by weights; soda-lime with a random content of iron."""
    kind = _choice(rng, weights)
    iron = float(rng.uniform())
    return soda_lime(iron) if kind == "soda-lime glass" else catalogue()[kind]


def draw_liquid(rng: np.random.Generator) -> Medium:
    """Return a liquid by `LIQUID_WEIGHTS`; concentrations of dyes and pigments are log-uniform in their usual range."""
    kind = _choice(rng, LIQUID_WEIGHTS)
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
    return catalogue()[kind]


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
