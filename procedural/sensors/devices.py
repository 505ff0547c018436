"""Devices of one kind: by name, or from a YAML file of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from ...core.errors import InputError
from ...core.setting_errors import setting_error, shortened, suggest
from ...core.yaml_file import yaml_settings

Device = TypeVar("Device")
OwnDevice = TypeVar("OwnDevice", bound=BaseModel)

#: The name of no device, and what a YAML file may name to begin with a device's figures.
NONE, LIKE = "none", "like"
_FILES = (".yaml", ".yml")


def is_device_file(name: str) -> bool:
    """Return whether a name is that of a YAML file."""
    return name.endswith(_FILES)


def named_device(devices: Mapping[str, Device], name: str, where: str, other: str = "") -> Device:
    """Return a device by its name; InputError at `where` with all names, and what `other` there may be."""
    if name not in devices:
        names = ", ".join([*devices, *([other] if other else [])])
        raise InputError(where, f"one of {names}{suggest(name.lower(), list(devices))}", shortened(name))
    return devices[name]


def device_fields(path: str, where: str) -> tuple[dict, str | None]:
    """Return the fields of a device's YAML file, and the name of the device that it begins with."""
    given = yaml_settings(path, where)
    like = given.pop(LIKE, None)
    return given, None if like is None else str(like)


def own_device(path: str, kind: type[OwnDevice], fields: dict, nearest: str | None) -> OwnDevice:
    """Return the device of a YAML file.

    Parameters
    ----------
    path : str
        The file.
    kind : type
        The model of such devices.
    fields : dict
        All fields.
    nearest : str, optional
        The device that a file without ``like`` may begin with; None where the file names one.

    Raises
    ------
    InputError
        For the first wrong field; where one is missing, with the line that fills it.
    """
    try:
        return kind.model_validate(fields)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        if first["type"] == "missing" and nearest is not None:
            name = ".".join(map(str, first["loc"]))
            expected = f"a value, or {LIKE}: {nearest} for all that the file leaves out"
            raise InputError(f"{path}: {name}", expected, "none") from error
        raise setting_error(path, error, kind) from error
