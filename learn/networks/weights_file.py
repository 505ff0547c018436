"""Weight files: safetensors, which we write, and torch files of other programs, which are read as data only."""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from ...core.atomic_io import write_atomically
from ...core.errors import InputError

_EXPECTED = "an undamaged safetensors or torch file"
#: Metadata entry with the checksum of names, values and other metadata; safetensors itself has no checksum.
_CHECKSUM = "crc32"
#: Start of torch's error where a file holds more than tensors and numbers.
_NOT_DATA = "Weights only load failed"


def write_safetensors(path: Path, tensors: Mapping[str, Tensor], metadata: Mapping[str, str]) -> None:
    """Write tensors and texts as a safetensors file with a checksum; the file appears complete or not at all."""
    dense = {name: value.detach().cpu().contiguous() for name, value in tensors.items()}
    write_atomically(path, save(dense, {**metadata, _CHECKSUM: _checksum(dense, metadata)}))


def read_safetensors(path: Path) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Return the tensors and the metadata of a safetensors file; InputError where it is missing or damaged."""
    _check_is_file(path)
    try:
        with safe_open(path, framework="pt") as file:
            metadata = dict(file.metadata() or {})
            names = file.keys()
            tensors = {name: file.get_tensor(name).clone() for name in names}  # a copy, not a view of the mapped file
    except (SafetensorError, OSError) as error:
        raise InputError(path, _EXPECTED, _first_line(error)) from error
    expected = metadata.pop(_CHECKSUM, None)
    if expected is not None and expected != _checksum(tensors, metadata):
        raise InputError(path, _EXPECTED, "a wrong checksum")
    return tensors, metadata


def read_metadata(path: Path) -> dict[str, str]:
    """Return the metadata of a safetensors file alone; InputError where it is missing or damaged."""
    _check_is_file(path)
    try:
        with safe_open(path, framework="pt") as file:
            return dict(file.metadata() or {})
    except (SafetensorError, OSError) as error:
        raise InputError(path, _EXPECTED, _first_line(error)) from error


def is_safetensors(path: Path) -> bool:
    """Return whether a file begins as safetensors files do: 8 bytes of length, then a JSON object."""
    _check_is_file(path)
    with path.open("rb") as file:
        return file.read(9)[8:] == b"{"


def read_weights(path: Path) -> dict[str, Tensor]:
    """Return the state dict of a safetensors or torch file, which may have it as ``state_dict`` (Lightning).

    Raises
    ------
    InputError
        Where the file is missing or damaged, or holds anything but names and dense tensors.
    """
    if is_safetensors(path):
        return read_safetensors(path)[0]
    content = _read_torch(path)
    if isinstance(content, dict):
        content = content.get("state_dict", content)
    if not isinstance(content, dict) or not all(_is_named_tensor(*item) for item in content.items()):
        raise InputError(path, "a state dict: names and dense tensors", type(content).__name__)
    return content


def _read_torch(path: Path) -> Any:
    _check_archive(path)
    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # a damaged or hostile file can lead torch's reader to any exception
        found = _first_line(error)
        if found.startswith(_NOT_DATA):  # torch goes on to advise reading the file as code
            found = "something else, or more than tensors and numbers: code"
        raise InputError(path, _EXPECTED, found) from error


def _check_archive(path: Path) -> None:
    """Raise InputError where a zip archive, as torch writes them, is damaged or unpacks to more than its size.

    torch checks neither the checksums nor the sizes of the members.
    """
    if not zipfile.is_zipfile(path):  # torch before 1.6 wrote other files
        return
    try:
        with zipfile.ZipFile(path) as archive:
            packed = [item.filename for item in archive.infolist() if item.compress_type != zipfile.ZIP_STORED]
            damaged = None if packed else archive.testzip()
    except (zipfile.BadZipFile, OSError, EOFError) as error:
        raise InputError(path, _EXPECTED, _first_line(error)) from error
    if packed:
        raise InputError(path, _EXPECTED, f"compressed members ({packed[0]})")
    if damaged is not None:
        raise InputError(path, _EXPECTED, f"a wrong checksum of {damaged}")


def _check_is_file(path: Path) -> None:
    if not path.is_file():
        raise InputError(path, "a readable file", "a folder" if path.is_dir() else "none")


def _is_named_tensor(name: object, value: object) -> bool:
    is_dense = isinstance(value, Tensor) and value.layout == torch.strided and not value.is_meta
    return isinstance(name, str) and is_dense


def _checksum(tensors: Mapping[str, Tensor], metadata: Mapping[str, str]) -> str:
    """Return the CRC-32 of names, types, shapes, values and metadata, as 8 hexadecimal digits."""
    crc = zlib.crc32(json.dumps(metadata, sort_keys=True).encode())
    for name, value in sorted(tensors.items()):
        crc = zlib.crc32(f"{name} {value.dtype} {tuple(value.shape)}".encode(), crc)
        crc = zlib.crc32(value.reshape(-1).view(torch.uint8).numpy().tobytes(), crc)
    return f"{crc:08x}"


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]
