"""Quantities as text with a unit, such as ``12cm``, ``30deg`` or ``150ml``: a table of suffixes, and their readers.

A new unit is a row of `SUFFIXES`; a new dimension is a value of `Dimension`, its examples, and a function such as
`length`. The readers are validators of settings: whatever is no text with a suffix is returned as it is, for whoever
checks it, so a number without a unit keeps its meaning (metres, radians).
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from typing import Annotated, Any, Literal, get_args

from pydantic import ValidationError, ValidatorFunctionWrapHandler, WrapValidator
from pydantic.fields import FieldInfo

Dimension = Literal["length", "angle", "volume"]

#: Suffix -> what it measures, and the factor to the unit of the settings: metres, radians, cubic metres.
SUFFIXES: dict[str, tuple[Dimension, float]] = {
    "m": ("length", 1.0),
    "cm": ("length", 1e-2),
    "mm": ("length", 1e-3),
    "um": ("length", 1e-6),
    "rad": ("angle", 1.0),
    "deg": ("angle", math.pi / 180.0),
    "°": ("angle", math.pi / 180.0),
    "ml": ("volume", 1e-6),
    "mL": ("volume", 1e-6),
    "cl": ("volume", 1e-5),
    "dl": ("volume", 1e-4),
    "l": ("volume", 1e-3),
    "L": ("volume", 1e-3),
}
#: What an error line shows of each dimension.
EXAMPLES: dict[Dimension, str] = {
    "length": "a length in m, cm or mm, such as 0.4m, 12cm or 55mm",
    "angle": "an angle in deg or rad, such as 30deg or 0.5rad",
    "volume": "a volume in ml, cl or l, such as 150ml or 0.5l",
}
#: The number is an atomic group: no digit of a plain number can be taken for a suffix.
_QUANTITY = re.compile(
    r"\s*(?P<number>(?>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?))\s*(?P<suffix>\S.*?)\s*"
)
#: A number with a decimal comma, and its unit.
_COMMA = re.compile(r"(?P<whole>[+-]?[0-9]+),(?P<part>[0-9]+)(?P<rest>(?:[eE][+-]?[0-9]{1,3})?\s*(?:[^\W\d_]{1,3}|°)?)")


def decimal_hint(value: object) -> str:
    """Return a hint for a number that is written with a comma, `` (with a decimal point: 0.5)``; '' for others."""
    match = _COMMA.fullmatch(value.strip()) if isinstance(value, str) else None
    return f" (with a decimal point: {match['whole']}.{match['part']}{match['rest']})" if match else ""


def quantity(value: object, dimension: Dimension) -> object:
    """Return a quantity in the unit of the settings.

    Parameters
    ----------
    value : object
        A number with a suffix of `SUFFIXES` as text. Anything else, also a number as text, is returned as it is.
    dimension : str
        What it has to measure.

    Returns
    -------
    float or object
        The number closest to the written one: ``35mm`` is 0.035.

    Raises
    ------
    ValueError
        Where the suffix is unknown or measures something else: ``expected ..., found ...``.
    """
    match = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    kind, factor = SUFFIXES.get(match["suffix"], (None, 0.0))
    if kind != dimension:
        found = repr(value) if kind is None else f"{value!r}, {_with_article(kind)}"
        raise ValueError(f"expected {EXAMPLES[dimension]}, found {found}{decimal_hint(value)}")
    # In decimals, as it is written: 35 * 0.001 is not 0.035 in binary.
    return float(Decimal(match["number"]) * Decimal(repr(factor)))


def length(value: object) -> object:
    """Return a length [m], such as 0.12 for ``12cm``; as `quantity` does."""
    return quantity(value, "length")


def angle(value: object) -> object:
    """Return an angle [rad], such as 0.5236 for ``30deg``; as `quantity` does."""
    return quantity(value, "angle")


def volume(value: object) -> float:
    """Return a volume [m^3], such as 1.5e-4 for ``150ml``; it always has its unit behind it.

    Raises
    ------
    ValueError
        Where it is no text with a unit of volume, or not above 0: ``expected ..., found ...``.
    """
    found = quantity(value, "volume")
    if found is value or not isinstance(found, float) or not 0.0 < found < math.inf:
        raise ValueError(f"expected {EXAMPLES['volume']}, found {str(value)[:40]!r}{decimal_hint(value)}")
    return found


def volume_text(cubic_metres: float) -> str:
    """Return a volume as people write it, rounded to four digits: ``250ml``, ``1.5l``."""
    litres = cubic_metres / SUFFIXES["l"][1]
    return f"{1e3 * litres:.4g}ml" if litres < 1.0 else f"{litres:.4g}l"


def shown(value: float, dimension: Dimension) -> str:
    """Return a quantity as error lines show it, such as ``0.5 m`` or ``0.5236 rad (30deg)``."""
    if dimension == "volume":
        return volume_text(value)
    if dimension == "length":
        return f"{value:.6g} m"
    return f"{value:.6g} rad ({degrees(value)})" if value else "0 rad"


def degrees(radians: float) -> str:
    """Return an angle in degrees, such as ``30deg``."""
    return f"{round(math.degrees(radians), 3):g}deg"


def _within_limits(value: object, handler: ValidatorFunctionWrapHandler, dimension: Dimension) -> object:
    """Validate a quantity; a limit that it breaks is said with its unit."""
    found = quantity(value, dimension)
    try:
        return handler(found)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        limit = next((value for name, value in first.get("ctx", {}).items() if name in ("ge", "gt", "le", "lt")), None)
        if limit is None or not isinstance(found, int | float):
            raise
        words = first["msg"].removeprefix("Input should be ").rpartition(" ")[0]
        typed = (
            repr(value) if isinstance(value, str) else shown(found, dimension) + _with_a_unit(found, limit, dimension)
        )
        raise ValueError(f"expected {words} {shown(limit, dimension)}, found {typed}") from error


def _with_a_unit(found: float, limit: float, dimension: Dimension) -> str:
    """Return a hint at the unit that a plain number too large was meant in, such as `` (is it 30deg?)``, or ''.

    A number of more digits than people type was converted from one with a unit, as those of a command line are.
    """
    if float(f"{found:g}") != found:
        return ""
    for suffix in {"angle": ("deg",), "length": ("cm", "mm"), "volume": ()}[dimension]:
        if abs(found) > abs(limit) >= abs(found) * SUFFIXES[suffix][1]:
            return f" (is it {found:g}{suffix}?)"
    return ""


#: Validators of a field's type, by which its dimension is known (`dimension_of`). In an `Annotated` type they stand
#: behind its limits, ``Annotated[float, Field(le=1.0), LENGTH]``.
LENGTH = WrapValidator(lambda value, handler: _within_limits(value, handler, "length"))
ANGLE = WrapValidator(lambda value, handler: _within_limits(value, handler, "angle"))
_READERS: tuple[tuple[WrapValidator, Dimension], ...] = ((LENGTH, "length"), (ANGLE, "angle"))

#: A length [m] and an angle [rad] in settings.
Length = Annotated[float, LENGTH]
Angle = Annotated[float, ANGLE]


def dimension_of(field: FieldInfo) -> Dimension | None:
    """Return what a field's numbers measure, also those of a pair; None for plain numbers and other types."""
    return _dimension(field.metadata) or _dimension(field.annotation)


def _dimension(kind: Any) -> Dimension | None:
    for reader, dimension in _READERS:
        if kind is reader:
            return dimension
    parts = kind if isinstance(kind, list | tuple) else get_args(kind)
    return next((found for part in parts if (found := _dimension(part)) is not None), None)


def _with_article(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
