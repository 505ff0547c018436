"""Reflectances of opaque surfaces in the near infrared, in place of their colours while infrared light is traced."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ...procedural.description.material import NearInfrared
from ...procedural.materials.near_infrared import infrared_reflectance, near_infrared
from .._mitsuba import mi
from ..scene.loaded_scene import LoadedScene

#: Of a principled BSDF's parameters: its colours (`bodies.opaque_bsdf`).
_COLOURS = "base_color.data"
#: Wavelengths at which the sensitivities of the eye for linear Rec.709 blue, green and red are largest [nm].
_BLUE, _GREEN, _RED = 465.0, 550.0, 610.0


@contextmanager
def infrared_reflectances(loaded: LoadedScene, part: float = 1.0) -> Iterator[None]:
    """Give opaque surfaces their reflectances in the near infrared, the same in all channels, within a block.

    The colours are those of the textures as they are in memory; afterwards they are there again, bit by bit.

    Parameters
    ----------
    loaded : LoadedScene
        The scene.
    part : float
        Part of the light's power that is in the near infrared [1]; the rest meets the colours.
    """
    kept = []
    try:
        for shape in loaded.mi_scene.shapes():
            material = loaded.materials.get(shape.id())
            if material is None:
                continue
            parameters = mi.traverse(shape.bsdf())
            colours = mi.TensorXf(parameters[_COLOURS])  # a reference of its own: assignment changes the other one
            kept.append((parameters, colours))
            parameters[_COLOURS] = _mixed(colours, near_infrared(material), part)
            parameters.update()
        yield
    finally:
        for parameters, colours in kept:
            parameters[_COLOURS] = colours
            parameters.update()


def _mixed(colours: mi.TensorXf, law: NearInfrared, part: float) -> mi.TensorXf:
    """Return a texture of mean reflectances, with as many channels as that of the colours.

    In spectral variants, which hold no colours, it is grey.
    """
    stored = np.array(colours)
    seen = _reflectances(stored) if mi.is_spectral else stored
    infrared = infrared_reflectance(seen, law)[..., None]
    if mi.is_spectral:
        grey = part * infrared + (1.0 - part) * seen.mean(axis=-1, keepdims=True)
        found = np.concatenate([np.zeros((*grey.shape[:2], 2)), _coefficient(grey)], axis=2)
    else:
        found = part * infrared + (1.0 - part) * stored
    return mi.TensorXf(np.ascontiguousarray(found, np.float32))


def _reflectances(coefficients: np.ndarray) -> np.ndarray:
    """Return reflectances at a red, a green and a blue wavelength, (h, w, 3), of textures of spectral variants.

    They hold the three coefficients of 1/2 + x / (2 sqrt(1 + x^2)), x = a nm^2 + b nm + c (Jakob and Hanika 2019).
    """
    nm = np.array([_RED, _GREEN, _BLUE])
    a, b, c = (coefficients[..., k, None].astype(np.float64) for k in range(3))
    x = (a * nm + b) * nm + c
    return np.where(np.isinf(x), x > 0.0, 0.5 + 0.5 * x / np.sqrt(1.0 + x * x))


def _coefficient(reflectance: np.ndarray) -> np.ndarray:
    """Return the coefficient c of a reflectance that is the same at all wavelengths."""
    inside = np.clip(reflectance, 1e-4, 1.0 - 1e-4)
    return (2.0 * inside - 1.0) / (2.0 * np.sqrt(inside * (1.0 - inside)))
