"""What may be asked of props."""

from __future__ import annotations

from pydantic import Field, model_validator

from ...core.model import Model


class PropSettings(Model):
    """How opaque props are drawn."""

    smallest: float = Field(default=0.05, ge=0.03, le=0.3, description="Least longest side of a drawn shape [m]")
    largest: float = Field(default=0.16, ge=0.03, le=0.3, description="Greatest longest side of a drawn shape [m]")
    file_share: float = Field(
        default=0.6, ge=0.0, le=1.0, description="Probability that a prop comes from the mesh folder, if one is given"
    )

    @model_validator(mode="after")
    def _in_order(self) -> PropSettings:
        if self.smallest > self.largest:
            raise ValueError(f"smallest: expected at most largest ({self.largest} m), found {self.smallest} m")
        return self
