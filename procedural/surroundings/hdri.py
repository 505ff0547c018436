"""Environment maps from files.

A file holds a panorama as a camera sees it: row 0 is up, and the azimuth grows clockwise (seen from above) from the
left edge to the right. Our maps (`sphere`) grow counter-clockwise, so the columns are reversed: the picture's left
edge is at azimuth 0 (+x), its middle at azimuth pi (-x), and what stands to the right in the picture stands to the
right in the scene.
"""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
from scipy.ndimage import maximum_filter

from ...core.assets import Asset, checked_path
from ...core.errors import InputError
from ...core.folders import files_in
from ...core.silence import quiet
from .colour import luminance
from .metering import irradiance

SUFFIXES = (".exr", ".hdr")
#: Widest map that is read [px]; 16384 x 8192 pixels already take 1.5 GB.
MAX_WIDTH = 16384
#: Largest value that is read. Skies of most maps are about 1, and the unblocked disc of the sun is about 1e5 times as
#: bright (1.6e9 cd/m^2 over 1e4). Values over a thousand times more than that are damage.
MAX_RADIANCE = 1e8
# First bytes of the two formats: OpenEXR's magic number 20000630, and the Radiance picture's program line.
_EXR_MAGIC, _HDR_MAGIC = b"\x76\x2f\x31\x01", (b"#?RADIANCE", b"#?RGBE")
# The line of a Radiance picture's size, after the empty line that ends its header.
_HDR_SIZE = re.compile(rb"\n\n-Y ([0-9]{1,9}) \+X ([0-9]{1,9})\n")
# Sharpening filters (Lanczos) and lossy compression (DWA, B44) leave dips below zero beside bright lamps. The
# first lobe of Lanczos' kernel (three lobes) is 0.15 deep; DWA rounds in blocks of 8 pixels. Dips are accepted up
# to this fraction of the brightest value within so many pixels; the deepest of twelve Poly Haven maps is 0.2.
_DIP, _DIP_RANGE = 0.25, 8


def hdri_files(folder: Path) -> tuple[Path, ...]:
    """Return the environment maps directly in a folder, sorted by name; InputError where there are none."""
    return files_in(folder, "environment maps", SUFFIXES, below=False)


def read_hdri(item: Asset) -> np.ndarray:
    """Read an equirectangular environment map.

    EXR files go through the `OpenEXR` package: Mitsuba's own reader hangs in a process that may use one core only.
    Shallow dips below zero beside brighter pixels, as resampling and lossy compression leave them, are set to 0.

    Parameters
    ----------
    item : Asset
        An EXR file with channels R, G, B (A is ignored) or Y, half or float, or a Radiance HDR file.

    Returns
    -------
    (h, 2 * h, 3) float32
        Linear radiance in the file's own unit, laid out as `sphere` says.

    Raises
    ------
    InputError
        If the file is missing, changed, unreadable or truncated, has other channels, is not twice as wide as high,
        has values that are not finite, far below zero or above `MAX_RADIANCE`, or gives no light on a table.
    """
    path = checked_path(item)
    pixels = _read_exr(path) if path.suffix.lower() == ".exr" else _read_hdr(path)
    _check_shape(path, pixels.shape[1], pixels.shape[0])
    bad = np.count_nonzero(~np.isfinite(pixels))
    if bad:
        raise InputError(path, "finite pixels", f"{bad} values that are NaN or infinite")
    if pixels.max() > MAX_RADIANCE:
        raise InputError(path, f"pixels of at most {MAX_RADIANCE:g}", f"{pixels.max():.6g}")
    pixels = np.ascontiguousarray(_without_dips(path, pixels)[:, ::-1], dtype=np.float32)
    _check_light(path, pixels)
    return pixels


def _check_light(path: Path, pixels: np.ndarray) -> None:
    """Raise InputError if the map gives no light on a table, or less than the smallest normal float.

    The exposure is pi over the irradiance: for a smaller one it would be infinite.
    """
    light = float(luminance(irradiance(pixels, 1.0, ())))
    if not pixels.any():
        raise InputError(path, "an environment map with light", "only black pixels")
    if light < np.finfo(np.float32).tiny:
        raise InputError(path, "light in the upper half of an environment map", f"an irradiance of {light:g}")


def _without_dips(path: Path, pixels: np.ndarray) -> np.ndarray:
    if pixels.min() >= 0.0:
        return pixels
    side = 2 * _DIP_RANGE + 1
    excess = pixels + _DIP * np.maximum(maximum_filter(pixels, size=(side, side, 1), mode="nearest"), 0.0)
    if excess.min() < 0.0:
        value = pixels.flat[int(np.argmin(excess))]
        raise InputError(path, "pixels of at least 0 (but for shallow dips beside bright ones)", f"{value:.6g}")
    return np.maximum(pixels, 0.0)


def _read_exr(path: Path) -> np.ndarray:
    _check_magic(path, (_EXR_MAGIC,), "an OpenEXR file")
    try:
        with quiet(), OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            low, high = ([int(n) for n in corner] for corner in file.header()["dataWindow"])
        width, height = high[0] - low[0] + 1, high[1] - low[1] + 1
        # Before the pixels: a header may claim more of them than memory holds.
        _check_shape(path, width, height)
        # Zero threads beside our own: decoding then needs no second core.
        with quiet(), OpenEXR.File(str(path), separate_channels=True, num_threads=0) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}
    except InputError:
        raise
    except (RuntimeError, ValueError, KeyError) as error:
        # What the reader raises for damaged files; a file cut short reads as one without parts.
        raise InputError(path, "a whole OpenEXR file", f"a damaged one ({_one_line(error)})") from error
    return _rgb(path, channels, (height, width))


def _rgb(path: Path, channels: dict[str, np.ndarray], shape: tuple[int, int]) -> np.ndarray:
    if {"R", "G", "B"} <= channels.keys():
        names = ["R", "G", "B"]
    elif "Y" in channels and not {"RY", "BY"} & channels.keys():
        names = ["Y", "Y", "Y"]
    else:
        raise InputError(path, "channels R, G, B or Y", ", ".join(sorted(channels)) or "none")
    planes = [channels[name] for name in names]
    for name, plane in zip(names, planes, strict=True):
        if plane.shape != shape or plane.dtype not in (np.float16, np.float32):
            raise InputError(f"{path} channel {name}", "half or float at full size", f"{plane.dtype} {plane.shape}")
    return np.stack(planes, axis=-1).astype(np.float32)


def _read_hdr(path: Path) -> np.ndarray:
    _check_magic(path, _HDR_MAGIC, "a Radiance HDR file")
    content = np.fromfile(path, dtype=np.uint8)
    size = _HDR_SIZE.search(content.data)
    if size is not None:
        # Before the decoder, which refuses an impossible size too, but then leaves a file in the temp folder.
        _check_shape(path, int(size[2]), int(size[1]))
    try:
        with quiet():
            pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise InputError(path, "a Radiance HDR file", "a damaged header") from error
    if pixels is None or pixels.ndim != 3 or pixels.dtype != np.float32:
        raise InputError(path, "a whole Radiance HDR file", "a damaged one")
    return pixels[..., ::-1]


def _check_magic(path: Path, magics: tuple[bytes, ...], expected: str) -> None:
    with path.open("rb") as file:
        start = file.read(16)
    if not start.startswith(magics):
        raise InputError(path, expected, f"first bytes {start[:8]!r}" if start else "an empty file")


def _check_shape(path: Path, width: int, height: int) -> None:
    if width != 2 * height:
        raise InputError(path, "an equirectangular map, twice as wide as high", f"{width} x {height} pixels")
    if width > MAX_WIDTH:
        raise InputError(path, f"at most {MAX_WIDTH} pixels across", width)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
