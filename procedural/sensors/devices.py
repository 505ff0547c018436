"""Devices of one kind: by name, or from a YAML file of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from ...core.errors import InputError
from ...core.setting_errors import shortened, suggest
from ...core.yaml_file import yaml_settings

Device = TypeVar("Device")

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
