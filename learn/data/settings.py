"""Which views make a sample, and what a camera does to their pictures."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model, Ordered
from ..networks.inputs import MULTIPLE

_Side = Annotated[int, Field(ge=MULTIPLE, le=8192, multiple_of=MULTIPLE)]
_Share = Annotated[float, Field(ge=0.0, le=1.0)]


class ViewSettings(Model):
    """The views of a sample: a reference, and others near it."""

    count: int = Field(default=2, ge=2, le=57, description="Views of a sample, 2 to 57")
    rule: Literal["grid", "distance", "stereo"] = Field(
        default="distance",
        description="grid: the paper's, next to the reference in the 57-view grid; distance: the nearest cameras; "
        "stereo: the right camera of the reference",
    )
    pool: int = Field(
        default=8, ge=1, le=56, description="With distance, how many of the nearest cameras the others are drawn from"
    )
    size: tuple[_Side, _Side] | None = Field(
        default=None, description="Height and width that pictures are scaled to, multiples of 32 [px]; null: as stored"
    )


class AugmentSettings(Model):
    """What differs from camera to camera and from picture to picture; the default ranges are a modest camera's."""

    share: _Share = Field(default=1.0, description="Share of samples that are changed at all")
    exposure: float = Field(default=0.7, ge=0.0, le=4.0, description="Largest change of exposure [stops]")
    balance: float = Field(default=0.15, ge=0.0, le=1.0, description="Largest change of red's and blue's gain [stops]")
    between: float = Field(default=0.1, ge=0.0, le=1.0, description="Largest change of exposure between views [stops]")
    shot_noise: float = Field(
        default=0.01, ge=0.0, le=0.2, description="Most deviation of white's noise, which falls with the root of light"
    )
    read_noise: float = Field(default=0.005, ge=0.0, le=0.1, description="Most deviation of noise in the dark")
    blur: float = Field(default=0.8, ge=0.0, le=5.0, description="Most deviation of a Gaussian blur [px]")
    jpeg: Annotated[tuple[Annotated[int, Field(ge=10, le=100)], Annotated[int, Field(ge=10, le=100)]], Ordered] = Field(
        default=(70, 100), description="Range of the quality of JPEG, 10 to 100"
    )
