"""A fault of a label: what was compared, where, what has to be there and what is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fault:
    """A label that cannot be right."""

    check: str  #: what was compared, such as ``depth``
    file: str  #: name of the file that holds it
    where: str  #: object, field or pixels
    expected: str
    found: str

    def __str__(self) -> str:
        return f"{self.file}: {self.check}: {self.where}: expected {self.expected}, found {self.found}"


def at_pixels(check: str, file: str, wrong: np.ndarray, expected: np.ndarray | str, values: np.ndarray) -> list[Fault]:
    """Return one fault for all wrong pixels, (H, W) bool, with the values of the first one; none where all are right.

    Parameters
    ----------
    check, file : str
        As in `Fault`.
    wrong : (H, W) bool
        The pixels.
    expected : (H, W, ...) array or str
        What has to be there.
    values : (H, W, ...) array
        What is there.
    """
    if not wrong.any():  # ten times as fast as to look for the places
        return []
    rows, columns = np.nonzero(wrong)
    at = rows[0], columns[0]
    wanted = expected if isinstance(expected, str) else _text(expected[at])
    where = f"{len(rows)} px, first (u, v) = ({columns[0]}, {rows[0]})"
    return [Fault(check, file, where, wanted, _text(values[at]))]


def unlike(check: str, file: str, where: str, expected: object, found: object, tolerance: float = 0.0) -> list[Fault]:
    """Return a fault where two values differ: numbers and arrays by more than a tolerance; NaN equals NaN."""
    numbers = not isinstance(expected, str | None | bool) and not isinstance(found, str | None | bool)
    if numbers:
        a, b = np.asarray(expected, np.float64), np.asarray(found, np.float64)
        with np.errstate(invalid="ignore"):  # of infinities
            near = a.shape == b.shape and bool((np.abs(a - b) <= tolerance).all())
        same = near or (a.shape == b.shape and np.allclose(a, b, rtol=0.0, atol=tolerance, equal_nan=True))
    else:
        same = expected == found
    return [] if same else [Fault(check, file, where, _text(expected), _text(found))]


def _text(value: object) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    text = str(value)
    return text if len(text) <= 200 else f"{text[:200]}..."
