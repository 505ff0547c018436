"""The renderer against the laws of optics: quantity, closed form, measured, error, bound.

    python bench/physics.py
    python bench/physics.py --only fresnel energy --json physics.json

The measurements are in `tests/proofs/`, and run in the tests with smaller budgets (`tests/render/physics/`), held to
what rounding, facets and noise explain. Here they are held to what the project promises; where it promises nothing, to
the same limits.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter

import mitsuba as mi
import numpy as np
from command import Output, run
from table import Row, report

from glassware.core.errors import InputError
from glassware.render.backend.variant import activate

# The variant is set before the modules of the renderer are imported: their types depend on it. The measurements are
# test code, which no package holds.
VARIANT = activate()
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
from proofs import (
    derivatives,
    energy,
    fresnel,
    lenses,
    microsurface,
    picture_derivatives,
    snell,
    straight_transmittance,
    vessels,
)
from proofs.check import Check

#: Every measurement by its topic, at the budget of the printed table.
TOPICS: dict[str, tuple[Callable[[], list[Check]], ...]] = {
    "snell": (
        lambda: snell.slab(np.arange(0.0, 86.0)),
        lambda: snell.prism_angles(np.arange(36.0, 81.0)),
        lambda: snell.apparent_depth(np.array([0.5, 20.0, 45.0, 70.0])),
    ),
    "dispersion": (snell.dispersed_prism,),
    "fresnel": (
        lambda: fresnel.reflected_fractions(1 << 20),
        fresnel.refracted_share,
        fresnel.critical_angle,
        fresnel.brewster_angle,
    ),
    "straight transmittance": (
        lambda: straight_transmittance.walls(np.radians(np.arange(0.0, 86.0))),
        straight_transmittance.absorbing_ball,
    ),
    "lenses": (lenses.ball_lens, lenses.plano_convex_lens, lenses.glass_of_water),
    "absorption": (lambda: energy.beer_lambert(4_000_000),),
    "energy": (
        lambda: energy.furnace(100_000),
        lambda: energy.radiance_inside(100_000),
        lambda: energy.radiance_inside(400_000, alpha=0.2),
    ),
    "vessels": (
        lambda: vessels.second_tracer(300),
        *(partial(vessels.default_furnace, 4_000_000, alpha) for alpha in (0.0, 0.05, 0.2, 0.5)),
    ),
    "microsurface": (
        lambda: microsurface.reciprocity(4_000_000),
        lambda: microsurface.first_facet(4_000_000, alpha=0.05),
        lambda: microsurface.first_facet(4_000_000, alpha=0.1),
    ),
    "derivatives": (derivatives.slab, derivatives.ball_by_differences),
    "picture derivatives": (
        lambda: picture_derivatives.absorption(4_000_000),
        lambda: picture_derivatives.light(4_000_000),
        lambda: picture_derivatives.roughness(8_000_000),
    ),
}


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    only: tuple[str, ...] = ()
    """Topics to measure; all by default."""


def main(options: Options) -> int:
    """Measure and print."""
    chosen = _chosen(options.only)
    start = perf_counter()
    rows = [_row(check) for topic in chosen for measure in TOPICS[topic] for check in measure()]
    facts = {"variant": VARIANT, "mitsuba": mi.__version__, "seconds": round(perf_counter() - start)}
    return report("The renderer against the laws of optics", rows, options.json_file, **facts)


def _chosen(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in TOPICS:
            raise InputError("--only", "topics of " + ", ".join(TOPICS), name)
    return names or tuple(TOPICS)


def _row(check: Check) -> Row:
    bound = check.limit if check.bound is None else check.bound
    unit = "" if check.error_unit == check.unit else f"error in {check.error_unit}; "
    explained = "" if check.bound is None else f"explained: {check.limit:.2g}; "
    return Row(
        name=check.name,
        measured=check.measured,
        unit=check.unit,
        expected=check.expected,
        error=check.error,
        bound=bound,
        ratio=check.share if check.bound is None else check.error / bound,
        ok=check.share <= 1.0 if check.bound is None else check.error <= bound,
        note=unit + explained + check.basis,
    )


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
