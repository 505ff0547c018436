"""Names with weights: ``[water, olive oil]``, ``{water: 3, olive oil: 1}``, or on a command line ``water=3``.

In settings they are texts, ``name`` or ``name=weight``, so a file and a command line have the same form.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from typing import Annotated

from pydantic import BeforeValidator

from .setting_errors import shortened, suggest
from .units import decimal_hint

#: Most names that an error line lists.
MOST_LISTED = 24


def _texts(value: object) -> object:
    """Return a mapping or a single name as a tuple of texts; ValueError for a weight that is none."""
    if isinstance(value, str):
        value = (value,)
    if isinstance(value, Mapping):
        value = tuple(_text(name, weight) for name, weight in value.items())
    if isinstance(value, list | tuple) and all(isinstance(item, str) for item in value):
        if not value:
            raise ValueError("expected at least 1 item, found 0")
        weights_of(value)
    return tuple(value) if isinstance(value, list) else value


def _text(name: object, weight: object) -> str:
    if isinstance(weight, bool) or not isinstance(weight, Real):
        raise ValueError(
            f"expected a number as the weight of {shortened(name)}, found {shortened(weight)}{decimal_hint(weight)}"
        )
    return str(name) if weight == 1 else f"{name}={float(weight):g}"


#: Names, each with a weight or without.
Weighted = Annotated[tuple[str, ...], BeforeValidator(_texts)]


def weights_of(entries: Iterable[str]) -> dict[str, float]:
    """Return the weight of each name; a name without one has weight 1.

    Raises
    ------
    ValueError
        ``expected ..., found ...``, where a weight is no positive number, or a name is there twice.
    """
    found: dict[str, float] = {}
    for entry in entries:
        name, equals, text = entry.rpartition("=")
        name, weight = (name.strip(), _number(text)) if equals else (entry.strip(), 1.0)
        if not 0.0 < weight < math.inf:
            raise ValueError(f"expected a weight above 0 for {name}, found {text.strip()!r}{decimal_hint(text)}")
        if name in found:
            raise ValueError(f"expected each name once, found {name!r} twice")
        found[name] = weight
    return found


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def unknown_names(
    names: Iterable[str], known: Sequence[str], others: Mapping[str, str] | None = None
) -> tuple[str, str] | None:
    """Return what was expected and what was found where names are not known, all of them; None where all are.

    Each unknown name has the known one beside it that ``others`` has for it (in lower case), or that is spelt most
    like it.
    """
    wrong = [name for name in names if name not in known]
    if not wrong:
        return None
    listed = ", ".join(known[:MOST_LISTED]) + (", ..." if len(known) > MOST_LISTED else "")
    hints = [suggest((others or {}).get(name.lower(), name), known) for name in wrong]
    return f"one of {listed}", ", ".join(f"{shortened(name)}{hint}" for name, hint in zip(wrong, hints, strict=True))


def check_names(names: Iterable[str], known: Sequence[str], others: Mapping[str, str] | None = None) -> None:
    """Raise ValueError, ``expected ..., found ...``, that names all unknown names and the nearest known ones."""
    if (wrong := unknown_names(names, known, others)) is not None:
        raise ValueError(f"expected {wrong[0]}, found {wrong[1]}")
