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

from ...core.assets import Asset, checked_path
from ...core.errors import InputError
from ...core.exr_picture import read_exr_picture
from ...core.folders import files_in
from ...core.passed_over import Finding, Progress, checked_files
from ...core.remembered import Checked
from ...core.user_text import counted
from ..materials.picture_files import read_picture
from .colour import luminance
from .metering import irradiance
from .radiance_picture import read_radiance_picture

#: Files with the whole range of light, and pictures of a camera, which end at white.
HDR_SUFFIXES, LOW_RANGE_SUFFIXES = (".exr", ".hdr"), (".jpeg", ".jpg", ".png")
SUFFIXES = (*HDR_SUFFIXES, *LOW_RANGE_SUFFIXES)
#: Widest map that is read [px]; 16384 x 8192 pixels already take 1.5 GB.
MAX_WIDTH = 16384
#: Largest value that is read. Skies of most maps are about 1, and the unblocked disc of the sun is about 1e5 times as
#: bright (1.6e9 cd/m^2 over 1e4). Values over a thousand times more than that count as infinite.
MAX_RADIANCE = 1e8
#: What infinite pixels are read as, at least: the largest half (IEEE 754 binary16), which overflowed in most of them.
_LARGEST_HALF = 65504.0
#: Fraction of pixels that may be infinite, NaN or far below zero [1]: lamps and single faults. A file with more is
#: damaged, or no picture of light.
_MOST_FAULTS = 0.01
# Sharpening filters (Lanczos) and lossy compression (DWA, B44) leave dips below zero beside bright lamps. The
# first lobe of Lanczos' kernel (three lobes) is 0.15 deep; DWA rounds in blocks of 8 pixels. Dips are accepted up
# to this fraction of the brightest value within so many pixels; the deepest of twelve Poly Haven maps is 0.2.
_DIP, _DIP_RANGE = 0.25, 8
#: A width that differs from twice the height by so many pixels is a slip of whatever wrote the file.
_SLIP = 2
#: Number of the check of files; another one forgets what was remembered.
_CHECK = 1
#: Ends of names that say how large a map is, or that it is the view for a screen.
_VARIANT = re.compile(r"([-_ .](\d+k|tonemapped|preview|thumb(nail)?))+$")


def hdri_files(folder: Path) -> tuple[Path, ...]:
    """Return the environment maps under a folder, ordered by their relative paths; InputError where there are none.

    A JPEG or PNG that has the name of an EXR or HDR file beside it is a view of it, and left out.
    """
    files = files_in(folder, "environment maps", SUFFIXES, below=True)
    whole = {_key(path) for path in files if path.suffix.lower() in HDR_SUFFIXES}
    return tuple(path for path in files if path.suffix.lower() in HDR_SUFFIXES or _key(path) not in whole)


def _key(path: Path) -> tuple[Path, str]:
    return path.parent, _VARIANT.sub("", path.stem.lower())


def read_hdri(item: Asset) -> np.ndarray:
    """Read an equirectangular environment map.

    Single pixels that are infinite, NaN or below zero are read as bright or black (`usable_hdris` tells of them).

    Parameters
    ----------
    item : Asset
        An OpenEXR or Radiance file, or a JPEG or PNG, which holds light up to white only.

    Returns
    -------
    (h, 2 * h, 3) float32
        Linear radiance in the file's own unit, laid out as `sphere` says.

    Raises
    ------
    InputError
        If the file is missing, changed, unreadable or truncated, has no channels of a picture, is not twice as wide as
        high, has more than single faulty pixels, or gives no light on a table.
    """
    return _read(checked_path(item))[0]


def usable_hdris(folder: Path | None, progress: Progress | None = None) -> tuple[tuple[Path, ...], tuple[Finding, ...]]:
    """Return the environment maps under a folder that can be read, and what was found about all files.

    Raises
    ------
    InputError
        Where the folder is missing, or no file in it can be used.
    """
    if folder is None:
        return (), ()
    good, findings = checked_files(
        hdri_files(folder),
        lambda path: path,
        lambda path: Checked(remarks=tuple(_read(path)[1])),
        folder="environment.hdri_dir",
        root=folder,
        content="environment maps",
        version=_CHECK,
        progress=progress,
    )
    return tuple(path for path, _ in good), findings


def _read(path: Path) -> tuple[np.ndarray, list[str]]:
    """Return the map and remarks on it."""
    remarks: list[str] = []
    match path.suffix.lower():
        case ".exr":
            pixels = read_exr_picture(path, lambda width, height: _check_size(path, width, height))
        case ".hdr":
            pixels = read_radiance_picture(path, lambda width, height: _check_size(path, width, height))
        case _:
            pixels = read_picture(path)
            remarks.append("a picture of low range: its lamps and its sun are no brighter than white")
    height, width = pixels.shape[:2]
    _check_shape(path, width, height)
    if width != 2 * height:
        remarks.append(f"{width} x {height} pixels, read as {2 * height} x {height}")
        pixels = cv2.resize(pixels, (2 * height, height), interpolation=cv2.INTER_LINEAR)
    pixels = np.array(pixels[:, ::-1], np.float32, order="C")
    _limit_bright(path, pixels, remarks)
    _limit_dark(path, pixels, remarks)
    _check_light(path, pixels)
    return pixels, remarks


def _limit_bright(path: Path, pixels: np.ndarray, remarks: list[str]) -> None:
    """Replace infinite values and NaN, in place."""
    unknown = np.isnan(pixels)
    endless = ~unknown & ~(np.abs(pixels) <= MAX_RADIANCE)
    count = int(np.count_nonzero((unknown | endless).any(axis=2)))
    if count == 0:
        return
    if count > _MOST_FAULTS * pixels[..., 0].size:
        raise InputError(path, "finite pixels", f"{count} that are NaN or infinite")
    sound = pixels[~(unknown | endless)]
    limit = max(_LARGEST_HALF, float(sound.max(initial=0.0)))
    if endless.any():
        pixels[endless] = np.where(pixels[endless] > 0.0, np.float32(limit), np.float32(0.0))
        number = int(np.count_nonzero(endless.any(axis=2)))
        remarks.append(f"{counted(number, 'infinite pixel')}, read as {limit:g}")
    if unknown.any():
        pixels[unknown] = 0.0
        number = int(np.count_nonzero(unknown.any(axis=2)))
        remarks.append(f"{counted(number, 'pixel')} without a number (NaN), read as black")


def _limit_dark(path: Path, pixels: np.ndarray, remarks: list[str]) -> None:
    """Replace values below zero, in place; shallow dips beside brighter pixels need no remark."""
    if pixels.min() >= 0.0:
        return
    from scipy.ndimage import maximum_filter  # here, as it takes a third of a second to load

    side = 2 * _DIP_RANGE + 1
    excess = pixels + _DIP * np.maximum(maximum_filter(pixels, size=(side, side, 1), mode="nearest"), 0.0)
    deep = int(np.count_nonzero((excess < 0.0).any(axis=2)))
    if deep > _MOST_FAULTS * pixels[..., 0].size:
        value = pixels.flat[int(np.argmin(excess))]
        raise InputError(path, "pixels of at least 0", f"{deep} far below, such as {value:.6g}")
    if deep:
        remarks.append(f"{counted(deep, 'pixel')} far below 0, read as black")
    np.maximum(pixels, 0.0, out=pixels)


def _check_light(path: Path, pixels: np.ndarray) -> None:
    """Raise InputError if the map gives no light on a table, or less than the smallest normal float.

    The exposure is pi over the irradiance: for a smaller one it would be infinite.
    """
    light = float(luminance(irradiance(pixels, 1.0, ())))
    if not pixels.any():
        raise InputError(path, "an environment map with light", "only black pixels")
    if light < np.finfo(np.float32).tiny:
        raise InputError(path, "light in the upper half of an environment map", f"an irradiance of {light:g}")


def _check_size(path: Path, width: int, height: int) -> None:
    """Raise InputError for a size that no map has, before its pixels are read."""
    if not (0 < width <= MAX_WIDTH + _SLIP and 0 < height <= MAX_WIDTH + _SLIP):
        raise InputError(path, f"1 to {MAX_WIDTH} pixels a side", f"{width} x {height}")


def _check_shape(path: Path, width: int, height: int) -> None:
    if abs(width - 2 * height) > min(_SLIP, height // 16):
        raise InputError(path, "an equirectangular map, twice as wide as high", f"{width} x {height} pixels")
