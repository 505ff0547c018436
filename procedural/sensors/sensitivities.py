"""Sensitivities of sensors by name, as `colour-science` has them, and from CSV files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...core.folders import regular_content
from ...core.setting_errors import shortened, suggest
from ...core.user_text import is_number
from ..description.sensitivities import Sensitivities
from .colour_matrix import NM, check_package, colour_matrix, colour_science
from .devices import NONE

_SOURCE = (
    "measured at the National Physical Laboratory: Darrodi et al., Reference data set for camera spectral sensitivity "
    "estimation, JOSA A 32(3), 2015, by colour-science; each channel is scaled to a maximum of 1. Colour matrix: "
    "docs/cameras.md"
)
#: By name: what `colour-science` calls them.
PUBLISHED = {"nikon-d5100": "Nikon 5100 (NPL)", "sigma-sd-merrill": "Sigma SDMerill (NPL)"}
_FILE = ".csv"
#: Wavelengths that curves must reach [nm], those of the narrower published set, and their largest distance: a channel
#: is 60 nm wide or more.
VISIBLE, FARTHEST = (400.0, 680.0), 20.0
#: Wavelengths that a picture has [nm].
RENDERED = (360.0, 830.0)
#: Most rows of a file [1], and its largest size [bytes].
_ROWS, _SIZE = 2000, 200_000
_WHERE = "sensors.sensitivities"


def check_sensitivities(name: str | Path, where: str = _WHERE) -> None:
    """Raise InputError as `sensitivities` does, without what takes a second: neither import nor fit."""
    text = str(name)
    if text == NONE:
        return
    if not text.endswith(_FILE) and text not in PUBLISHED:
        expected = f"one of {', '.join([NONE, *PUBLISHED])}, or a CSV file{suggest(text.lower(), list(PUBLISHED))}"
        raise InputError(where, expected, shortened(text))
    if text.endswith(_FILE):
        _read(Path(text))
    check_package(where)


def sensitivities(name: str | Path, where: str = _WHERE) -> Sensitivities | None:
    """Return the sensitivities of a sensor by its name, or from a CSV file; None for ``none``.

    Parameters
    ----------
    name : str or Path
        A name of `PUBLISHED`, ``none``, or a file that ends in ``.csv``: in each line a wavelength [nm] and what red,
        green and blue give for the same energy, in any unit; the first line may name the columns. Wavelengths rise,
        from `VISIBLE` or beyond on both sides, by `FARTHEST` or less. Between them curves are linear, beyond them 0.
    where : str
        The setting, for errors.

    Raises
    ------
    InputError
        Where there is no such sensor, the package is missing, or the file cannot be read or has a wrong line.
    """
    check_sensitivities(name, where)
    text = str(name)
    if text == NONE:
        return None
    if text.endswith(_FILE):
        return _sensor("own", "a file of one's own", *_read(Path(text)), where)
    found = colour_science(where).characterisation.MSDS_CAMERA_SENSITIVITIES[PUBLISHED[text]]
    return _sensor(text, f"{PUBLISHED[text]}: {_SOURCE}", found.wavelengths, found.values, where)


def _sensor(name: str, source: str, nm: np.ndarray, curves: np.ndarray, where: str) -> Sensitivities:
    on_grid = np.stack([np.interp(NM, nm, one, left=0.0, right=0.0) for one in curves.T], axis=1)
    white, matrix = colour_matrix(on_grid, where)
    red, green, blue = (tuple(one.tolist()) for one in curves.T)
    first, second, third = (tuple(row) for row in matrix.tolist())
    return Sensitivities(
        name=name,
        source=source,
        wavelengths=tuple(nm.tolist()),
        red=red,
        green=green,
        blue=blue,
        white=(float(white[0]), 1.0, float(white[2])),
        matrix=(first, second, third),
    )


def _read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return wavelengths (n,) and curves (n, 3) of a CSV file; InputError for the first wrong line."""
    try:
        content = regular_content(path, "with sensitivities", _SIZE, f"a CSV file of at most {_SIZE} bytes")
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(path, "a CSV file in UTF-8", "other bytes") from error
    rows: list[list[float]] = []
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), start=1):
        cells = [cell.strip() for cell in line.split(",")]
        if not any(cells) or (number == 1 and not any(is_number(cell) for cell in cells)):
            continue
        rows.append(_row(f"{path}, line {number}", cells, rows))
    _check_reach(path, [row[0] for row in rows])
    table = np.array(rows)
    for channel, name in enumerate(("red", "green", "blue"), start=1):
        if not table[:, channel].any():
            raise InputError(path, f"light that {name} sees", "zeros alone")
    if np.linalg.matrix_rank(table[:, 1:]) < 3:
        raise InputError(path, "three different curves", "a channel that the others have in them")
    return table[:, 0], table[:, 1:]


def _row(where: str, cells: list[str], above: list[list[float]]) -> list[float]:
    if len(cells) != 4 or not all(is_number(cell) for cell in cells):
        raise InputError(where, "a wavelength [nm] and values of red, green and blue", shortened(",".join(cells)))
    values = [float(cell) for cell in cells]
    if not all(math.isfinite(value) and value >= 0.0 for value in values):
        raise InputError(where, "finite numbers that are not negative", shortened(",".join(cells)))
    nm = values[0]
    if above and not above[-1][0] < nm <= above[-1][0] + FARTHEST:
        expected = f"a wavelength after {above[-1][0]:g} nm, by {FARTHEST:g} nm or less"
        raise InputError(where, expected, f"{nm:g} nm")
    if len(above) >= _ROWS:
        raise InputError(where, f"at most {_ROWS} wavelengths", "more")
    return values


def _check_reach(path: Path, nm: list[float]) -> None:
    low, high = VISIBLE
    if not nm or nm[0] > low or nm[-1] < high:
        found = f"{nm[0]:g} to {nm[-1]:g} nm" if nm else "none"
        raise InputError(path, f"wavelengths from {low:g} nm or less to {high:g} nm or more", found)
