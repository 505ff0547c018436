"""Arrays as 8-bit pictures: radiance as sRGB, depth, normals and ids as colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from .polarisation import angle_of_linear_polarisation, degree_of_linear_polarisation

#: Colours of pixels that show nothing, and of the table.
NOTHING, TABLE_COLOUR = (45, 45, 48), (105, 105, 110)
#: Colours of the reasons why a depth camera has a depth or none, in the order of `sensor_valid.png` (docs/format.md):
#: unseen, measured, no match, out of range, saturated, unlit, hidden.
REASON_COLOURS = (
    NOTHING,
    (70, 200, 100),
    (230, 80, 70),
    (250, 190, 50),
    (245, 245, 245),
    (185, 105, 225),
    (70, 150, 235),
)
#: Instance ids of the table and of the first object (`procedural.description.scene`).
_TABLE_ID, _FIRST_OBJECT_ID = 1, 2
#: First id of a room's surfaces (`procedural.description.surroundings`), and colours of these in turn: dim greys.
_FIRST_ROOM_ID = 65248
_ROOM_COLOURS = ((45, 45, 48), (58, 58, 60), (50, 46, 44), (40, 40, 44), (48, 54, 66), (74, 74, 66), (66, 58, 70))
#: Fifteen colours far apart in hue and lightness, red, green, blue; further objects repeat them.
_COLOURS = (
    (230, 80, 70),
    (70, 150, 235),
    (250, 190, 50),
    (90, 200, 100),
    (185, 105, 225),
    (60, 205, 205),
    (245, 130, 45),
    (240, 120, 185),
    (165, 210, 60),
    (115, 115, 235),
    (200, 155, 105),
    (25, 145, 125),
    (255, 215, 150),
    (175, 65, 110),
    (160, 195, 235),
)


@dataclass(frozen=True)
class Tone:
    """How linear values become those that sRGB encodes: white balance and a shoulder for highlights."""

    #: Factors on red, green and blue that keep the luminance of white; "grey-world" makes the picture's mean grey.
    balance: tuple[float, float, float] | Literal["grey-world"] = (1.0, 1.0, 1.0)
    #: Linear value that is encoded as white. Above 1, values from `KNEE` on are compressed, so that a window shows a
    #: view; those below do not change.
    white: float = 1.0


#: Linear value at which the shoulder begins [1]: sRGB 217 of 255. A white wall in the light of the meter is below.
KNEE = 0.7
#: No colour is balanced by more than this factor between two channels: that of a light bulb against daylight (as for
#: `dataset.cameras.colour`).
_MOST_BALANCE = 4.0
#: Luminance of linear Rec.709.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LINEAR = Tone()


def grey_world(linear: np.ndarray, exposure: float) -> tuple[float, float, float]:
    """Return the factors on red, green and blue that make the mean of a picture grey (Buchsbaum 1980).

    Values above white count as white: a window is no part of the room's colour. The luminance of white is kept.

    Parameters
    ----------
    linear : (H, W, 3) float
        Linear Rec.709 radiance.
    exposure : float
        Factor from radiance to linear values.
    """
    mean = np.clip(linear.astype(np.float64) * exposure, 0.0, 1.0).reshape(-1, 3).mean(axis=0)
    return balance_of(mean)


def common_tone(tone: Tone, left: np.ndarray, exposure: float) -> Tone:
    """Return the tone of both pictures of a pair: what follows from a picture's mean follows from the left one's."""
    return Tone(grey_world(left, exposure), tone.white) if tone.balance == "grey-world" else tone


def balance_of(light: np.ndarray) -> tuple[float, float, float]:
    """Return the factors on red, green and blue that make a light, (3,) linear Rec.709, grey; they keep luminance."""
    light = np.maximum(light, light.max() / _MOST_BALANCE)
    if not light.max() > 0.0:
        return 1.0, 1.0, 1.0
    gains = 1.0 / light
    red, green, blue = (gains / (_LUMINANCE @ gains)).tolist()
    return red, green, blue


def toned(linear: np.ndarray, exposure: float, tone: Tone = LINEAR) -> np.ndarray:
    """Return the linear values in [0, 1] that sRGB encodes, (H, W, 3) float64.

    Above the knee k the shoulder is k + (1 - k) log(1 + a t) / log(1 + a) with t from 0 to 1 between k and white; a
    makes its slope 1 at the knee.
    """
    gains = grey_world(linear, exposure) if tone.balance == "grey-world" else tone.balance
    value = linear.astype(np.float64) * exposure
    if gains != (1.0, 1.0, 1.0):
        value *= np.array(gains)
    if tone.white <= 1.0:
        return np.clip(value, 0.0, 1.0)
    span = (tone.white - KNEE) / (1.0 - KNEE)
    a = _shoulder(span)
    t = np.clip((value - KNEE) / (tone.white - KNEE), 0.0, 1.0)
    shoulder = KNEE + (1.0 - KNEE) * np.log1p(a * t) / np.log1p(a)
    return np.where(value > KNEE, shoulder, np.maximum(value, 0.0))


def _shoulder(span: float) -> float:
    """Return a with a / log(1 + a) = span, by fixed-point iteration, which contracts for spans above 1."""
    a = 2.0 * span
    for _ in range(100):
        a = span * np.log1p(a)
    return float(a)


def srgb8(linear: np.ndarray, exposure: float, tone: Tone = LINEAR) -> np.ndarray:
    """Return the 8-bit picture of a pinhole camera.

    Radiance times exposure, clipped to [0, 1] or as the tone says, through the sRGB curve (IEC 61966-2-1:1999), rounded
    to 255 steps.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear Rec.709 radiance.
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.
    tone : Tone
        White balance and highlights; by default none, and highlights are clipped.

    Returns
    -------
    (H, W, 3) uint8
        Red, green, blue.
    """
    return np.rint(srgb_curve(toned(linear, exposure, tone)) * 255.0).astype(np.uint8)


def srgb_curve(value: np.ndarray) -> np.ndarray:
    """Return linear values in [0, 1] through the sRGB curve (IEC 61966-2-1:1999)."""
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1.0 / 2.4) - 0.055)


def depth_colours(
    Z: np.ndarray, ids: np.ndarray, limits: tuple[float, float] | None = None
) -> tuple[np.ndarray, tuple[float, float]]:
    """Return depth as colours, (H, W, 3) uint8, and their range [m]: of the visible objects, else of all surfaces."""
    hit = np.isfinite(Z)
    objects = hit & (ids >= _FIRST_OBJECT_ID) & (ids < _FIRST_ROOM_ID)
    shown = objects if objects.any() else hit
    if not shown.any():
        return np.full((*Z.shape, 3), NOTHING, np.uint8), (0.0, 0.0)
    near, far = limits or (float(Z[shown].min()), float(Z[shown].max()))
    level = (far - np.where(hit, Z, far)) / max(far - near, 1e-6)
    level = np.rint(255 * np.clip(level, 0.0, 1.0)).astype(np.uint8)
    colours = cv2.applyColorMap(level, cv2.COLORMAP_VIRIDIS)[..., ::-1].copy()
    colours[~hit] = NOTHING
    return colours, (near, far)


def difference_colours(difference: np.ndarray, most: float) -> np.ndarray:
    """Return differences as colours, (H, W, 3) uint8: blue below 0, white at 0, red above; those of `most` are pure."""
    known = np.isfinite(difference)
    level = np.clip(np.where(known, difference, 0.0) / most, -1.0, 1.0)[..., None]
    colour = np.where(level > 0.0, np.array([178, 24, 43]), np.array([33, 102, 172]))  # of ColorBrewer's RdBu
    colours = np.rint(255.0 + np.abs(level) * (colour - 255.0)).astype(np.uint8)
    colours[~known] = NOTHING
    return colours


def reason_colours(reasons: np.ndarray) -> np.ndarray:
    """Return the colour of each of the reasons in `sensor_valid.png`, (..., 3) uint8 for numbers of any shape."""
    return np.array(REASON_COLOURS, np.uint8)[np.minimum(reasons, len(REASON_COLOURS) - 1)]


def polarisation_colours(stokes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return pictures of the degree and of the angle of linear polarisation, each (H, W, 3) uint8.

    Parameters
    ----------
    stokes : (H, W, 3 or 4, 1) float
        Stokes vectors of one channel. The degree is grey, from black for 0 to white for 1. The angle is a hue, red for
        0 and cyan for a right angle, as bright as the degree.
    """
    degree = np.clip(degree_of_linear_polarisation(stokes)[..., 0], 0.0, 1.0)
    turn = (angle_of_linear_polarisation(stokes)[..., 0] / np.pi) % 1.0
    shown = srgb_curve(degree)
    grey = np.rint(255.0 * shown).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=-1), hue_colours(turn, shown)


def hue_colours(turn: np.ndarray, brightness: np.ndarray) -> np.ndarray:
    """Return hues, from red at 0 to red again at 1, as bright as numbers from 0 to 1: (H, W, 3) uint8."""
    # OpenCV's hues of 8 bits go to 180.
    hue = (np.rint(180.0 * turn).astype(np.int64) % 180).astype(np.uint8)
    value = np.rint(255.0 * brightness).astype(np.uint8)
    return cv2.cvtColor(np.stack([hue, np.full_like(hue, 255), value], axis=-1), cv2.COLOR_HSV2RGB)


def normal_colours(normal: np.ndarray) -> np.ndarray:
    """Return normals as colours, (H, W, 3) uint8: right is red, up is green, towards the camera is blue."""
    colours = np.rint(127.5 * (1.0 + normal * np.array([1.0, -1.0, -1.0]))).astype(np.uint8)
    colours[(normal == 0.0).all(axis=-1)] = NOTHING
    return colours


def id_colours(ids: np.ndarray) -> np.ndarray:
    """Return instance ids as distinct colours, (H, W, 3) uint8; the table is grey, and a room is dim."""
    known, index = np.unique(ids, return_inverse=True)
    table = np.array([NOTHING if i == 0 else id_colour(int(i)) for i in known], np.uint8).reshape(-1, 3)
    return table[index].reshape(*ids.shape, 3)


def id_colour(object_id: int) -> tuple[int, int, int]:
    """Return the colour of an instance id: red, green, blue."""
    if object_id >= _FIRST_ROOM_ID:
        return _ROOM_COLOURS[(object_id - _FIRST_ROOM_ID) // 32 % len(_ROOM_COLOURS)]
    return _COLOURS[(object_id - _FIRST_OBJECT_ID) % len(_COLOURS)] if object_id > _TABLE_ID else TABLE_COLOUR
