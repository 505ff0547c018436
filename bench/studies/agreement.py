"""Whether two renderers draw the same picture: block by block, measured against the noise of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

#: Relative difference that is below what the two programs round: bilinear weights of textures and environment in
#: float32 and 8 bits of fraction, coordinates of 2^-24.
ROUNDING = 1e-3
#: Probability that a comparison without any true difference is reported as different.
FALSE_ALARM = 0.01


@dataclass(frozen=True, eq=False)
class Agreement:
    """Two mean pictures cut into blocks, (rows, columns, 3) each."""

    ours: np.ndarray
    peer: np.ndarray
    z: np.ndarray  #: difference beyond `ROUNDING` over its standard error, signed: positive where ours is brighter
    degrees: np.ndarray  #: degrees of freedom of each (Welch and Satterthwaite)
    block: int  #: side of a block [px]

    @property
    def limit(self) -> np.ndarray:
        """Where |z| is beyond what `FALSE_ALARM` allows for the largest of all blocks (Bonferroni)."""
        return stats.t.isf(FALSE_ALARM / self.z.size / 2, self.degrees)

    @property
    def different(self) -> np.ndarray:
        """Which blocks differ in any channel, (rows, columns) bool."""
        return np.any(np.abs(self.z) > self.limit, axis=-1)

    @property
    def relative(self) -> np.ndarray:
        """Difference over the mean of both, (rows, columns, 3)."""
        return (self.ours - self.peer) / np.maximum(0.5 * (self.ours + self.peer), 1e-6)


def block_means(picture: np.ndarray, block: int) -> np.ndarray:
    """Return the means of square blocks, (H // block, W // block, 3) float64; a narrower border is left out."""
    rows, columns = picture.shape[0] // block, picture.shape[1] // block
    cut = picture[: rows * block, : columns * block].astype(np.float64)
    return cut.reshape(rows, block, columns, block, 3).mean(axis=(1, 3))


def compared(ours: list[np.ndarray], peer: list[np.ndarray], block: int) -> Agreement:
    """Compare the block means of independent passes.

    Parameters
    ----------
    ours, peer : list of (rows, columns, 3) float
        One entry a pass, from `block_means`; at least two each.
    block : int
        Side of a block [px].
    """
    a, b = np.stack(ours), np.stack(peer)
    variance_a, variance_b = a.var(0, ddof=1) / len(a), b.var(0, ddof=1) / len(b)
    variance = np.maximum(variance_a + variance_b, 1e-30)
    difference, level = a.mean(0) - b.mean(0), 0.5 * (a.mean(0) + b.mean(0))
    beyond = np.sign(difference) * np.maximum(np.abs(difference) - ROUNDING * level, 0.0)
    degrees = variance**2 / np.maximum(variance_a**2 / (len(a) - 1) + variance_b**2 / (len(b) - 1), 1e-60)
    return Agreement(a.mean(0), b.mean(0), beyond / np.sqrt(variance), degrees, block)
