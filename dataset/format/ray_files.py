"""``layers.exr`` and ``refraction.exr``: a view's straight and refracted rays as channels of an EXR file.

``layers.exr`` has for layer 00, 01, ... the channels ``layer00.Z`` (planar depth [m], +inf for an empty layer),
``layer00.N.X,Y,Z`` (camera frame), ``layer00.id``, ``layer00.part`` (index into `render.frame.PARTS`),
``layer00.material`` (index into the materials of ``objects.json``: the medium behind the surface) and
``layer00.entering`` (1 against the surface's own normal), and ``count``, the number of surfaces along each ray, also
beyond the last layer. There are as many layers as the view's deepest ray has, limited by the setting.

``refraction.exr`` has ``state`` (0 left for the surroundings, 1 hit an opaque surface, 2 lost after too many
interfaces), ``hit.X,Y,Z`` (world: a point [m], for state 0 the unit direction of leaving), ``Z`` (planar depth of the
point, +inf for none), ``id``, ``flow.U,V`` (where the hit appears without glass less the pixel [px], NaN for nowhere),
``bounces`` (interfaces met) and ``transmittance.R,G,B``.

Depths, points and flow are float32. Small whole numbers, normals and transmittances are half, which is exact to whole
numbers of 2048 and to 2^-11 of a normal's component.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...render.frame import LOST, PARTS, SURROUNDINGS, Layers, Refraction
from .exr import channel, half_numbers, read_exr, stacked, unstacked, write_exr


def write_layers(path: Path, layers: Layers) -> None:
    """Write ``layers.exr`` without the layers that are empty in the whole view."""
    depth = min(len(layers.Z), int(layers.count.max(initial=0)))
    channels = {"count": half_numbers(layers.count, "count")}
    for i in range(depth):
        name = f"layer{i:02d}"
        channels |= {f"{name}.Z": layers.Z[i], **unstacked(layers.normal[i], f"{name}.N.XYZ")}
        for field in ("id", "part", "material", "entering"):
            channels[f"{name}.{field}"] = half_numbers(getattr(layers, field)[i], field)
    write_exr(path, channels)


def read_layers(path: Path) -> Layers:
    """Read ``layers.exr``; InputError where it is missing or damaged."""
    channels = read_exr(path)
    count = _whole(channel(channels, "count", path), np.uint16, "count", path)
    names = sorted({name.split(".")[0] for name in channels if name.startswith("layer")})
    if names != [f"layer{i:02d}" for i in range(len(names))]:
        raise InputError(path, "layers numbered from 00 without a gap", names)

    def every(field: str, dtype: type) -> np.ndarray:
        found = np.empty((len(names), *count.shape), dtype)
        for number, name in enumerate(names):
            found[number] = _whole(channel(channels, f"{name}.{field}", path), dtype, field, path)
        return found

    Z = np.empty((len(names), *count.shape), np.float32)
    normal = np.empty((*Z.shape, 3), np.float16)
    for number, name in enumerate(names):
        Z[number] = channel(channels, f"{name}.Z", path)
        for axis, letter in enumerate("XYZ"):
            normal[number, ..., axis] = channel(channels, f"{name}.N.{letter}", path)
    part = every("part", np.uint8)
    if part.max(initial=0) >= len(PARTS):
        raise InputError(f"{path}: part", f"0 to {len(PARTS) - 1}", int(part.max()))
    return Layers(
        Z=Z,
        normal=normal,
        id=every("id", np.uint16),
        part=part,
        material=every("material", np.uint16),
        entering=every("entering", bool),
        count=count,
    )


def write_refraction(path: Path, refraction: Refraction) -> None:
    """Write ``refraction.exr``."""
    numbers = {field: half_numbers(getattr(refraction, field), field) for field in ("state", "id", "bounces")}
    channels = {
        "Z": refraction.Z,
        **unstacked(refraction.hit, "hit.XYZ"),
        **unstacked(refraction.flow, "flow.UV"),
        **unstacked(refraction.transmittance, "transmittance.RGB"),
    }
    write_exr(path, numbers | channels)


def read_refraction(path: Path) -> Refraction:
    """Read ``refraction.exr``; InputError where it is missing or damaged."""
    channels = read_exr(path)
    state = _whole(channel(channels, "state", path), np.uint8, "state", path)
    if state.max(initial=SURROUNDINGS) > LOST:
        raise InputError(f"{path}: state", f"{SURROUNDINGS} to {LOST}", int(state.max()))
    return Refraction(
        state=state,
        hit=stacked(channels, "hit.XYZ", path),
        Z=channel(channels, "Z", path),
        id=_whole(channel(channels, "id", path), np.uint16, "id", path),
        flow=stacked(channels, "flow.UV", path),
        bounces=_whole(channel(channels, "bounces", path), np.uint16, "bounces", path),
        transmittance=stacked(channels, "transmittance.RGB", path).astype(np.float16),
    )


def _whole(values: np.ndarray, dtype: type, field: str, path: Path) -> np.ndarray:
    """Return whole numbers as a type that holds them, bool or unsigned; InputError for others."""
    # NumPy computes with halves number by number, which takes ten times as long as to look up what each is.
    numbers = _WHOLE_HALVES[values.view(np.uint16)] if values.dtype == np.float16 else _whole_of(values)
    if numbers.max(initial=0) > (1 if dtype is bool else min(np.iinfo(dtype).max, _NO_NUMBER - 1)):
        raise InputError(f"{path}: {field}", "whole numbers of at least 0", "others")
    return numbers.astype(dtype, copy=False)


#: Above all numbers of a half, which end at 65504.
_NO_NUMBER = 65535


def _whole_of(values: np.ndarray) -> np.ndarray:
    """Return whole numbers of at most 65534 as uint16, and `_NO_NUMBER` for all others."""
    whole = (values >= 0.0) & (values < _NO_NUMBER)
    numbers = np.where(whole, values, 0.0).astype(np.uint16)
    return np.where(whole & (numbers == values), numbers, np.uint16(_NO_NUMBER))


#: The whole number of each half, by its bits.
_WHOLE_HALVES = _whole_of(np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float32))
