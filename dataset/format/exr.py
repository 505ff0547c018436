"""OpenEXR files of named channels, float32 or half."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import OpenEXR

from ...core.errors import InputError
from ...core.silence import quiet

#: Ids are stored as floats, which more programs read. Float32 represents every integer below 2^24 exactly.
_LARGEST_WHOLE = 1 << 24
#: Largest number of a half: it represents all whole numbers up to 2048, and multiples of 32 up to this.
_LARGEST_HALF = 65504
_ALL_WHOLE = 2048
#: Errors of the system on writing.
_REFUSED = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO)


def write_exr(path: Path, channels: dict[str, np.ndarray], attributes: Mapping[str, str] | None = None) -> None:
    """Write channels, each (H, W), with ZIP compression; the same channels give the same bytes.

    Float16 arrays are written as half, everything else as float32. Infinities and NaN survive. The header has no date
    and no name, so that files can be compared; `attributes` are added to it.
    """
    shapes = {values.shape for values in channels.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 2:
        raise ValueError(f"{path}: expected channels of one shape (H, W), got {shapes}")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage} | dict(attributes or {})
    stored = {name: OpenEXR.Channel(_stored(values)) for name, values in channels.items()}
    try:
        OpenEXR.File(header, stored).write(str(path))
    except RuntimeError as error:  # the library passes on the system's message, without its number
        number = next((number for number in _REFUSED if os.strerror(number) in str(error)), None)
        if number is None:
            raise
        raise OSError(number, os.strerror(number), str(path)) from error


def read_exr(path: Path) -> dict[str, np.ndarray]:
    """Return the channels of a file, each (H, W) float32 or float16; InputError where it is missing or damaged."""
    if not path.is_file():
        raise InputError(path, "a readable EXR file", "none")
    try:
        with quiet(), OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}  # their own memory
    except (RuntimeError, ValueError) as error:  # a truncated file raises either
        raise InputError(path, "an undamaged EXR file", str(error).replace("\n", " ")) from error
    for name, values in channels.items():
        if values.dtype not in (np.float32, np.float16):
            raise InputError(f"{path}: channel {name}", "float32 or half", values.dtype)
    return channels


def read_channel(path: Path, name: str) -> np.ndarray:
    """Return one channel of a file, (H, W) float32 or float16; InputError where it cannot be read, or has none such.

    It takes half the time of `read_exr` for `geometry.exr`: the other channels are inflated, but not copied.
    """
    if not path.is_file():
        raise InputError(path, "a readable EXR file", "none")
    try:
        with quiet():
            file = OpenEXR.InputFile(str(path))
            header = file.header()
            data = file.channel(name) if name in header["channels"] else b""
            file.close()
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        raise InputError(path, "an undamaged EXR file", str(error).replace("\n", " ")) from error
    if name not in header["channels"]:
        raise InputError(path, f"a channel {name}", f"{sorted(header['channels'])}")
    low, high = header["dataWindow"].min, header["dataWindow"].max
    shape = (high.y - low.y + 1, high.x - low.x + 1)
    kind = {2: np.float16, 4: np.float32}.get(len(data) // (shape[0] * shape[1]))
    if kind is None:
        raise InputError(f"{path}: channel {name}", "float32 or half", f"{len(data)} bytes of {shape[1]}x{shape[0]} px")
    return np.frombuffer(data, kind).reshape(shape).copy()  # the buffer itself cannot be written to


def exr_channels(path: Path) -> tuple[str, ...]:
    """Return the names of a file's channels, by its header; InputError where it is damaged."""
    try:
        with quiet():
            file = OpenEXR.InputFile(str(path))
            names = tuple(sorted(file.header()["channels"]))
            file.close()
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        raise InputError(path, "an undamaged EXR file", str(error).replace("\n", " ")) from error
    return names


def exr_attributes(path: Path) -> dict[str, str]:
    """Return the texts in a file's header; InputError where the file is missing or damaged."""
    if not path.is_file():
        raise InputError(path, "a readable EXR file", "none")
    try:
        with quiet(), OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            return {name: value for name, value in file.header().items() if isinstance(value, str)}
    except (RuntimeError, ValueError) as error:
        raise InputError(path, "an undamaged EXR file", str(error).replace("\n", " ")) from error


def stacked(channels: dict[str, np.ndarray], names: str, path: Path) -> np.ndarray:
    """Return channels stacked along the last axis, (H, W, n).

    Parameters
    ----------
    channels : dict of (H, W) arrays
        From `read_exr`.
    names : str
        Prefix and last letters: ``"noisy.RGB"`` is ``noisy.R``, ``noisy.G``, ``noisy.B``.
    path : Path
        The file, for the error where a channel is missing.
    """
    prefix, _, letters = names.rpartition(".")
    full = [f"{prefix}.{letter}" if prefix else letter for letter in letters]
    return np.stack([channel(channels, name, path) for name in full], axis=-1)


def unstacked(values: np.ndarray, names: str) -> dict[str, np.ndarray]:
    """Return the channels of an array, (H, W, n), by name, as `stacked` reads them."""
    prefix, _, letters = names.rpartition(".")
    return {f"{prefix}.{letter}" if prefix else letter: values[..., i] for i, letter in enumerate(letters)}


def channel(channels: dict[str, np.ndarray], name: str, path: Path) -> np.ndarray:
    """Return one channel, (H, W); InputError where the file has none of that name."""
    if name not in channels:
        raise InputError(path, f"a channel {name}", f"{sorted(channels)}")
    return channels[name]


def half_numbers(values: np.ndarray, field: str) -> np.ndarray:
    """Return whole numbers as half floats; ValueError for those that these do not hold exactly.

    They hold all up to 2048, and the ids of a room's surfaces.
    """
    if values.dtype.kind in "bu" and values.max(initial=0) <= _ALL_WHOLE:
        return values.astype(np.float16)
    whole = values.astype(np.int64)
    halves = np.minimum(whole, _LARGEST_HALF).astype(np.float16)
    wrong = halves.astype(np.int64) != whole
    if wrong.any():
        raise ValueError(f"{field}: expected at most 2048, or a room's id, got {values[wrong].max()}")
    return halves


def _stored(values: np.ndarray) -> np.ndarray:
    if values.dtype == np.float16:
        return np.ascontiguousarray(values)
    if np.issubdtype(values.dtype, np.integer) and values.size and int(values.max()) >= _LARGEST_WHOLE:
        raise ValueError(f"ids: expected below {_LARGEST_WHOLE}, got {values.max()}")
    return np.ascontiguousarray(values, dtype=np.float32)
