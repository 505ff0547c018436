"""Pictures in colour from OpenEXR files as programs write them: layers, parts, windows, luminance and chroma.

"Technical Introduction to OpenEXR" and "Reading and Writing OpenEXR Image Files" (openexr.com) define the names of
channels, the windows and the luminance-chroma form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from .assets import check_content
from .errors import InputError, cause_of
from .silence import quiet

#: OpenEXR's magic number 20000630.
EXR_MAGIC = b"\x76\x2f\x31\x01"
#: Layers that programs give the finished picture, and names of such parts, in lower case: Blender's Combined, Nuke's
#: rgba and main, Arnold's and V-Ray's beauty.
_LAYERS = ("", "combined", "rgba", "rgb", "beauty", "main", "color", "colour")
_NAMES = {"r": "r", "red": "r", "g": "g", "green": "g", "b": "b", "blue": "b", "y": "y", "ry": "ry", "by": "by"}
#: Luminance of Rec.709's primaries, which files without chromaticities have.
_REC709_Y = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True, eq=False)
class _Part:
    """A flat picture in a file."""

    number: int
    channels: dict[str, str]  #: r, g, b (or y, ry, by) -> name of the channel
    data: tuple[int, int, int, int]  #: left, top, right, bottom of the data window, the last ones included [px]
    shown: tuple[int, int, int, int]  #: the same of the display window


def read_exr_picture(path: Path, check_size: Callable[[int, int], None]) -> np.ndarray:
    """Return the picture in an OpenEXR file.

    The first part and the layer that hold a finished picture are read: red, green and blue, or luminance with or
    without chroma. What the data window leaves free of the display window is black, what lies outside is cut off.

    Parameters
    ----------
    path : Path
        The file. It is read without further threads: Mitsuba's own reader hangs in a process with one core.
    check_size : callable
        Is called with width and height before any pixel is read, and raises for those that are too large.

    Returns
    -------
    (h, w, 3) float32
        Red, green, blue as they are stored, first row at the top; may hold infinities and NaN.

    Raises
    ------
    InputError
        If the file cannot be read, is cut short, or has no such part.
    """
    import OpenEXR  # here, as every module of settings imports this one

    _check_magic(path)
    try:
        with quiet(), OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            part = _picture_part(path, file.parts)
        for left, top, right, bottom in (part.shown, part.data):
            check_size(right - left + 1, bottom - top + 1)
        # Zero threads beside our own: decoding then needs no second core.
        with quiet(), OpenEXR.File(str(path), separate_channels=True, num_threads=0) as file:
            found = file.parts[part.number].channels
            planes = {kind: found[name].pixels for kind, name in part.channels.items()}
    except InputError:
        raise
    except (RuntimeError, ValueError, KeyError, TypeError, IndexError) as error:
        # What the reader raises for damaged files; a file cut short reads as one without parts.
        text = "cut short" if isinstance(error, IndexError) else " ".join(str(error).split())
        raise InputError(path, "a whole OpenEXR file", f"a damaged one ({text})") from error
    return _in_display_window(part, _rgb(path, part, planes))


def _check_magic(path: Path) -> None:
    try:
        with path.open("rb") as file:
            start = file.read(64)
    except OSError as error:
        raise InputError(path, "a readable OpenEXR file", cause_of(error)) from error
    check_content(path, start)
    if not start.startswith(EXR_MAGIC):
        raise InputError(path, "an OpenEXR file", f"first bytes {start[:8]!r}" if start else "an empty file")


def _picture_part(path: Path, parts: list[Any]) -> _Part:
    """Return the part of a file, and the layer in it, that hold its picture."""
    from OpenEXR import scanlineimage, tiledimage

    found, seen = [], []
    for number, part in enumerate(parts):
        names = [channel.name for channel in part.header["channels"]]
        seen += names
        layers = _layers(names) if part.header.get("type", scanlineimage) in (scanlineimage, tiledimage) else {}
        for layer, channels in layers.items():
            rank = _rank(layer, str(part.header.get("name", "")), len(layers) * len(parts) == 1)
            found.append((rank, number, layer, channels))
    best = min(found, key=lambda item: item[:3]) if found else None
    if best is None:
        raise InputError(path, "a flat picture with channels R, G, B or Y", ", ".join(sorted(set(seen))) or "none")
    rank, number, _, channels = best
    rivals = {(item[1], item[2]) for item in found if item[0] == rank}
    if rank == len(_LAYERS) and len(rivals) > 1:
        listed = ", ".join(sorted(f"{parts[part].header.get('name', '')} {layer}".strip() for part, layer in rivals))
        raise InputError(path, "one layer, or one named Combined, rgba or beauty", listed)
    header = parts[number].header
    data = _window(header["dataWindow"])
    return _Part(number, channels, data, _window(header.get("displayWindow", header["dataWindow"])))


def _rank(layer: str, part: str, alone: bool) -> int:
    """Return how well a layer's name says that it is the finished picture; 0 is best."""
    last = layer.rpartition(".")[2].lower()
    if last in _LAYERS and (last or part.lower() in _LAYERS):
        return 0 if last == "" else _LAYERS.index(last)
    if alone:
        return 0
    # A part of its own name, such as "rgba", holds unnamed channels.
    return 1 if last == "" else len(_LAYERS)


def _layers(names: list[str]) -> dict[str, dict[str, str]]:
    """Return the layers of a part that are in colour or grey: layer -> (r, g, b or y, ry, by -> channel)."""
    layers: dict[str, dict[str, str]] = {}
    for name in names:
        layer, _, last = name.rpartition(".")
        kind = _NAMES.get(last.lower())
        if kind is not None:
            layers.setdefault(layer, {})[kind] = name
    complete = {}
    for layer, channels in layers.items():
        for kinds in (("r", "g", "b"), ("y", "ry", "by"), ("y",)):
            if channels.keys() >= set(kinds):
                complete[layer] = {kind: channels[kind] for kind in kinds}
                break
    return complete


def _window(corners: Any) -> tuple[int, int, int, int]:
    (left, top), (right, bottom) = ([int(value) for value in corner] for corner in corners)
    return left, top, right, bottom


def _rgb(path: Path, part: _Part, planes: dict[str, np.ndarray]) -> np.ndarray:
    """Return the pixels of the data window, (h, w, 3) float32."""
    left, top, right, bottom = part.data
    width, height = right - left + 1, bottom - top + 1
    for kind, plane in planes.items():
        if plane.dtype not in (np.float16, np.float32):
            raise InputError(path, f"half or float in channel {part.channels[kind]}", f"{plane.dtype}")
        if plane.shape != (height, width) and kind not in ("ry", "by"):
            shape = "x".join(str(side) for side in plane.shape[::-1])
            raise InputError(path, f"{width}x{height} pixels in channel {part.channels[kind]}", shape)
    wide = {kind: plane.astype(np.float32) for kind, plane in planes.items()}
    if "r" in wide:
        return np.stack([wide["r"], wide["g"], wide["b"]], axis=-1)
    Y = wide["y"]
    if "ry" not in wide:
        return np.repeat(Y[..., None], 3, axis=2)
    # Chroma is stored for every second pixel of every second row, as differences over the luminance.
    red, blue = ((_full(wide[kind], width, height) + 1.0) * Y for kind in ("ry", "by"))
    green = (Y - _REC709_Y[0] * red - _REC709_Y[2] * blue) / _REC709_Y[1]
    return np.stack([red, green, blue], axis=-1)


def _full(plane: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return a subsampled plane at full size; its samples lie at every second pixel, from the first."""
    if plane.shape == (height, width):
        return plane
    steps = height / plane.shape[0], width / plane.shape[1]
    x, y = np.meshgrid(np.arange(width) / round(steps[1]), np.arange(height) / round(steps[0]))
    grid = x.astype(np.float32), y.astype(np.float32)
    return cv2.remap(plane, *grid, interpolation=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _in_display_window(part: _Part, pixels: np.ndarray) -> np.ndarray:
    if part.data == part.shown:
        return pixels
    left, top, right, bottom = part.shown
    picture = np.zeros((bottom - top + 1, right - left + 1, 3), np.float32)
    x0, y0 = max(left, part.data[0]), max(top, part.data[1])
    x1, y1 = min(right, part.data[2]) + 1, min(bottom, part.data[3]) + 1
    if x1 > x0 and y1 > y0:
        inner = pixels[y0 - part.data[1] : y1 - part.data[1], x0 - part.data[0] : x1 - part.data[0]]
        picture[y0 - top : y1 - top, x0 - left : x1 - left] = inner
    return picture
