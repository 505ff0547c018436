"""Files of torch: read as data, so that a file can run no code."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from ...core.errors import InputError

#: How torch begins to tell that a file is not data alone.
_NOT_DATA = "Weights only load failed"


def read_torch(path: Path) -> Any:
    """Return what a file of torch holds; InputError where it is missing, cut short, or holds more than data."""
    if not path.is_file():
        raise InputError(path, "a readable file", "a folder" if path.is_dir() else "none")
    _check_archive(path)
    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch's reader raises whatever a damaged or hostile file leads it to
        found = _first_line(error)
        if found.startswith(_NOT_DATA):  # and goes on to advise that the file be read as code
            found = "something else, or more than tensors and numbers: code"
        raise InputError(path, "an undamaged file of torch", found) from error


def _check_archive(path: Path) -> None:
    """Raise InputError where a zip archive, as torch writes them, is damaged or unpacks to more than its size.

    torch itself reads neither the checksums nor the sizes of the members.
    """
    if not zipfile.is_zipfile(path):  # files of torch before 1.6 are none
        return
    try:
        with zipfile.ZipFile(path) as archive:
            packed = [item.filename for item in archive.infolist() if item.compress_type != zipfile.ZIP_STORED]
            damaged = None if packed else archive.testzip()
    except (zipfile.BadZipFile, OSError, EOFError) as error:
        raise InputError(path, "an undamaged file of torch", _first_line(error)) from error
    if packed:
        raise InputError(path, "an undamaged file of torch", f"compressed members ({packed[0]})")
    if damaged is not None:
        raise InputError(path, "an undamaged file of torch", f"a wrong checksum of {damaged}")


def read_tensors(path: Path) -> dict[str, Tensor]:
    """Return a file's state dict; InputError where it holds anything else."""
    found = read_torch(path)
    if not isinstance(found, dict) or not all(isinstance(value, Tensor) for value in found.values()):
        raise InputError(path, "a state dict: names and tensors", type(found).__name__)
    return found


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]
