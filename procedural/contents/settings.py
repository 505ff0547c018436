"""Settings of what is in vessels besides one clear liquid."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from ...core.model import Model, Ordered
from ...core.units import LENGTH
from ...core.weighted import Weighted, check_names, weights_of
from ..optics.turbid import TURBID

#: What leans in vessels, and how often which does by default [1].
STANDING = {"straw": 0.6, "spoon": 0.25, "stirring rod": 0.15}

_Fraction = Annotated[float, Field(ge=0.05, le=0.8)]
_IceEdge = Annotated[float, Field(ge=0.008, le=0.05), LENGTH]
_IceCount = Annotated[int, Field(ge=1, le=12)]
_BeadRadius = Annotated[float, Field(ge=0.001, le=0.01), LENGTH]
_BeadCount = Annotated[int, Field(ge=1, le=60)]
_BubbleRadius = Annotated[float, Field(ge=0.0001, le=0.002), LENGTH]
_BubbleCount = Annotated[int, Field(ge=1, le=200)]


class ContentsSettings(Model):
    """What is in vessels. Ranges are (smallest, largest), both included.

    A probability of 1 is a request: a vessel that cannot have what is asked for is refused. Below 1, what does not fit
    is drawn again, and the vessel's `redrawn` counts it.
    """

    layered: float = Field(
        default=0.08,
        ge=0.0,
        le=1.0,
        description="Probability that olive oil floats on a watery liquid in a vessel; with `vessels.liquids` only "
        "if it is 1",
    )
    layer_fraction: Annotated[tuple[_Fraction, _Fraction], Ordered] = Field(
        default=(0.12, 0.5), description="Fraction of the liquids that is the upper one, within 0.05 and 0.8"
    )
    turbid: float = Field(
        default=0.06,
        ge=0.0,
        le=1.0,
        description="Probability that a vessel with a liquid holds a turbid one, opaque under its clear surface; "
        "with `vessels.liquids` only if it is 1",
    )
    turbid_liquids: Weighted = Field(
        default=tuple(TURBID),
        min_length=1,
        description="Turbid liquids to draw from, equally likely or by weights (milk=2)",
        json_schema_extra={"range": f"one or more of {', '.join(TURBID)}"},
    )
    ice: float = Field(
        default=0.12, ge=0.0, le=1.0, description="Probability that ice cubes float in a vessel with a liquid"
    )
    ice_edge: Annotated[tuple[_IceEdge, _IceEdge], Ordered] = Field(
        default=(0.016, 0.03), description="Edge of an ice cube, within 0.008 and 0.05 [m]"
    )
    ice_count: Annotated[tuple[_IceCount, _IceCount], Ordered] = Field(
        default=(1, 4), description="Ice cubes in a vessel, within 1 and 12"
    )
    beads: float = Field(
        default=0.04, ge=0.0, le=1.0, description="Probability that glass beads lie on the floor of a vessel"
    )
    bead_radius: Annotated[tuple[_BeadRadius, _BeadRadius], Ordered] = Field(
        default=(0.003, 0.008), description="Radius of a bead, within 0.001 and 0.01 [m]"
    )
    bead_count: Annotated[tuple[_BeadCount, _BeadCount], Ordered] = Field(
        default=(3, 16), description="Beads in a vessel, within 1 and 60"
    )
    bubbles: float = Field(
        default=0.12,
        ge=0.0,
        le=1.0,
        description="Probability that bubbles of air stick to the wall under a clear liquid",
    )
    bubble_radius: Annotated[tuple[_BubbleRadius, _BubbleRadius], Ordered] = Field(
        default=(0.0003, 0.001), description="Radius of a bubble, within 0.0001 and 0.002 [m]"
    )
    bubble_count: Annotated[tuple[_BubbleCount, _BubbleCount], Ordered] = Field(
        default=(8, 50), description="Bubbles in a vessel, within 1 and 200"
    )
    standing: float = Field(
        default=0.15, ge=0.0, le=1.0, description="Probability that a straw, a spoon or a rod leans in a vessel"
    )
    standing_kinds: Weighted = Field(
        default=tuple(f"{kind}={weight}" for kind, weight in STANDING.items()),
        min_length=1,
        description="What leans in vessels, equally likely or by weights (spoon=2)",
        json_schema_extra={"range": f"one or more of {', '.join(STANDING)}"},
    )

    @field_validator("standing_kinds")
    @classmethod
    def _known_kinds(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(names), list(STANDING))
        return names

    @field_validator("turbid_liquids")
    @classmethod
    def _known_liquids(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(names), list(TURBID))
        return names
