"""What the settings state about files of vessels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..vessels.settings import Unit, UpAxis, VesselSettings


@dataclass(frozen=True)
class FileChoice:
    """What the settings state about files of vessels."""

    unit: Unit | None
    up: UpAxis | Literal["fullest"] | None
    shell: float | None  #: [m]
    smooth: float | None  #: [rad]

    @classmethod
    def of(cls, settings: VesselSettings) -> FileChoice:
        """Return what settings state."""
        return cls(settings.unit, settings.up, settings.shell, settings.smooth)
