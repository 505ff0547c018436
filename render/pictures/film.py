"""What the samples of a picture add up to: means, and how far each is to be trusted.

Samples come in groups of one pixel; pixels may have different numbers of them. The spread of a pixel's groups tells the
variance of its mean.
"""

from __future__ import annotations

import numpy as np

#: Keeps the relative error finite in black pixels, in exposed units; the usual choice for relMSE (Rousselle et al.
#: 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", section 5).
RELATIVE_FLOOR = 1e-2


class Tally:
    """Running sums by pixel, over groups of n samples with mean m."""

    def __init__(self, pixels: int) -> None:
        self.samples, self._squares = np.zeros(pixels, np.int64), np.zeros(pixels)  # N, the sum of n, and that of n^2
        self._weighted = np.zeros((3, pixels))  # sum of n m
        self._spread, self._cross = np.zeros((3, pixels)), np.zeros((3, pixels))  # sums of (n m)^2 and of n^2 m

    def add(self, counts: np.ndarray, size: int, sums: np.ndarray) -> None:
        """Add groups of equal size, ordered by pixel.

        Parameters
        ----------
        counts : (pixels,) int
            Groups of each pixel.
        size : int
            Samples of each group.
        sums : (3, groups) float
            Radiance, summed over each group.
        """
        met = np.flatnonzero(counts)
        first = (np.cumsum(counts) - counts)[met]
        total = np.add.reduceat(sums, first, axis=1, dtype=np.float64)
        self._weighted[:, met] += total
        self._cross[:, met] += size * total
        self._spread[:, met] += np.stack([np.add.reduceat(np.square(x, dtype=np.float64), first) for x in sums])
        self.samples += size * counts
        self._squares += size**2 * counts

    @property
    def means(self) -> np.ndarray:
        """Mean of each pixel's samples, (3, pixels)."""
        return self._weighted / self.samples

    @property
    def variance(self) -> np.ndarray:
        """Estimated variance of the means, (3, pixels); 0 where there is one group, of which nothing is known."""
        means = self.means
        scatter = self._spread - 2.0 * means * self._cross + means**2 * self._squares
        # If one sample has the variance v, scatter is v (N - sum of n^2 / N) on the average, and the mean has v / N.
        freedom = self.samples**2 - self._squares
        return np.maximum(scatter, 0.0) / np.where(freedom > 0.0, freedom, np.inf)

    def noise(self, exposure: float) -> float | None:
        """Return the relative error of the picture: the root of the expected mean of (I - R)^2 / (R^2 + 0.01).

        It knows only what the samples found. Few samples miss light that comes by rare paths: the estimate is then too
        low. Where all light is found it is rather too high, because samples of different groups complete each other
        (they are one Sobol' sequence). None where there is one group.
        """
        if (self._squares == self.samples**2).any():
            return None
        relative = exposure**2 * self.variance / ((exposure * self.means) ** 2 + RELATIVE_FLOOR)
        return float(np.sqrt(relative.mean()))
