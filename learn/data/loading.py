"""Batches from processes that load samples, and what goes wrong there."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator, Sequence

from torch.utils.data import DataLoader
from torch.utils.data import Dataset as TorchDataset

from ...core.errors import InputError
from ...core.exit_codes import WorkFailed
from .samples import Batch, Sample, SampleDataset, batched


class _Told(TorchDataset):
    """Samples, or what is wrong with them: torch makes another error of one that is raised in a process of its own."""

    def __init__(self, samples: SampleDataset) -> None:
        super().__init__()
        self._samples = samples

    def __len__(self) -> int:
        return len(self._samples)

    def __getitem__(self, item: tuple[int, int]) -> Sample | InputError:
        try:
            return self._samples[item]
        except InputError as error:
            return error


def load_batches(samples: SampleDataset, order: Iterable[list[tuple[int, int]]], workers: int) -> Iterator[Batch]:
    """Go through batches of samples.

    Parameters
    ----------
    samples : SampleDataset
        The samples.
    order : iterable of lists
        The samples of each batch, as `SampleDataset` is asked for them.
    workers : int
        Processes that load; 0: none but this one.

    Raises
    ------
    InputError
        Where a sample cannot be used, as `SampleDataset` raises it.
    WorkFailed
        Where a process died, as when memory runs out.
    """
    loader = DataLoader(
        _Told(samples),
        batch_sampler=order,
        collate_fn=_batch_or_error,
        num_workers=workers,
        worker_init_fn=_leave_signals,
    )
    try:
        for found in loader:
            if isinstance(found, InputError):
                raise found
            yield found
    except RuntimeError as error:
        if not str(error).startswith("DataLoader worker"):
            raise
        raise WorkFailed(f"a process that loads samples: {' '.join(str(error).split())}") from error


def _leave_signals(_: int) -> None:
    """Leave it to the parent to stop: a signal to the whole group reaches both."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


def _batch_or_error(items: Sequence[Sample | InputError]) -> Batch | InputError:
    for item in items:
        if isinstance(item, InputError):
            return item
    try:
        return batched([item for item in items if isinstance(item, Sample)])
    except InputError as error:
        return error
