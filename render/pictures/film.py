"""Film: means of the samples of each pixel, and estimates of their variance.

Samples come in groups of one pixel; pixels may have different numbers of them. The variance between a pixel's groups
gives the variance of its mean.
"""

from __future__ import annotations

import numpy as np

#: Keeps the relative error finite in black pixels, in exposed units; the usual value for relMSE (Rousselle et al. 2011,
#: "Adaptive Sampling and Reconstruction using Greedy Error Minimization", section 5).
RELATIVE_FLOOR = 1e-2


class Film:
    """Running sums by pixel, over groups of n samples with mean m.

    The first three channels are linear Rec.709; a sensor's raw response takes three more.
    """

    def __init__(self, pixels: int, channels: int = 3) -> None:
        shape = channels, pixels
        self.samples, self._squares = np.zeros(pixels, np.int64), np.zeros(pixels)  # N, the sum of n, and that of n^2
        self._weighted = np.zeros(shape)  # sum of n m
        self._second, self._cross = np.zeros(shape), np.zeros(shape)  # sums of (n m)^2 and of n^2 m

    def add(self, counts: np.ndarray, size: int, sums: np.ndarray) -> None:
        """Add groups of equal size, ordered by pixel.

        Parameters
        ----------
        counts : (pixels,) int
            Number of groups of each pixel.
        size : int
            Samples of each group.
        sums : (channels, groups) float
            Radiance, and what the sensor makes of it, summed over each group.
        """
        sampled = np.flatnonzero(counts)
        first = (np.cumsum(counts) - counts)[sampled]
        total = np.add.reduceat(sums, first, axis=1, dtype=np.float64)
        self._weighted[:, sampled] += total
        self._cross[:, sampled] += size * total
        self._second[:, sampled] += np.stack([np.add.reduceat(np.square(x, dtype=np.float64), first) for x in sums])
        self.samples += size * counts
        self._squares += size**2 * counts

    @property
    def means(self) -> np.ndarray:
        """Mean of each pixel's samples, (channels, pixels)."""
        return self._weighted / self.samples

    @property
    def variance(self) -> np.ndarray:
        """Estimated variance of the means, (channels, pixels); 0 for pixels of one group, whose variance is unknown."""
        means = self.means
        scatter = self._second - 2.0 * means * self._cross + means**2 * self._squares
        # If one sample has the variance v, the mean of scatter is v (N - sum of n^2 / N), and the pixel's mean has
        # the variance v / N.
        freedom = self.samples**2 - self._squares
        return np.maximum(scatter, 0.0) / np.where(freedom > 0.0, freedom, np.inf)

    def noise(self, exposure: float) -> float | None:
        """Return the relative error of the picture: the root of the expected mean of (I - R)^2 / (R^2 + 0.01).

        It is that of linear Rec.709, whatever a sensor makes of the light.

        The estimate is based on the samples alone. It is too low where few samples miss light of rare paths, and rather
        too high otherwise, because different groups of one Sobol' sequence are negatively correlated. None if any pixel
        has a single group.
        """
        if (self._squares == self.samples**2).any():
            return None
        relative = exposure**2 * self.variance[:3] / ((exposure * self.means[:3]) ** 2 + RELATIVE_FLOOR)
        return float(np.sqrt(relative.mean()))
