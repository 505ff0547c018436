"""How full a vessel is and how large: fractions, and volumes such as 150ml, as settings have them."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from ...core.units import volume, volume_text

Limits = tuple[float, float]

#: Smallest and largest nominal volume of a vessel [m^3]: what the limits of height and radius leave room for.
LEAST_VOLUME, MOST_VOLUME = 1e-5, 4e-3


def _pair(value: object) -> object:
    """Return a pair of values of one value or of two."""
    values = tuple(value) if isinstance(value, list | tuple) else (value,)
    return values * 2 if len(values) == 1 else values


def _fill(value: object) -> object:
    """Return a pair of fractions, or of volumes as texts; ValueError for anything else."""
    pair = _pair(value)
    if not (isinstance(pair, tuple) and len(pair) == 2):
        raise ValueError(f"expected fractions such as 0.1 0.9, or volumes such as 100ml 200ml, found {value!r}")
    numbers = [_number(item) for item in pair]
    if any(number is None for number in numbers):
        if any(number is not None for number in numbers):
            raise ValueError(f"expected two fractions or two volumes, found {' and '.join(map(str, pair))}")
        return _volume_texts(pair)
    for number in numbers:
        if number is None or not 0.0 < number <= 1.0:
            raise ValueError(f"expected fractions above 0 and at most 1, or volumes such as 150ml, found {number}")
    _check_order(numbers, tuple(numbers))
    return tuple(numbers)


def _number(item: object) -> float | None:
    if isinstance(item, bool) or not isinstance(item, int | float | str):
        raise ValueError(f"expected a fraction or a volume such as 150ml, found {item!r}")
    try:
        return float(item)
    except ValueError:
        return None


def _volumes(value: object) -> object:
    pair = _pair(value)
    if not (isinstance(pair, tuple) and len(pair) == 2):
        raise ValueError(f"expected a volume such as 250ml, or two, found {value!r}")
    texts = _volume_texts(pair)
    for text in texts:
        if not LEAST_VOLUME <= volume(text) <= MOST_VOLUME:
            limits = f"{volume_text(LEAST_VOLUME)} to {volume_text(MOST_VOLUME)}"
            raise ValueError(f"expected {limits}, found {text}")
    return texts


def _volume_texts(pair: tuple[object, ...]) -> tuple[str, ...]:
    volumes = [volume(item) for item in pair]
    texts = tuple(str(item).replace(" ", "") for item in pair)
    _check_order(volumes, texts)
    return texts


def _check_order(values: list[Any], shown: tuple[object, ...]) -> None:
    if values[0] > values[1]:
        raise ValueError(f"expected the smaller one first, found {shown[0]} and {shown[1]}")


#: A range of fillings: two fractions of the brimful volume, or two volumes as texts; one value stands for both.
Filled = Annotated[tuple[float | str, ...], BeforeValidator(_fill)]
#: A range of nominal volumes as texts; one stands for both.
Volumes = Annotated[tuple[str, ...], BeforeValidator(_volumes)]


def fill_volumes(fill: tuple[float | str, ...]) -> Limits | None:
    """Return the range of volumes of a filling [m^3]; None where it is one of fractions."""
    return volume_limits(tuple(map(str, fill))) if isinstance(fill[0], str) else None


def fill_fractions(fill: tuple[float | str, ...]) -> Limits:
    """Return the range of fractions of a filling; all of them where it is one of volumes."""
    low, high = (0.0, 1.0) if isinstance(fill[0], str) else map(float, fill)
    return low, high


def volume_limits(texts: tuple[str, ...]) -> Limits:
    """Return a range of volumes [m^3]."""
    low, high = (volume(text) for text in texts)
    return low, high
