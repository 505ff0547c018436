"""RGB absorption from spectra: three coefficients that reproduce the colour of an absorbing medium.

Spectral Beer-Lambert is ``T(lambda) = exp(-a(lambda) L)``; the renderer's RGB variants compute ``exp(-sigma_c L)`` per
channel. Both agree at one length only, the reference length. ``docs/media.md`` has the error at other lengths.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .medium import Absorber
from .rgb_weights import RGB_WEIGHTS
from .spectra import mixture

_TABLE = np.array(RGB_WEIGHTS)
WAVELENGTHS, WEIGHTS = _TABLE[:, 0], _TABLE[:, 1:]
#: Longest reference length [m]: 20 mm for liquids (half the width of a narrow glass), 5 mm for walls.
LIQUID_LENGTH, WALL_LENGTH = 0.02, 0.005
#: A channel that is darker than this at the longest reference length is matched where it has fallen to this. A pure
#: yellow liquid has negative blue, outside Rec.709, after a few centimetres: nothing can be matched, while thin layers
#: still transmit blue.
REFERENCE_TRANSMITTANCE = 0.05
#: Halvings of the interval that holds a reference length: 2^-40 of 20 mm is far below any wall's tolerance.
HALVINGS = 40


def transmitted_rgb(absorbers: tuple[Absorber, ...], length: float) -> np.ndarray:
    """Return the linear Rec.709 colour of D65 light behind a stretch of a medium, relative to the light.

    Parameters
    ----------
    absorbers : tuple of Absorber
        What the medium contains.
    length : float
        Length of the stretch [m].

    Returns
    -------
    (3,) float64
        May be outside [0, 1] where the colour is outside Rec.709.
    """
    return _rgb(mixture(absorbers, WAVELENGTHS), length)


def rgb_absorption(absorbers: tuple[Absorber, ...], longest: float) -> tuple[float, float, float]:
    """Return ``sigma_a`` [1/m] with which each channel has its spectrally computed value at its reference length.

    The reference length of a channel is `longest`, or where the channel has fallen to `REFERENCE_TRANSMITTANCE`. A
    channel above 1 (a colour outside Rec.709 can be brighter than the light in one channel) gets no absorption: the
    nearest that an absorbing medium can have.

    Parameters
    ----------
    absorbers : tuple of Absorber
        What the medium contains.
    longest : float
        Longest reference length [m]: `LIQUID_LENGTH` or `WALL_LENGTH`.
    """
    spectrum = mixture(absorbers, WAVELENGTHS)
    red, green, blue = (_channel(lambda length, c=c: float(_rgb(spectrum, length)[c]), longest) for c in range(3))
    return red, green, blue


def _rgb(spectrum: np.ndarray, length: float) -> np.ndarray:
    return np.exp(-spectrum * length) @ WEIGHTS


def _channel(transmittance: Callable[[float], float], longest: float) -> float:
    if transmittance(longest) >= REFERENCE_TRANSMITTANCE:
        return max(0.0, -float(np.log(transmittance(longest)))) / longest
    low, high = 0.0, longest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if transmittance(middle) >= REFERENCE_TRANSMITTANCE else (low, middle)
    return -float(np.log(REFERENCE_TRANSMITTANCE)) / high
