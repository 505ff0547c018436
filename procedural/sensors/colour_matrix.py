"""The colour matrix of a sensor, by its sensitivities: fitted in daylight to measured reflectances of materials.

The reflectances, the observer and the illuminant come from `colour-science`, the extra ``colour``, which is imported
where it is used: that takes a second.
"""

from __future__ import annotations

import warnings
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from ...core.errors import InputError

#: Wavelengths of all integrals here [nm]: those of the reflectances, in equal steps, so that sums are integrals.
NM = np.arange(380.0, 781.0, 5.0)
_PACKAGE = "colour-science"


def check_package(where: str) -> None:
    """Raise InputError where the extra is not installed."""
    try:
        version(_PACKAGE)
    except PackageNotFoundError as error:
        expected = "its extra, as in pip install 'glassware[colour]'"
        raise InputError(where, expected, f"no package {_PACKAGE}") from error


def colour_science(where: str = "sensors.sensitivities") -> Any:
    """Return the package; InputError where it is not installed."""
    check_package(where)
    with warnings.catch_warnings():  # it warns of packages that parts of it need which are not used here
        warnings.simplefilter("ignore")
        import colour
    return colour


def daylight(where: str = "sensors.sensitivities") -> np.ndarray:
    """Return the relative spectral power of the CIE standard illuminant D65 at `NM`, (81,) float64."""
    illuminant = colour_science(where).SDS_ILLUMINANTS["D65"]
    return np.interp(NM, illuminant.wavelengths, illuminant.values)


def colour_matrix(curves: np.ndarray, where: str = "sensors.sensitivities") -> tuple[np.ndarray, np.ndarray]:
    """Return what white daylight gives in each channel, and the matrix from raw responses to linear Rec.709.

    The matrix has the least squared error over 190 reflectances in D65, the training data of the Academy's RAW to ACES
    utility, version 1. Its rows sum to 1, so that what is neutral stays so: two unknowns a row are fitted.

    Parameters
    ----------
    curves : (81, 3) float
        Sensitivities at `NM`.
    where : str
        The setting, for the error of a missing package.

    Returns
    -------
    white : (3,) float64
        Integrals of D65 times the curves, over that of green.
    matrix : (3, 3) float64
        For responses that are 1 for D65.
    """
    colour, light = colour_science(where), daylight(where)
    patches = colour.characterisation.read_training_data_rawtoaces_v1()
    if not np.array_equal(patches.wavelengths, NM):
        raise ValueError(f"{_PACKAGE}: expected reflectances at 380 to 780 nm in steps of 5, found other wavelengths")
    reflected = patches.values.T * light
    white = light @ curves
    raw, seen = reflected @ curves / white, reflected @ _rec709(colour, light)
    pairs = np.linalg.lstsq(raw[:, :2] - raw[:, 2:], seen - raw[:, 2:], rcond=None)[0].T
    return white / white[1], np.column_stack([pairs, 1.0 - pairs.sum(axis=1)])


def _rec709(colour: Any, light: np.ndarray) -> np.ndarray:
    """Return the matching functions of linear Rec.709 at `NM`, (81, 3), in which a light is (1, 1, 1)."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    xyz = np.stack([np.interp(NM, observer.wavelengths, column) for column in observer.values.T], axis=1)
    functions = xyz @ colour.models.RGB_COLOURSPACE_BT709.matrix_XYZ_to_RGB.T
    return functions / (light @ functions)
