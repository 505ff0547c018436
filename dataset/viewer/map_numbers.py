"""One map of a view as an array of few bytes, with what a page has to know to colour and to read it."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from ...core.images import depth_colours

#: Steps of a number that is stored in 16 bits [1]: 0 is none.
_STEPS = 65534
#: Finest step of depths [m], of disparities [px] and of flow [px]: far below what a screen shows.
DEPTH_STEP, _DISPARITY_STEP, _FLOW_STEP = 1e-4, 1.0 / 64.0, 1.0 / 16.0
#: Number of a signed value that is none, and the largest one.
_NO_VALUE, _LARGEST = -32768, 32767


@dataclass(frozen=True, eq=False)
class LabelMap:
    """One map of one eye."""

    name: str  #: unique in a view, such as ``left/depth``
    title: str
    group: str  #: of the list that it stands in
    kind: str  #: ``ids``, ``number``, ``signed``, ``angle``, ``vector``, ``colour``, ``class``, ``bits`` or ``flow``
    values: np.ndarray  #: (H, W) or (H, W, n), of 8 or 16 bits
    step: float = 1.0  #: a stored number times it is the label's
    unit: str = ""
    low: float = 0.0  #: ends of the colours, in the unit
    high: float = 1.0
    none: int | None = 0  #: stored number that means that there is no value
    names: tuple[tuple[str, str], ...] = field(default=())  #: of classes or bits, each with its colour

    @property
    def eye(self) -> str:
        """The camera whose picture it lies on."""
        return self.name.split("/")[0]


def ids_map(name: str, title: str, group: str, ids: np.ndarray) -> LabelMap:
    """Return instance ids."""
    return LabelMap(name, title, group, "ids", ids.astype(np.uint16))


def depth_map(name: str, title: str, group: str, Z: np.ndarray, ids: np.ndarray) -> LabelMap:
    """Return depths in steps of 0.1 mm, or larger ones where a far wall needs them; near is bright."""
    near, far = depth_colours(Z, ids)[1]
    values, step = stepped(np.where(np.isfinite(Z), Z, 0.0), DEPTH_STEP)
    return LabelMap(name, title, group, "number", values, step, "m", low=far, high=near)


def disparity_map(name: str, title: str, disparity: np.ndarray) -> LabelMap:
    """Return disparities, coloured over their own range."""
    values, step = stepped(disparity, _DISPARITY_STEP)
    shown = disparity[disparity > 0.0]
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 1.0)
    return LabelMap(name, title, "pair", "number", values, step, "px", low, high)


def unit_map(name: str, title: str, group: str, values: np.ndarray) -> LabelMap:
    """Return numbers from 0 to 1."""
    return LabelMap(name, title, group, "number", np.rint(255.0 * values).astype(np.uint8), 1.0 / 255.0, none=None)


def colour_map(name: str, title: str, group: str, values: np.ndarray) -> LabelMap:
    """Return three numbers from 0 to 1 a pixel, which a page shows as a colour."""
    stored = np.rint(255.0 * np.clip(values.astype(np.float32), 0.0, 1.0)).astype(np.uint8)
    return LabelMap(name, title, group, "colour", stored, 1.0 / 255.0, none=None)


def coordinates_map(name: str, title: str, values: np.ndarray) -> LabelMap:
    """Return object coordinates: 0 where there is no object, else 1 to 255."""
    there = np.isfinite(values)
    stored = np.where(there, 1.0 + 254.0 * np.clip(np.nan_to_num(values), 0.0, 1.0), 0.0)
    return LabelMap(name, title, "objects", "colour", np.rint(stored).astype(np.uint8), 1.0 / 254.0)


def flow_map(name: str, title: str, group: str, flow: np.ndarray) -> LabelMap:
    """Return flow in 16ths of a pixel; -32768 where there is none."""
    steps = np.clip(np.nan_to_num(flow) / _FLOW_STEP, -32767, 32767)
    stored = np.where(np.isfinite(flow), np.rint(steps), -32768).astype(np.int16)
    lengths = np.linalg.norm(flow, axis=-1)
    lengths = lengths[np.isfinite(lengths)]
    high = float(np.percentile(lengths, 95)) if lengths.size else 1.0
    return LabelMap(name, title, group, "flow", stored, _FLOW_STEP, "px", high=max(high, 1.0), none=-32768)


def signed_map(name: str, title: str, group: str, values: np.ndarray, finest: float, end: float, unit: str) -> LabelMap:
    """Return numbers of either sign in steps, NaN for none; `end` is where the colours end on both sides."""
    known = np.isfinite(values)
    shown = np.where(known, values, 0.0)
    step = max(finest, float(np.abs(shown).max(initial=0.0)) / _LARGEST)
    stored = np.where(known, np.rint(shown / step), _NO_VALUE).astype(np.int16)
    return LabelMap(name, title, group, "signed", stored, step, unit, -end, end, none=_NO_VALUE)


def stepped(values: np.ndarray, finest: float) -> tuple[np.ndarray, float]:
    """Return positive numbers as multiples of a step, (H, W) uint16, and the step: the finest one that fits."""
    step = max(finest, float(values.max(initial=0.0)) / _STEPS)
    return np.rint(values / step).astype(np.uint16), step


def reduced(one: LabelMap, width: int, height: int) -> np.ndarray:
    """Return a map's numbers at another size: each pixel is one of the stored ones."""
    if one.values.shape[:2] == (height, width):
        return one.values
    return cv2.resize(one.values, (width, height), interpolation=cv2.INTER_NEAREST)
