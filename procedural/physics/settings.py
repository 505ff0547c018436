"""Settings of piles: which scenes have one, what falls from how high, what lies, and when to give up."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ...core.model import Model, Ordered
from ...core.units import LENGTH

_Height = Annotated[float, Field(ge=0.001, le=0.3), LENGTH]
_Radius = Annotated[float, Field(ge=0.0, le=0.5), LENGTH]


class PhysicsSettings(Model):
    """How objects come to rest. Ranges are (smallest, largest), both included."""

    piled_probability: float = Field(
        default=0.4,
        ge=0.0,
        le=1.0,
        description="Probability that the props of a scene fall, lean and pile; otherwise all objects stand apart",
    )
    lying_probability: float = Field(
        default=0.15, ge=0.0, le=1.0, description="Probability that an empty vessel lies; filled ones stand"
    )
    drop_height: Annotated[tuple[_Height, _Height], Ordered] = Field(
        default=(0.005, 0.05),
        description="Height from which a prop of a pile falls, over whatever is below it, within 0.001 and 0.3 [m]",
    )
    pile_radius: Annotated[tuple[_Radius, _Radius], Ordered] = Field(
        default=(0.03, 0.15), description="Radius of the disc over which the props of a pile fall, within 0 and 0.5 [m]"
    )
    longest_time: float = Field(
        default=4.0, ge=2.0, le=120.0, description="Simulated time after which a pile has to be at rest [s]"
    )
    attempts: int = Field(
        default=12, ge=1, le=200, description="Piles that are drawn for a scene, each anew, until one comes to rest"
    )
