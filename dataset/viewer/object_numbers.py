"""What a depth and a polarisation camera measured of each object of a view, as columns of the page's table."""

from __future__ import annotations

from typing import Any

from ..depth_cameras.errors import FAR, RIGHT
from ..format.views_table import ViewRow

#: Fields of the index, their titles, and whether they are fractions.
_COLUMNS = (
    ("sensor_missing", "no depth", True),
    ("sensor_right", f"of the rest within {1e3 * RIGHT:g} mm", True),
    ("sensor_behind", f"over {1e3 * FAR:g} mm behind", True),
    ("sensor_front", "in front", True),
    ("sensor_rim", "no depth: rim over inside", False),
    ("polarisation_degree", "degree of polarisation", True),
)


def object_numbers(row: ViewRow) -> dict[str, Any]:
    """Return titles of columns, and texts by object, as a JSON record; both empty without such a camera."""
    known = [
        (title, values, percent) for name, title, percent in _COLUMNS if (values := getattr(row, name)) is not None
    ]
    texts = {
        number: [_text(values[place], percent) for _, values, percent in known]
        for place, number in enumerate(row.object_ids)
    }
    return {"titles": [title for title, _, _ in known], "rows": texts if known else {}}


def _text(value: float | None, percent: bool) -> str:
    if value is None:  # too few pixels
        return "-"
    return f"{100.0 * value:.1f} %" if percent else f"{value:.2f}"
