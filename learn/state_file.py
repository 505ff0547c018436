"""Files of torch: read as data, so that a file can run no code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from ..procedural.errors import InputError


def read_torch(path: Path) -> Any:
    """Return what a file of torch holds; InputError where it is missing, cut short, or holds more than data."""
    if not path.is_file():
        raise InputError(path, "a readable file", "none")
    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch's reader raises whatever a damaged or hostile file leads it to
        raise InputError(path, "an undamaged file of torch", _first_line(error)) from error


def read_tensors(path: Path) -> dict[str, Tensor]:
    """Return a file's state dict; InputError where it holds anything else."""
    found = read_torch(path)
    if not isinstance(found, dict) or not all(isinstance(value, Tensor) for value in found.values()):
        raise InputError(path, "a state dict: names and tensors", type(found).__name__)
    return found


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]
