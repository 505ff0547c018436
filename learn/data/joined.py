"""Samples of several data sets as those of one."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from ...core.errors import InputError
from .samples import DEPTH_VIEWS, Sample, SampleDataset, range_of_depths


class JoinedSamples:
    """The samples of several data sets, one after the other.

    Parameters
    ----------
    parts : sequence of SampleDataset
        At least one, with one size of pictures.

    Raises
    ------
    InputError
        For data sets with pictures of several sizes.
    """

    def __init__(self, parts: Sequence[SampleDataset]) -> None:
        self.parts = tuple(parts)
        self._ends = list(accumulate(len(part) for part in self.parts))
        sizes = {part.fitted_camera(0)[1]: part for part in self.parts}
        if len(sizes) > 1:
            found = ", ".join(f"{width} x {height} px in {part.root}" for (height, width), part in sizes.items())
            raise InputError("views.size", "a size for the pictures of data sets of several sizes", found)

    def __len__(self) -> int:
        """Return the number of samples of all data sets."""
        return self._ends[-1]

    def __getitem__(self, item: tuple[int, int]) -> Sample:
        """Return the sample of an item (index, draw)."""
        index, draw = item
        number = bisect_right(self._ends, index)
        return self.parts[number][index - (self._ends[number] - len(self.parts[number])), draw]

    def depth_range(self, max_views: int = DEPTH_VIEWS) -> tuple[float, float]:
        """Return the depths between which objects of all data sets lie [m] (`SampleDataset.depth_range`)."""
        counts = (max(1, round(max_views * len(part) / len(self))) for part in self.parts)
        found = [part.object_depths(count) for part, count in zip(self.parts, counts, strict=True)]
        return range_of_depths(np.concatenate(found))

    def focal_baseline(self) -> float:
        """Return the greatest focal length times baseline of the stereo pairs, at the size of the samples [px m]."""
        return max(part.focal_baseline() for part in self.parts)
