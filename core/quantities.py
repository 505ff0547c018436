"""Volumes as people write them, such as 150ml, 15cl or 0.5l, and back."""

from __future__ import annotations

import math
import re

#: Units of volume [m^3].
VOLUME_UNITS = {"ml": 1e-6, "cl": 1e-5, "dl": 1e-4, "l": 1e-3}
_NUMBER_AND_UNIT = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*([A-Za-z]+)\s*")


def parsed_volume(value: object) -> float:
    """Return a volume [m^3] from a text with its unit: ml, cl, dl or l.

    Raises
    ------
    ValueError
        ``expected ..., found ...``, where the text is no volume above 0.
    """
    match = _NUMBER_AND_UNIT.fullmatch(value) if isinstance(value, str) else None
    unit = VOLUME_UNITS.get(match[2].lower()) if match else None
    volume = float(match[1]) * unit if match and unit else 0.0
    if not 0.0 < volume < math.inf:
        raise ValueError(f"expected a volume such as 150ml, 15cl or 0.5l, found {str(value)[:40]!r}")
    return volume


def volume_text(volume: float) -> str:
    """Return a volume [m^3] in ml, rounded to four digits: 2.5e-4 is ``250ml``."""
    return (
        f"{volume / VOLUME_UNITS['ml']:.4g}ml" if volume < VOLUME_UNITS["l"] else f"{volume / VOLUME_UNITS['l']:.4g}l"
    )
