"""The objects of a data set one by one: what methods are given that are told where an object is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.errors import InputError
from ..targets.objects import ViewObject
from ..targets.view import detectable
from .ground_truth import GroundTruth
from .samples import SampleDataset

#: Where an object is said to be: at its true place, at that place moved at random, or where a detector found it.
Location = Literal["truth", "jitter", "detector"]


@dataclass(frozen=True, eq=False)
class Finding:
    """What a detector says about an object."""

    peak: tuple[float, float]  #: (x, y) [px]
    mask: np.ndarray  #: (H, W) bool


#: By the number of the view in its `SampleDataset` and the id of the object; objects that were missed are absent.
Findings = Mapping[tuple[int, int], Finding]


@dataclass(frozen=True)
class ObjectCase:
    """One object in one view."""

    view: int  #: number of the view in its `SampleDataset`
    object_id: int


def missed_cases(cases: Sequence[ObjectCase], findings: Findings | None) -> list[ObjectCase]:
    """Return the objects that a detector has not found; none without a detector."""
    return [] if findings is None else [case for case in cases if (case.view, case.object_id) not in findings]


def object_cases(samples: SampleDataset) -> list[ObjectCase]:
    """Return the objects that a network is to detect in each view (`targets.view.detectable`)."""
    return [
        ObjectCase(index, item.id)
        for index in range(len(samples))
        for item in detectable(samples.labels(index).objects)
    ]


def too_small(samples: SampleDataset) -> int:
    """Return how many objects are seen, but too little for a network to detect them: no result counts them."""
    shown = [samples.labels(index).objects for index in range(len(samples))]
    return sum(item.visible > 0 for objects in shown for item in objects) - sum(len(detectable(some)) for some in shown)


def object_of(labels: GroundTruth, case: ObjectCase, where: str) -> ViewObject:
    """Return an object of a view; InputError where its labels have no such object."""
    for item in labels.objects:
        if item.id == case.object_id:
            return item
    raise InputError(where, f"an object {case.object_id}", [item.id for item in labels.objects])


def check_has_cases(cases: list[ObjectCase], where: str) -> None:
    """Raise InputError where there is no object."""
    if not cases:
        raise InputError(where, "an object that can be seen", "none")
