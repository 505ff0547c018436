"""What a colour camera's sensor makes of the wavelengths of paths: its raw red, green and blue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.errors import InputError
from ...procedural.description.sensitivities import Sensitivities
from .._mitsuba import dr, mi

#: Wavelengths that Mitsuba samples [nm], and the step at which curves are tabulated: published ones have 5 nm or more.
FIRST_NM, LAST_NM, STEP_NM = 360.0, 830.0, 1.0
_GRID = round((LAST_NM - FIRST_NM) / STEP_NM) + 1


@dataclass(frozen=True, eq=False)
class SensorResponse:
    """The curves of a sensor as a Dr.Jit array, each divided by its integral over white light."""

    columns: mi.Float  #: by wavelength and channel: sensitivity over the response to D65 of luminance 1, in 1/nm

    def of(self, radiance: mi.UnpolarizedSpectrum, wavelengths: Any) -> mi.Color3f:
        """Return the raw response to the spectral radiance of paths, over the density of their wavelengths.

        The mean over a path's wavelengths of L s / p estimates the integral of L s without bias.
        """
        total = mi.Color3f(0.0)
        for channel in range(len(wavelengths)):
            place = dr.clip((wavelengths[channel] - FIRST_NM) / STEP_NM, 0.0, _GRID - 1.001)
            cell = mi.UInt32(place)
            low, high = dr.gather(mi.Color3f, self.columns, cell), dr.gather(mi.Color3f, self.columns, cell + 1)
            total += dr.lerp(low, high, place - mi.Float(cell)) * radiance[channel]
        return total / len(wavelengths)


def sensor_response(sensor: Sensitivities | None) -> SensorResponse | None:
    """Return the response of a sensor in the active variant; None without one.

    Raises
    ------
    InputError
        Where the variant has no wavelengths.
    """
    if sensor is None:
        return None
    if not mi.is_spectral:
        expected = "picture.spectral on and a spectral variant, such as llvm_ad_spectral"
        raise InputError("scene, sensitivities", expected, mi.variant())
    nm = FIRST_NM + STEP_NM * np.arange(_GRID)
    curves = sensor.at(nm)
    columns = mi.Float((curves / white_response(nm, curves)).astype(np.float32).ravel())
    dr.make_opaque(columns)
    return SensorResponse(columns)


def white_response(nm: np.ndarray, curves: np.ndarray) -> np.ndarray:
    """Return the integrals of curves (n, 3) at wavelengths (n,) over the light that pictures show as (1, 1, 1), (3,).

    Mitsuba gives D65, its light of colours, the luminance 1 by dividing the observer by its integral.
    """
    si = dr.zeros(mi.SurfaceInteraction3f, len(nm))
    si.wavelengths = type(si.wavelengths)(mi.Float(nm))
    light = mi.load_dict({"type": "d65"})
    power = np.array(light.eval(si)[0], np.float64)
    return np.array([np.trapezoid(power * curve, nm) for curve in curves.T])
