"""Known cameras: size, intrinsics and baseline, to be set by name (``cameras.preset``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...core.setting_errors import suggest
from .intrinsics import Intrinsics


@dataclass(frozen=True)
class CameraPreset:
    """A stereo camera as it is sold or published."""

    lens: Intrinsics
    baseline: float  #: [m]
    source: str


def _central(width: int, height: int, focal: float) -> Intrinsics:
    return Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


#: By name. Units of one type differ by about one per cent, so a calibrated camera is better described by its own K.
PRESETS: dict[str, CameraPreset] = {
    "d415": CameraPreset(
        _central(1280, 720, 892.62),
        0.055,
        "Intel RealSense D415, infrared pair: 446.31 px at 640x360 (Dai et al., DREDS, ECCV 2022), 444 to 451 in "
        "single units; 55 mm by the data sheet",
    ),
    "d435": CameraPreset(
        Intrinsics(848, 480, 430.14, 430.14, 425.16, 235.28),
        0.05,
        "Intel RealSense D435, infrared pair at its best depth mode, 848x480: a unit's own calibration; 50 mm by the "
        "data sheet",
    ),
    "keypose": CameraPreset(
        Intrinsics(1280, 720, 675.61713, 675.61713, 632.1181, 338.28537),
        0.120007,
        "the stereo camera of KeyPose (Liu et al., CVPR 2020), from the labels of its data set",
    ),
    "syn-todd": CameraPreset(
        _central(640, 480, 613.9624633789062),
        0.06499999761581421,
        "Syn-TODD (Wang et al., MVTrans, ICRA 2023), from its released code",
    ),
    "zed2": CameraPreset(
        _central(1280, 720, 527.0),
        0.12,
        "Stereolabs ZED 2, rectified HD720: mean of two published calibrations (522.6 and 530.6 px); 120 mm by the "
        "data sheet",
    ),
}

#: Settings that a preset gives, and those of them that describe the lens.
_LENS = ("fx", "fy", "cx", "cy")
PRESET_FIELDS = ("width", "height", *_LENS, "baseline")
#: Largest relative difference between the scales across and down that still is the same shape: whole pixels make one
#: of 1/424 in KeyPose's resized pictures, 756 x 424.
_SHAPE = 0.01


def known_preset(name: str) -> str:
    """Return the name of a preset; ValueError with the most similar one where there is none."""
    if name not in PRESETS:
        raise ValueError(f"expected one of {', '.join(PRESETS)}{suggest(name.lower(), list(PRESETS))}, found {name!r}")
    return name


def with_preset(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings of cameras with what their preset says of the others; what is given takes precedence.

    A width or a height alone brings the other in the preset's shape, and the lens is that of the resized picture.
    Beside a lens of the user's own (``K``, ``fx``, ``fov`` or ``focal``) only size and baseline are taken.

    Parameters
    ----------
    given : mapping
        Settings by name, as a user gave them, not yet validated; those of None count as not given.

    Raises
    ------
    ValueError
        Where width and height are given and have another shape: ``height: expected ..., found ...``.
    """
    found = {name: value for name, value in given.items() if value is not None}
    preset = PRESETS.get(str(found.get("preset")))
    if preset is None:
        return dict(given)
    lens = preset.lens
    if found.keys() & {"K", "fx", "fov", "focal"}:
        return {"width": lens.width, "height": lens.height, "baseline": preset.baseline} | found
    lens = lens.resized(*_size(str(found["preset"]), lens, found))
    return {name: getattr(lens, name) for name in ("width", "height", *_LENS)} | {"baseline": preset.baseline} | found


def _size(name: str, lens: Intrinsics, given: Mapping[str, Any]) -> tuple[int, int]:
    """Return the width and the height of the pictures [px]."""
    try:
        width = int(given["width"]) if "width" in given else None
        height = int(given["height"]) if "height" in given else None
    except (TypeError, ValueError, OverflowError):  # no number: refused when it is validated
        return lens.width, lens.height
    if width is None and height is None:
        return lens.width, lens.height
    if width is None:
        width = max(1, round((height or 1) * lens.width / lens.height))
    fitting = max(1, round(width * lens.height / lens.width))
    if height is None:
        height = fitting
    if width > 0 and height > 0 and abs(height - fitting) > max(1.0, _SHAPE * fitting):
        shape = f"the shape of {name} ({lens.width} x {lens.height})"
        raise ValueError(f"height: expected {fitting}, {shape}, beside a width of {width}, found {height}")
    return width, height
