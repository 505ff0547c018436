"""Vessels that several tests of vessels and profiles look at."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.procedural.description.scene import Vessel
from glassware.procedural.optics.medium import Medium
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import REVOLVED, VesselSettings

GLASS = Medium(name="test glass", eta=1.52)
#: No capillary constants: its surface is flat.
FLAT = Medium(name="flat water", eta=1.33)
WATER = Medium(
    name="test water", eta=1.33, density=998.2, surface_tension=0.07274, contact_angle=float(np.radians(25.0))
)
#: Wets glass at 0 degrees.
SPIRIT = Medium(name="test spirit", eta=1.36, density=789.3, surface_tension=0.02231, contact_angle=0.0)


@pytest.fixture(scope="session")
def many_vessels() -> list[Vessel]:
    """Fifty-six vessels, seven of each category, about six in ten filled, with a flat surface."""
    return [
        draw_vessel(
            stream(11, seed, "vessels"),
            VesselSettings(categories=(REVOLVED[seed % len(REVOLVED)],)),
            id=2,
            name=f"vessel-{seed}",
            glass=GLASS,
            liquid_medium=FLAT,
        )
        for seed in range(56)
    ]


@pytest.fixture(scope="session")
def full_vessels() -> list[Vessel]:
    """One filled vessel of each category, water and spirit in turn."""
    return [
        draw_vessel(
            stream(12, number, "vessels"),
            VesselSettings(categories=(category,), fill_probability=1.0, fill=(0.3, 0.7)),
            id=2,
            name=f"full-{number}",
            glass=GLASS,
            liquid_medium=(WATER, SPIRIT)[number % 2],
        )
        for number, category in enumerate(REVOLVED)
    ]
