"""Polarisation cameras by name, and from YAML files."""

from __future__ import annotations

from pathlib import Path

from ..description.polarisation_camera import PolarisationCamera
from .devices import LIKE, NONE, device_fields, is_device_file, named_device, own_device

_SOURCE = (
    "axes of the filters: Sony's cell as cameras with it document it (90, 45; 135, 0 degrees from its first row on); "
    "12 bits; full well and read noise from the largest ratio of signal to noise (40.3 dB) and the dynamic range (71.2 "
    "dB) of a camera with the IMX250, the same pixels without filters (EMVA 1288, manual of mvBlueFOX3-2051): 10^4.03 "
    "electrons, and these over 10^3.56. Assumed: an extinction ratio of 300, no black level, exact axes, no light that "
    "leaks to neighbouring pixels"
)
_MONO = PolarisationCamera(
    name="imx250mzr",
    source="Sony IMX250MZR: " + _SOURCE,
    angles=((90.0, 45.0), (135.0, 0.0)),
    extinction_ratio=300.0,
    full_well=10_715.0,
    read_noise=2.95,
    bits=12,
    samples=256,
)
#: By name.
POLARISATION_CAMERAS: dict[str, PolarisationCamera] = {
    "imx250mzr": _MONO,
    "imx250myr": _MONO.model_copy(
        update={"name": "imx250myr", "source": "Sony IMX250MYR, in colour: " + _SOURCE, "colour": True}
    ),
}


def polarisation_camera(name: str | Path, where: str = "sensors.polarisation") -> PolarisationCamera | None:
    """Return a polarisation camera by its name, or from a YAML file; None for ``none``.

    Parameters
    ----------
    name : str or Path
        A device, ``none``, or a file that ends in ``.yaml`` or ``.yml``: fields of `PolarisationCamera`, on top of
        those of the device that its ``like`` names.
    where : str
        The setting, for errors.

    Raises
    ------
    InputError
        Where there is no such device, or the file cannot be read or has a wrong field.
    """
    text = str(name)
    if text == NONE:
        return None
    if not is_device_file(text):
        return named_device(POLARISATION_CAMERAS, text, where, f"{NONE}, or a YAML file")
    given, like = device_fields(text, where)
    below = {} if like is None else named_device(POLARISATION_CAMERAS, like, f"{text}: {LIKE}").model_dump()
    fields = below | {"name": "own", "source": ""} | given
    return own_device(text, PolarisationCamera, fields, None if like else _MONO.name)
