"""Vessels that several tests of this folder look at."""

from __future__ import annotations

import pytest

from glassware.procedural.description import Vessel
from glassware.procedural.optics.medium import Medium
from glassware.procedural.randomness import stream
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import CATEGORIES, VesselSettings

GLASS = Medium(name="test glass", eta=1.52)
WATER = Medium(name="test water", eta=1.33)


@pytest.fixture(scope="session")
def many_vessels() -> list[Vessel]:
    """Two hundred and forty vessels, thirty of each category, about six in ten filled."""
    return [
        draw_vessel(
            stream(11, seed, "vessels"),
            VesselSettings(categories=(CATEGORIES[seed % len(CATEGORIES)],)),
            id=2,
            name=f"vessel-{seed}",
            glass=GLASS,
            liquid_medium=WATER,
        )
        for seed in range(240)
    ]


@pytest.fixture(scope="session")
def full_vessels(many_vessels: list[Vessel]) -> list[Vessel]:
    """One filled vessel of each category."""
    filled = [vessel for vessel in many_vessels if vessel.liquid]
    return [next(vessel for vessel in filled if vessel.category == category) for category in CATEGORIES]
