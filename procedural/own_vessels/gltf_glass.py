"""The glass that a glTF file states: transmission, index, attenuation colour and distance of a material.

Extensions KHR_materials_transmission, KHR_materials_ior and KHR_materials_volume of glTF 2.0: a medium lets
``colour`` of the light through after ``distance`` metres, so it absorbs ``-ln(colour) / distance``. The glass of the
first material with transmission is taken.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ..optics.medium import Medium

#: Refractive index without KHR_materials_ior [1], by that extension.
DEFAULT_INDEX = 1.5
#: Least transmittance that is told from black [1]: an 8-bit picture does not show less.
_LEAST = 1.0 / 255.0
#: Least factor of transmission that makes a material glass [1]: below half it is mostly paint.
_TRANSPARENT = 0.5


def gltf_glass(path: Path, content: bytes) -> Medium | None:
    """Return the glass of a GLB file; None where no material of it has transmission.

    Raises
    ------
    InputError
        For factors that are no numbers of their kind.
    """
    for material in _materials(content):
        extensions = material.get("extensions")
        extensions = extensions if isinstance(extensions, dict) else {}
        transmission = extensions.get("KHR_materials_transmission")
        if (
            not isinstance(transmission, dict)
            or not _number(path, transmission, "transmissionFactor", 0.0) >= _TRANSPARENT
        ):
            continue
        volume = extensions.get("KHR_materials_volume")
        volume = volume if isinstance(volume, dict) else {}
        ior = extensions.get("KHR_materials_ior")
        eta = _number(path, ior if isinstance(ior, dict) else {}, "ior", DEFAULT_INDEX)
        if not 1.0 < eta <= 3.0:
            raise InputError(f"{path}: ior", "a refractive index above 1, at most 3", eta)
        name = str(material.get("name") or "glass")[:60]
        return Medium(
            name=f"{name} of {path.name}",
            eta=eta,
            sigma_a=_absorption(path, volume),
            source=f"glTF material of {path.name}",
        )
    return None


def _absorption(path: Path, volume: dict) -> tuple[float, float, float]:
    distance = _number(path, volume, "attenuationDistance", np.inf)
    colour = volume.get("attenuationColor", [1.0, 1.0, 1.0])
    try:
        values = np.array(colour, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != (3,) or not ((values >= 0.0) & (values <= 1.0)).all() or not distance > 0.0:
        raise InputError(f"{path}: KHR_materials_volume", "a colour of 0 to 1 and a distance above 0", f"{colour}")
    red, green, blue = (-np.log(np.maximum(values, _LEAST)) / distance).tolist()
    return red, green, blue


def _number(path: Path, values: dict, name: str, default: float) -> float:
    value = values.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise InputError(f"{path}: {name}", "a number", repr(value)[:40])
    return float(value)


def _materials(content: bytes) -> list[dict]:
    """Return the materials of a GLB's JSON chunk, the first chunk of the file; none where it is damaged."""
    if len(content) < 20 or content[:4] != b"glTF":
        return []
    length = struct.unpack_from("<I", content, 12)[0]
    try:
        document = json.loads(content[20 : 20 + length])
    except (ValueError, RecursionError):
        return []
    materials = document.get("materials", []) if isinstance(document, dict) else []
    return [item for item in materials if isinstance(item, dict)] if isinstance(materials, list) else []
