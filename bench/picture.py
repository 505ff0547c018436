"""Rendered pictures, what they took, and PNG files of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from references import Reference, relmse

from glassware.core.images import srgb8, srgb_curve
from glassware.dataset.format.pictures import write_png


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture by any renderer and what it took."""

    noisy: np.ndarray  #: (H, W, 3) float32, linear radiance
    clean: np.ndarray | None  #: (H, W, 3) float32; None where no denoiser ran
    seconds: float  #: tracing and denoising
    denoise_seconds: float = 0.0  #: part of `seconds`, where the renderer reports it
    setup_seconds: float = 0.0  #: from the request to the first sample, where the renderer reports it

    @property
    def denoised(self) -> np.ndarray:
        """The picture after the denoiser; ValueError where none ran."""
        if self.clean is None:
            raise ValueError("this picture was not denoised")
        return self.clean

    def errors(self, exposure: float, reference: Reference) -> tuple[float, float]:
        """Return the relMSE before and after the denoiser."""
        return relmse(self.noisy * exposure, reference), relmse(self.denoised * exposure, reference)


def srgb_levels(exposed: np.ndarray) -> np.ndarray:
    """Return exposed linear light as sRGB levels 0 to 255, not rounded (float64)."""
    return 255.0 * srgb_curve(np.clip(exposed.astype(np.float64), 0.0, 1.0))


def write_exposed(path: Path, *exposed: np.ndarray) -> None:
    """Write pictures in exposed linear units, each (H, W, 3), one below the other as 8-bit sRGB."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, np.concatenate([srgb8(picture, 1.0) for picture in exposed]))


def write_signed(path: Path, values: np.ndarray, limit: float) -> None:
    """Write a map of signed numbers, (H, W): 0 is white, `limit` and above red, minus `limit` and below blue."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fraction = np.clip(values / limit, -1.0, 1.0)
    high, low = 1.0 - np.maximum(-fraction, 0.0), 1.0 - np.maximum(fraction, 0.0)
    picture = np.stack([high, np.minimum(high, low), low], axis=-1)
    write_png(path, np.rint(255.0 * picture).astype(np.uint8))
