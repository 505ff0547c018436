"""What a check found wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Violation:
    """One disagreement between labels, geometry and description."""

    check: str  #: name of the check
    where: str  #: object, field or pixels
    expected: str
    found: str

    def __str__(self) -> str:
        return f"{self.check}: {self.where}: expected {self.expected}, found {self.found}"


def at_pixels(check: str, wrong: np.ndarray, expected: str, values: np.ndarray, where: str = "") -> list[Violation]:
    """Return one violation for all wrong pixels, (H, W) bool, with the first one's value; none where all are right."""
    rows, columns = np.nonzero(wrong)
    if not len(rows):
        return []
    place = f"{where} {len(rows)} px, first (u, v) = ({columns[0]}, {rows[0]})".strip()
    return [Violation(check, place, expected, str(values[rows[0], columns[0]]))]
