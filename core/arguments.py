"""Checks of arguments from Python: a wrong one is refused by a line that says what was expected and found."""

from __future__ import annotations

import os
from collections.abc import Sequence
from numbers import Real
from pathlib import Path

import numpy as np

from .errors import InputError
from .setting_errors import shortened

#: Longest representation of a value in an error line [characters].
LONGEST_SHOWN = 85
#: Largest absolute coordinate of a point in a scene [m]: single precision, which the renderer uses, still tells points
#: a tenth of a metre apart there.
FARTHEST = 1e6


def described(value: object) -> str:
    """Return what a value is, on one short line: numbers and texts as they are, anything else by its type."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if value is None or isinstance(value, str | bytes | Real | np.generic | list | tuple | Path):
        text = " ".join(shortened(value).split())
        return text if len(text) <= LONGEST_SHOWN else f"a {type(value).__name__}"
    name = value.__name__ if isinstance(value, type) else type(value).__name__
    article = "the class" if isinstance(value, type) else "an" if name[:1].lower() in "aeiou" else "a"
    return f"{article} {name}"


def check_type(where: str, value: object, kind: type | tuple[type, ...], expected: str) -> None:
    """Raise InputError where a value has another type than expected."""
    if not isinstance(value, kind):
        raise InputError(where, expected, described(value))


def as_path(where: str, value: object) -> Path:
    """Return a path from Python; InputError where it is no text and no `Path`."""
    check_type(where, value, (str, os.PathLike), "a path (text or pathlib.Path)")
    return Path(value)  # pyright: ignore[reportArgumentType]


def whole_number(where: str, value: object, least: int, most: int) -> int:
    """Return a whole number, also one of NumPy's; InputError where it is none or not within the limits."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        allowed = f"a whole number from {least} to {most}" if least < most else f"the whole number {least}"
        raise InputError(where, allowed, described(value))
    return int(value)


def one_of(where: str, value: object, choices: Sequence[str]) -> str:
    """Return one of some texts; InputError where it is anything else."""
    if not isinstance(value, str) or value not in choices:
        quoted = " or ".join(map(repr, choices)) if len(choices) == 2 else f"one of {', '.join(choices)}"
        raise InputError(where, quoted, described(value))
    return value


def several(where: str, values: object, count: int, expected: str) -> tuple:
    """Return so many values as a tuple; InputError where they are others, or are no list, tuple or array."""
    listed = isinstance(values, list | tuple) or (isinstance(values, np.ndarray) and values.ndim == 1)
    if not listed or len(values) != count:  # pyright: ignore[reportArgumentType]
        raise InputError(where, expected, described(values))
    return tuple(values)  # pyright: ignore[reportArgumentType]


def number(where: str, value: object, least: float, most: float, unit: str = "") -> float:
    """Return a number as a float; InputError where it is none or not within the limits."""
    good = isinstance(value, Real | np.number) and not isinstance(value, bool)
    if not good or not least <= float(value) <= most:  # pyright: ignore[reportArgumentType]
        raise InputError(where, f"a number from {least:g} to {most:g}{unit and ' '}{unit}", described(value))
    return float(value)  # pyright: ignore[reportArgumentType]


def point(where: str, value: object) -> np.ndarray:
    """Return a point as an array, (3,) float64 [m]; InputError where it is not three finite numbers."""
    return _coordinates(where, value, (3,), "three finite numbers (x, y, z) [m]")


def points(where: str, value: object) -> np.ndarray:
    """Return points as an array, (n, 3) float64 [m]; InputError where they are anything else."""
    return _coordinates(where, value, (-1, 3), "points as an array of finite numbers of shape (n, 3) [m]")


def _coordinates(where: str, value: object, shape: tuple[int, ...], expected: str) -> np.ndarray:
    try:
        array = np.asarray(value)
    except ValueError:  # rows of several lengths
        array = np.array(None)
    fits = array.dtype.kind in "iuf" and array.ndim == len(shape) and array.shape[-1] == 3
    if not fits:
        raise InputError(where, expected, described(value))
    if not (np.abs(array) <= FARTHEST).all():
        raise InputError(where, f"finite numbers of at most {FARTHEST:g} m", described(value))
    return array.astype(np.float64)
