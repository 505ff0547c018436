"""The data loader: batches of samples, loaded by worker processes, with their errors."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator, Sequence

import torch
from torch.utils.data import DataLoader
from torch.utils.data import Dataset as TorchDataset

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from .samples import Batch, Sample, Samples, collate


class _SamplesOrErrors(TorchDataset):
    """Samples, or their InputError as a value: torch would change an exception raised in a worker process."""

    def __init__(self, samples: Samples) -> None:
        super().__init__()
        self._samples = samples

    def __len__(self) -> int:
        return len(self._samples)

    def __getitem__(self, item: tuple[int, int]) -> Sample | InputError:
        try:
            return self._samples[item]
        except InputError as error:
            return error


class _Loader(DataLoader):
    def check_worker_number_rationality(self) -> None:
        """Say nothing where processes are more than cores: they take turns, and batches are the same."""


def load_batches(samples: Samples, order: Iterable[list[tuple[int, int]]], workers: int) -> Iterator[Batch]:
    """Yield batches of samples.

    Parameters
    ----------
    samples : Samples
        The samples.
    order : iterable of lists
        The items of each batch, (index, draw) of `SampleDataset`.
    workers : int
        Worker processes; 0: load in this process.

    Raises
    ------
    InputError
        Where a sample cannot be used.
    WorkFailed
        Where a worker process died, for example when memory ran out.
    """
    loader = _Loader(
        _SamplesOrErrors(samples),
        batch_sampler=order,
        collate_fn=_collate_or_error,
        num_workers=workers,
        worker_init_fn=_ignore_signals,
        # Otherwise the loader of a resumed run would draw from the generator that dropout draws from.
        generator=torch.Generator(),
    )
    try:
        for found in loader:
            if isinstance(found, InputError):
                raise found
            yield found
    except RuntimeError as error:
        if not str(error).startswith("DataLoader worker"):
            raise
        raise WorkFailed(f"a data loader process: {' '.join(str(error).split())}") from error


def _ignore_signals(_: int) -> None:
    """Ignore signals to stop in a worker: they reach the parent as well, which stops its workers."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


def _collate_or_error(items: Sequence[Sample | InputError]) -> Batch | InputError:
    for item in items:
        if isinstance(item, InputError):
            return item
    try:
        return collate([item for item in items if isinstance(item, Sample)])
    except InputError as error:
        return error
