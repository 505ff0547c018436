"""The learning rate schedule and the order of samples: both depend on the number of the step alone."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...core.randomness import stream
from .settings import OptimiserSettings

#: Exponent of the polynomial schedule (from the released code).
_POWER = 0.9


def learning_rate_at(step: int, steps: int, settings: OptimiserSettings) -> float:
    """Return the learning rate of a step, 0 <= step < steps."""
    warmup = min((step + 1) / settings.warmup, 1.0) if settings.warmup else 1.0
    progress = step / steps
    decay = {
        "constant": 1.0,
        "polynomial": (1.0 - progress) ** _POWER,
        "cosine": 0.5 * (1.0 + math.cos(math.pi * progress)),
    }
    return settings.learning_rate * warmup * decay[settings.schedule]


class StepBatches:
    """A batch sampler: the samples of each step of a run, as pairs of index and epoch.

    Each epoch permutes all samples; a batch may end one epoch and begin the next. Batch n depends on the seed and n
    alone, so a run that resumes at step n takes the batches that it would have taken.

    Parameters
    ----------
    count : int
        Number of samples.
    batch : int
        Samples per step, over all devices.
    steps : range
        The steps to take.
    seed : int
        Seed of the permutations.
    rank, world_size : int
        Number of this process, and of all processes; each takes its part of the batch.
    """

    def __init__(self, count: int, batch: int, steps: range, seed: int, rank: int = 0, world_size: int = 1) -> None:
        self._count, self._batch, self._steps, self._seed = count, batch, steps, seed
        self._rank, self._world_size = rank, world_size

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self._steps)

    def __iter__(self) -> Iterator[list[tuple[int, int]]]:
        """Yield the batch of each step."""
        orders: dict[int, np.ndarray] = {}
        for step in self._steps:
            places = range(step * self._batch + self._rank, (step + 1) * self._batch, self._world_size)
            epochs = {place // self._count for place in places}
            orders = {epoch: orders.get(epoch, self._order(epoch)) for epoch in epochs}
            yield [(int(orders[place // self._count][place % self._count]), place // self._count) for place in places]

    def _order(self, epoch: int) -> np.ndarray:
        return stream(self._seed, epoch, "learn/order").permutation(self._count)
