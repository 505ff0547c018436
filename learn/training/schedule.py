"""The learning rate, and which samples each step takes: both follow from the step's number alone."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...core.randomness import stream
from .settings import OptimiserSettings

#: Exponent of the polynomial schedule (the released code's).
_POWER = 0.9


def rate_at(step: int, steps: int, settings: OptimiserSettings) -> float:
    """Return the learning rate of a step, 0 <= step < steps."""
    warmup = min((step + 1) / settings.warmup, 1.0) if settings.warmup else 1.0
    share = step / steps
    falling = {
        "constant": 1.0,
        "polynomial": (1.0 - share) ** _POWER,
        "cosine": 0.5 * (1.0 + math.cos(math.pi * share)),
    }
    return settings.rate * warmup * falling[settings.schedule]


class StepBatches:
    """The samples of each step of a run, as pairs of index and draw.

    Each epoch goes through all samples in an order of its own; a batch may end one epoch and begin the next. Batch n
    depends on nothing but the seed and n, so that a run that goes on at step n takes what it would have taken.

    Parameters
    ----------
    count : int
        Samples.
    batch : int
        Samples of a step, over all devices.
    steps : range
        The steps to be taken.
    seed : int
        Of the orders.
    rank, world : int
        Which of how many processes this is; each takes its part of the batch.
    """

    def __init__(self, count: int, batch: int, steps: range, seed: int, rank: int = 0, world: int = 1) -> None:
        self._count, self._batch, self._steps, self._seed = count, batch, steps, seed
        self._rank, self._world = rank, world

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self._steps)

    def __iter__(self) -> Iterator[list[tuple[int, int]]]:
        """Go through the steps."""
        orders: dict[int, np.ndarray] = {}
        for step in self._steps:
            places = range(step * self._batch + self._rank, (step + 1) * self._batch, self._world)
            epochs = {place // self._count for place in places}
            orders = {epoch: orders.get(epoch, self._order(epoch)) for epoch in epochs}
            yield [(int(orders[place // self._count][place % self._count]), place // self._count) for place in places]

    def _order(self, epoch: int) -> np.ndarray:
        return stream(self._seed, epoch, "learn/order").permutation(self._count)
