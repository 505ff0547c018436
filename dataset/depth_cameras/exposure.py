"""From radiance to the pictures that an infrared camera takes: exposure, photon and read noise, clipping."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from ...procedural.description.depth_camera import DepthCamera, InfraredImager
from ...render.frame import Infrared

#: Energy of a photon times its wavelength: Planck's constant times the speed of light [J nm] (SI).
_PHOTON = 6.62607015e-34 * 299792458.0 * 1e9
#: Luminance of one unit of the pictures' radiance [cd/m^2].
_UNIT = 1000.0
#: Halvings of the range in which an exposure is sought [1]: to 1e-9 of its logarithm.
_HALVINGS = 30
#: Standard deviation of rounding, in steps: 1 / sqrt(12).
_ROUNDING = 12.0**-0.5


@dataclass(frozen=True, eq=False)
class InfraredPictures:
    """The pictures that are matched."""

    left: np.ndarray  #: (h, w) uint16
    right: np.ndarray  #: (h, w) uint16
    white: int  #: value of a saturated pixel
    noise: np.ndarray  #: (h, w) float32, standard deviation of the left picture's noise, in its steps
    exposure: float  #: [s]
    gain: float


def infrared_pictures(infrared: Infrared, device: DepthCamera, rng: np.random.Generator) -> InfraredPictures:
    """Return the pictures that both infrared cameras take of a view, with the same exposure.

    The irradiance behind a lens of the f-number N is pi L / (4 N^2). A pixel of the area a collects it for the time t,
    and gives an electron for each of its photons times the efficiency. Photons count as of the projector's wavelength.

    Parameters
    ----------
    infrared : Infrared
        What the cameras see.
    device : DepthCamera
        The device.
    rng : numpy.random.Generator
        Of the noise.
    """
    imager = device.imager
    per_radiance = math.pi / (4.0 * imager.aperture**2) * imager.pitch**2 * imager.efficiency
    per_radiance *= device.projector.wavelength / _PHOTON  # electrons a second for one W/(m^2 sr)
    efficacy = imager.daylight_efficacy if infrared.daylight else imager.efficacy
    rates = [
        per_radiance * _blurred(dots + ambient * (_UNIT / efficacy), imager.blur)
        for dots, ambient in zip(infrared.dots, infrared.ambient, strict=True)
    ]
    time, gain = exposed(rates[0], imager)
    white, pictures = (1 << imager.bits) - 1, []
    scale = gain * white / imager.full_well  # steps for one electron
    for rate in rates:
        electrons = rng.poisson(np.minimum(rate * time, 1e9)).astype(np.float64)
        electrons += rng.normal(0.0, imager.read_noise, electrons.shape)
        pictures.append(np.clip(np.rint(electrons * scale), 0, white).astype(np.uint16))
    variance = (rates[0] * time + imager.read_noise**2) * scale**2 + _ROUNDING**2
    return InfraredPictures(pictures[0], pictures[1], white, np.sqrt(variance).astype(np.float32), time, gain)


def exposed(rate: np.ndarray, imager: InfraredImager) -> tuple[float, float]:
    """Return the exposure time [s] and the gain for electrons a second.

    They bring the mean of the pixels of a region to its target, as these pixels are: those that are white count as
    white, however bright they are. A sunlit wall behind the table takes its part of the mean and no more.
    """
    rate = in_region(rate, imager.region) / imager.full_well
    shortest, longest = imager.exposure[0], imager.exposure[1] * imager.gain
    low, high = math.log(shortest), math.log(longest)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        dark = float(np.minimum(rate * math.exp(middle), 1.0).mean()) < imager.target
        low, high = (middle, high) if dark else (low, middle)
    wanted = min(max(math.exp(0.5 * (low + high)), shortest), longest)
    time = min(wanted, imager.exposure[1])
    return time, wanted / time


def in_region(picture: np.ndarray, region: tuple[float, float, float, float]) -> np.ndarray:
    """Return a part of a picture, one pixel at least; the edges are parts of its size."""
    (rows, columns), (left, top, right, bottom) = picture.shape, region
    first_row, first_column = min(int(top * rows), rows - 1), min(int(left * columns), columns - 1)
    last_row, last_column = math.ceil(bottom * rows), math.ceil(right * columns)
    return picture[first_row : max(last_row, first_row + 1), first_column : max(last_column, first_column + 1)]


def _blurred(picture: np.ndarray, sigma: float) -> np.ndarray:
    if sigma == 0.0:
        return picture
    return cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
