"""A camera with a polarising filter on each pixel, as data: mosaic, filters, and photon transfer of its pixels."""

from __future__ import annotations

import numpy as np
from pydantic import Field, model_validator

from ...core.model import Model

_Row = tuple[float, float]
#: Axes closer than this are one [deg]: no filter is placed better.
_APART = 0.1


class PolarisationCamera(Model):
    """A polarisation camera in the place of the left colour camera, whose pixels are the pixels of its sensor."""

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the device")
    source: str = Field(default="", description="Where its figures come from")
    angles: tuple[_Row, _Row] = Field(
        description="Axes of the filters of 2 x 2 pixels, row by row, counter-clockwise from the picture's x axis [deg]"
    )
    colour: bool = Field(
        default=False, description="Whether each such cell lies behind one colour of a Bayer mosaic, rows R G, G B"
    )
    extinction_ratio: float = Field(
        gt=1.0, le=1e9, description="Light that a filter passes along its axis, over that across it"
    )
    full_well: float = Field(gt=0.0, description="Electrons of a saturated pixel [e-]")
    read_noise: float = Field(ge=0.0, description="Standard deviation of the read noise [e-]")
    bits: int = Field(default=12, ge=6, le=16, description="Of the analogue-to-digital converter")
    black_level: float = Field(
        default=0.0, ge=0.0, lt=1.0, description="Value of a pixel without light, as a fraction of the scale"
    )
    exposure: float = Field(
        default=2.0,
        gt=0.0,
        description="Exposure time over that of a camera without filters: these take half of unpolarised light",
    )
    samples: int = Field(ge=1, le=1_048_576, description="Light paths of each pixel that shows glass")

    @model_validator(mode="after")
    def _axes_tell_a_vector(self) -> PolarisationCamera:
        """Require three different axes: intensity, and degree and angle of polarisation, are three unknowns."""
        axes = np.sort(np.array(self.angles).ravel() % 180.0)
        apart = np.diff(axes, append=axes[0] + 180.0)  # an axis that is turned by 180 degrees is the same
        if np.count_nonzero(apart > _APART) < 3:
            raise ValueError(f"angles: expected three different axes or more, modulo 180 degrees, found {self.angles}")
        return self

    @property
    def axes(self) -> np.ndarray:
        """Axes of the filters of a cell, (2, 2) float64 [rad]."""
        return np.radians(np.array(self.angles))
